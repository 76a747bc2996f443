"""Input of an export: functions of an arm with their programs, and constants stated with them."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from types import NoneType, SimpleNamespace
from typing import Any, NamedTuple, cast

import numpy as np

from gd_analyze.certification.certificate import Certificate
from gd_analyze.dynamics import composite_moments, newton_euler_link, newton_euler_regrouped
from gd_analyze.dynamics.base_parameters import BaseParameters, base_parameters
from gd_analyze.dynamics.drivetrain import (
    coulomb_friction,
    has_friction,
    viscous_coefficients,
    with_friction,
)
from gd_analyze.dynamics.friction import FRICTION_TERMS
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.dynamics.regrouped_links import regrouped
from gd_analyze.errors import ModelError, UsageError, require_type
from gd_analyze.exporting.angles import with_sums
from gd_analyze.exporting.names import LONGEST_NAME, identifier, identifiers
from gd_analyze.motions.states import states_in_box
from gd_analyze.operations.functions import (
    Functions,
    coriolis_matrix_program,
    forward_dynamics_program,
    torque_derivatives_program,
)
from gd_analyze.operations.program import OperationCount, Program
from gd_analyze.operations.sharing import rewritten
from gd_analyze.operations.trace import Trace
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.accuracy import STATED, AgainstLog
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.harmonic import ENERGY
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.torque_of_parameters import torque_of_parameters
from gd_analyze.text import rounded_up

_KINDS = ("q", "qd", "qdd", "tau", "payload", "parameters", "sin", "cos")
# Mass, centre of mass, and xx, yy, zz, xy, xz, yz of the inertia about it.
PAYLOAD_SIZE = 10


class Output(NamedTuple):
    """An output by its name in [FGL87], tau, D, h, c, and its shape; rows one after another."""

    name: str
    shape: tuple[int, ...]

    @property
    def size(self) -> int:
        """Number of its entries."""
        return math.prod(self.shape)


class Input(NamedTuple):
    """A number that a program reads: qd3 has kind qd and index 2."""

    name: str
    kind: str
    place: int


@dataclass(frozen=True)
class Function:
    """One function of positions, velocities and accelerations, or torques."""

    name: str
    meaning: str
    arguments: tuple[str, ...]  # those of q, qd, qdd, tau, payload and parameters that it takes
    outputs: tuple[Output, ...]  # in the order of the program's outputs
    program: Program
    n_parameters: int = 0  # size of its argument parameters

    @property
    def count(self) -> OperationCount:
        """Operations of one evaluation."""
        return self.program.count

    @property
    def with_sums(self) -> Function:
        """Compute sines and cosines of sums from those of the summands, see `angles.with_sums`."""
        return replace(self, program=with_sums(self.program))

    @property
    def inputs(self) -> list[Input]:
        """Inputs that the program needs, in their order."""
        used = {step.arguments[0] for step in self.program.steps if step.operation == "input"}
        matches = [re.fullmatch(r"([a-z]+)(\d+)", name) for name in used]
        inputs = [Input(match[0], match[1], int(match[2]) - 1) for match in matches if match]
        return sorted(inputs, key=lambda number: (_KINDS.index(number.kind), number.place))

    def width(self, argument: str) -> int:
        """Size of an argument: one number per joint, except for a payload and for parameters."""
        sizes = {"payload": PAYLOAD_SIZE, "parameters": self.n_parameters}
        return sizes.get(argument, self.outputs[0].shape[0])

    @property
    def unused(self) -> list[str]:
        """Arguments that the program does not need."""
        return [argument for argument in self.arguments if argument not in {x.kind for x in self.inputs}]


class Constant(NamedTuple):
    """Numbers, one per joint or base parameter."""

    meaning: str
    values: list[float]
    towards: float | None  # inf or -inf, towards which they may be rounded; None: to the nearest

    @property
    def in_single(self) -> Constant:
        """The same in single precision, with no bound smaller and no box larger."""
        near = np.array(self.values, dtype=np.float32)
        if self.towards is None:
            return self._replace(values=near.tolist())
        beyond = np.nextafter(near, np.float32(self.towards))
        short = near < self.values if self.towards > 0.0 else near > np.array(self.values)
        return self._replace(values=np.where(short, beyond, near).tolist())


@dataclass(frozen=True, eq=False)
class ExportInput:
    """Input of an export."""

    name: str  # prefix of all identifiers and files
    arm: RobotArm
    drives: bool  # whether the drives' inertia is included
    functions: tuple[Function, ...]  # torque, D, h and c, or the decomposition
    model: SimplifiedModel | None = None  # the simplified model; None for exact dynamics
    certificate: Certificate | None = None  # proven bound on its error over a box, if any
    unproven: str = "no certificate was asked for"  # reason why there is none
    base: BaseParameters | None = None  # the base parameters of which functions are exported

    @classmethod
    def of_model(
        cls, model: SimplifiedModel, name: str | None = None, certificate: Certificate | None = None
    ) -> ExportInput:
        """Export a simplified model; `UsageError` if the certificate is for another arm, or for a tube."""
        arm, n = model.arm, model.arm.n_joints
        if certificate is not None and (len(certificate.certified) != n or certificate.along is not None):
            raise UsageError(
                "the certificate does not fit the model",
                where="certificate",
                expected=f"bounds of {n} joints over a box",
                found=f"bounds of {len(certificate.certified)} joints over {certificate.where}",
                next_step="make one with gd.certify(model)",
            )
        functions = _torque_functions(model.program, n, model.functions)
        return cls(_prefix(name, arm.name), arm, model.drives, functions, model, certificate)

    @classmethod
    def of_exact(cls, form: ExactForm, name: str | None = None) -> ExportInput:
        """Export exact dynamics."""
        functions = _torque_functions(form.program, form.arm.n_joints, form.functions)
        return cls(_prefix(name, form.arm.name), form.arm, form.drives, functions)

    @classmethod
    def of_decomposition(cls, arm: RobotArm, name: str | None = None) -> ExportInput:
        """Export D and h by effect, and c, of the links alone."""
        suffix = "_decomposition"
        default = f"{identifier(arm.name)[: LONGEST_NAME - len(suffix)].rstrip('_')}{suffix}"
        return cls(_prefix(name, default), arm, False, (_decomposition_function(arm),))

    def with_functions(self, names: Sequence[str]) -> ExportInput:
        """Add functions beside the torque, D, h and c, by the names of `FURTHER`."""
        assert self.torque is not None  # checked by callers
        symmetric = self.model is None or self.model.has_terms
        skew = self.model is None or self.model.level is ENERGY
        base = base_parameters(self.arm, self.drives) if set(OF_PARAMETERS) & set(names) else None
        if self.model is not None and "forward" in names:
            _require_invertible(self.model)
        log = None if self.model is None else self.model.accuracy.log
        more = _further_functions(self.arm, self.torque.program, symmetric, skew=skew, log=log)
        functions = [more[name]() for name in FURTHER if name in more and name in names]
        if base is not None:
            model = self.model
            torque = _torque_of_parameters(base) if model is None else torque_of_parameters(model, base)
            functions += [_of_parameters(base, torque, name) for name in OF_PARAMETERS if name in names]
        return replace(self, functions=(*self.functions, *functions), base=base)

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.arm.n_joints

    @property
    def joints(self) -> tuple[str, ...]:
        """Identifiers of the joints, in their order."""
        return identifiers([joint.name for joint in self.arm.joints])

    @property
    def torque(self) -> Function | None:
        """The torque function, if exported."""
        return next((function for function in self.functions if function.name == "torque"), None)

    @property
    def constants(self) -> dict[str, Constant]:
        """Errors and box, for a controller to compare a state with."""
        constants = {}
        if self.base is not None:
            meaning, numbers = "the arm's base parameters", [parameter.number for parameter in self.base]
            constants["base_parameters"] = Constant(meaning, numbers, None)
        if self.model is not None:
            errors = self.model.accuracy.errors.largest.tolist()
            stated = "" if self.model.accuracy.measured else f", {STATED}"
            meaning = f"largest torque error at the states the model was fitted on{stated}"
            constants["sampled_error"] = Constant(meaning, errors, math.inf)
        if self.certificate is not None:
            box, bounds = self.certificate.box, [*map(up, self.certificate.certified.tolist())]
            meaning = "bound on the torque error at all states within the box"
            constants["error_bound"] = Constant(meaning, bounds, math.inf)
            for name, meaning, towards in (
                ("lower", "lowest positions", math.inf),
                ("upper", "highest positions", -math.inf),
                ("velocity", "largest velocities in both directions", -math.inf),
                ("acceleration", "largest accelerations in both directions", -math.inf),
            ):
                constants[name] = Constant(f"the box: {meaning}", getattr(box, name).tolist(), towards)
        return constants


def _torque_functions(torque: Program, n: int, functions: Functions) -> tuple[Function, ...]:
    """Torque of n joints, D, h and c."""
    inertia, h, c = functions
    rows = (
        ("torque", "generalized torque tau = D(q) qdd + h(q, qd) + c(q)", 3, Output("tau", (n,)), torque),
        ("inertia", "mass matrix D(q), row by row", 1, Output("D", (n, n)), inertia),
        ("coriolis_centrifugal", "Coriolis and centrifugal torque h(q, qd)", 2, Output("h", (n,)), h),
        ("gravity_loading", "gravity loading c(q)", 1, Output("c", (n,)), c),
    )
    arguments = ("q", "qd", "qdd")
    return tuple(
        Function(name, meaning, arguments[:k], (output,), program)
        for name, meaning, k, output, program in rows
    )


def arm_with_friction(arm: RobotArm, log: AgainstLog | None) -> RobotArm:
    """The arm with the friction it states or, if it states none, with that fitted to a log that it fits."""
    if has_friction(arm) or log is None or log.contradicted:
        return arm
    return with_friction(arm, np.column_stack([getattr(log, name) for name in FRICTION_TERMS]))


# Positions at which D of a model is tried before its forward dynamics are exported.
_TRIED_POSITIONS = 2000


def _require_invertible(model: SimplifiedModel) -> None:
    """Raise a ModelError for a model whose D is too far from the exact one to be solved for accelerations.

    With gamma below 1, D is positive definite at the states of the model. One for the arm's limits, or of
    unknown gamma, is tried at random positions as well.
    """
    arm, gamma = model.arm, model.accuracy.gamma
    eigenvalue = np.inf
    if gamma is None or "trajectory" not in model.accuracy.fitted_on:
        inertia = model.inertia(states_in_box(arm, _TRIED_POSITIONS).q)
        eigenvalue = float(np.linalg.eigvalsh((inertia + inertia.swapaxes(1, 2)) / 2.0).min())
    if model.is_torque_only or not eigenvalue > 0.0:
        states = f"D has the eigenvalue {eigenvalue:.3g} within the arm's limits"
        raise ModelError(
            f"the model of {arm.name} is for feedforward only: forward dynamics divide by its D",
            where="what forward",
            expected="gamma below 1, and a positive definite D",
            found=f"gamma {gamma:.3g}" if gamma is not None and model.is_torque_only else states,
            next_step="take a smaller budget, or export the exact arm's: `gd-analyze export ROBOT`",
        )


# Functions of the base parameters.
OF_PARAMETERS = ("regressor", "parameters")
# Functions that may be added to torque, D, h and c.
FURTHER = ("derivatives", "coriolis_matrix", "forward", "payload", "friction", *OF_PARAMETERS)


def _further_functions(
    arm: RobotArm, torque: Program, symmetric: bool, *, skew: bool, log: AgainstLog | None
) -> dict[str, Callable[[], Function]]:
    n = arm.n_joints
    square = (n, n)

    def derivatives() -> Function:
        meaning = "derivatives of the torque by q and by qd, row by row; that by qdd is D"
        outputs = Output("dtau_dq", square), Output("dtau_dqd", square)
        program = rewritten(torque_derivatives_program(torque, n))
        return Function("torque_derivatives", meaning, ("q", "qd", "qdd"), outputs, program)

    def coriolis_matrix() -> Function:
        property_ = "; dD/dt - 2 C is skew-symmetric" if skew else ""
        meaning = f"Coriolis matrix C(q, qd) with C qd = h{property_}, row by row"
        program = rewritten(coriolis_matrix_program(torque, n))
        return Function("coriolis_matrix", meaning, ("q", "qd"), (Output("C", square),), program)

    def forward() -> Function:
        meaning = "accelerations qdd from torques tau"
        program = forward_dynamics_program(torque, n, symmetric)
        return Function("forward_dynamics", meaning, ("q", "qd", "tau"), (Output("qdd", (n,)),), program)

    def payload() -> Function:
        meaning = (
            "torque of a payload at the end effector, to be added to the torque: mass, x, y, z of its "
            "centre of mass, and xx, yy, zz, xy, xz, yz of its inertia about this centre"
        )
        program = rewritten(_payload_program(arm))
        arguments = ("q", "qd", "qdd", "payload")
        return Function("payload_torque", meaning, arguments, (Output("tau_payload", (n,)),), program)

    def friction() -> Function:
        meaning = (
            "Coulomb and viscous friction of the drives at the joints, to be added to the torque; 0 at rest"
        )
        rubbing = arm_with_friction(arm, log)
        if not has_friction(rubbing):
            raise UsageError(
                f"nothing states the friction of {arm.name}",
                where="what friction",
                next_step="fit it to a log: `gd-analyze ROBOT LOG --fit-friction` or `gd-analyze identify`",
            )
        levels, trace = coulomb_friction(rubbing, np.array([np.ones(n), -np.ones(n)])), Trace()
        terms, slopes = [], viscous_coefficients(rubbing)
        for i, (forward, backward, slope) in enumerate(zip(*levels, slopes, strict=True)):
            qd = trace.record("input", f"qd{i + 1}")
            sign = trace.sign(qd)
            mean = trace.multiply(trace.multiply(sign, sign), 0.5 * float(forward + backward))
            level = trace.add(trace.multiply(sign, 0.5 * float(forward - backward)), mean)
            terms.append(trace.add(trace.multiply(qd, float(slope)), level))
        program = Program.of(trace, terms)
        return Function("friction", meaning, ("qd",), (Output("tau_friction", (n,)),), program)

    return dict(zip(FURTHER, (derivatives, coriolis_matrix, forward, payload, friction), strict=False))


def _of_parameters(base: BaseParameters, torque: Program, name: str) -> Function:
    """A torque as a function of the base parameters, or per unit of each of them."""
    n, count, arguments = base.arm.n_joints, len(base), ("q", "qd", "qdd")
    if name == "parameters":
        meaning = "torque of an arm of this geometry with other base parameters"
        outputs = (Output("tau", (n,)),)
        return Function(
            "torque_of_parameters", meaning, (*arguments, "parameters"), outputs, rewritten(torque), count
        )
    trace, columns = Trace(), []
    for k in range(count):
        value = torque.folded(trace, {f"parameters{j + 1}": float(j == k) for j in range(count)})
        columns.append([value(row) for row in torque.outputs])
    program = Program.of(trace, [column[i] for i in range(n) for column in columns])
    meaning = "regressor Y(q, qd, qdd): the torque is its product with the base parameters, row by row"
    return Function("regressor", meaning, arguments, (Output("Y", (n, count)),), program)


def _torque_of_parameters(base: BaseParameters) -> Program:
    """Torque by the recursion whose links have inputs for base parameters, and nothing else."""
    arm, n, trace = base.arm, base.arm.n_joints, Trace()
    of_links: list[dict[str, Any]] = [{} for _ in range(n)]
    for parameter, value in zip(base, trace.inputs("parameters", len(base))[:, 0], strict=True):
        of_links[parameter.link - 1][parameter.kind] = value
    links = []
    for link, values in zip(regrouped(arm).links, of_links, strict=True):
        first = np.array([values.get(f"m{a}", 0.0) for a in "xyz"], dtype=object)
        second = [[values.get("P" + "".join(sorted(a + b)), 0.0) for b in "xyz"] for a in "xyz"]
        mass, moments = np.array([values.get("m", 0.0)], dtype=object), np.array(second, dtype=object)
        links.append(replace(link, mass=mass, first=first, second=moments, is_round=False))
    states = [trace.inputs(name, n) for name in ("q", "qd", "qdd")]
    torque = newton_euler_regrouped.torque_of_links(replace(regrouped(arm), links=tuple(links)), *states)
    drives = [values.get("J", 0.0) * qdd for values, qdd in zip(of_links, states[2][:, 0], strict=True)]
    return Program.of(trace, [tau + drive for tau, drive in zip(torque[:, 0], drives, strict=True)])


def _payload_program(arm: RobotArm) -> Program:
    """Torque of a body at the end effector: the Newton-Euler recursion of an arm without mass."""
    n, trace = arm.n_joints, Trace()
    mass, x, y, z, *moments = trace.inputs("payload", PAYLOAD_SIZE)[:, 0]
    xx, yy, zz, xy, xz, yz = moments
    turn = arm.tip_frame.rotation
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    massless = (0.0,) * (n - 1)
    carried = SimpleNamespace(
        **{name: getattr(arm, name) for name in ("joints", "links", "gravity_vector", "is_revolute")},
        mass=np.array([*massless, mass])[:, None],
        com=[*np.zeros((n - 1, 3)), turn @ np.array([x, y, z]) + arm.tip_frame.translation],
        inertia_com=[*np.zeros((n - 1, 3, 3)), turn @ tensor @ turn.T],
    )
    inputs = [trace.inputs(name, n) for name in ("q", "qd", "qdd")]
    return Program.of(trace, newton_euler_link.torque(cast(RobotArm, carried), *inputs)[:, 0].tolist())


def _decomposition_function(arm: RobotArm) -> Function:
    """D and h by effect, and c, of the links alone. [FGL87] Eqs. (3.4-25) to (3.4-28)."""
    n, trace = arm.n_joints, Trace()
    q, qd = trace.inputs("q", n), trace.inputs("qd", n)
    moments = composite_moments.composite_moments(arm, solve_kinematics(arm, q))
    inertia = composite_moments.inertia(moments)
    h, _ = composite_moments.coriolis_centrifugal(moments, composite_moments.brackets(moments), qd)
    c = composite_moments.gravity_loading(arm, moments)
    values = {"D_tran": inertia[0], "D_rot": inertia[1], "h_tran": h[0], "h_rot": h[1], "c": c}
    return Function(
        "decomposition",
        "D(q) and h(q, qd) by effect, translation and rotation, and c(q), of the links without drives",
        ("q", "qd"),
        tuple(Output(name, value.shape[:-1]) for name, value in values.items()),
        Program.of(trace, [x for value in values.values() for x in value[..., 0].ravel().tolist()]),
    )


def up(value: float) -> float:
    """Round up to six digits."""
    return value if float(f"{value:.6g}") == value else rounded_up(value, 6)


def _prefix(name: str | None, default: str) -> str:
    """The given name, which must be an identifier, or one from the default."""
    require_type(name, (str, NoneType), "name", "a name, or None")
    if name is not None and identifier(name) != name:
        raise UsageError(
            "the name is not an identifier in every language",
            where="name",
            expected=f"at most {LONGEST_NAME} ASCII letters, digits and single underscores, a letter first, "
            "and not a reserved word of a language or its library",
            found=name,
            next_step=f"{identifier(name)} would do",
        )
    return name or identifier(default)
