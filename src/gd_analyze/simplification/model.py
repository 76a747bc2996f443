"""A simplified model: it evaluates torque, D, h and c, and states its accuracy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from gd_analyze.arrays import FloatArray, array_of, require_possible, set_points_last
from gd_analyze.errors import ModelError
from gd_analyze.formulas.formula import Formula, Legend
from gd_analyze.formulas.languages import Plain, Written
from gd_analyze.formulas.writing import element_formulas, factor_legend
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.terms import Torques
from gd_analyze.operations.program import OperationCount, Program, slopes_of
from gd_analyze.operations.trace import Trace, is_constant
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.accuracy import Accuracy, budget_notice
from gd_analyze.simplification.effort import THOROUGH
from gd_analyze.simplification.exact import ExactDynamics, ExactForm
from gd_analyze.simplification.level import Level, Terms
from gd_analyze.simplification.torque_program import torque_program
from gd_analyze.text import amount, html_of, joint_name, percent


def inertia_program(program: Program, n: int, symmetric: bool = False) -> Program:
    """D, row by row, as torque is linear in accelerations; for a `symmetric` D the upper half is computed."""
    trace, at_rest = Trace(), program.with_values(_zeros(n, "qd"))
    columns = [slopes_of(at_rest, {f"qdd{j + 1}": 1.0}, _zeros(n, "qdd"), trace) for j in range(n)]
    places = [(min(i, j), max(i, j)) if symmetric else (i, j) for i in range(n) for j in range(n)]
    return Program.of(trace, [columns[j][i] for i, j in places])


def coriolis_centrifugal_program(program: Program, n: int) -> Program:
    """h, homogeneous of degree 2 in the velocities: half its derivative along them (Euler)."""
    along: dict[str, float | str] = {f"qd{j + 1}": f"qd{j + 1}" for j in range(n)}
    trace = Trace()
    twice = slopes_of(program, along, _zeros(n, "qdd"), trace)
    return Program.of(trace, [trace.multiply(0.5, x) for x in twice])


def gravity_loading_program(program: Program, n: int) -> Program:
    """Torque at rest."""
    return program.with_values(_zeros(n, "qd", "qdd"))


def torque_derivatives_program(program: Program, n: int) -> Program:
    """Derivatives of the torques by q, then by qd, each row by row; those by qdd are D."""
    trace = Trace()
    by = [[slopes_of(program, {f"{name}{j + 1}": 1.0}, {}, trace) for j in range(n)] for name in ("q", "qd")]
    return Program.of(trace, [columns[j][i] for columns in by for i in range(n) for j in range(n)])


def coriolis_matrix_program(program: Program, n: int) -> Program:
    """C with C qd = h, row by row: half the derivative of h by qd, C_ij = sum_k h_ijk qd_k."""
    trace, h = Trace(), coriolis_centrifugal_program(program, n)
    columns = [slopes_of(h, {f"qd{j + 1}": 0.5}, {}, trace) for j in range(n)]
    return Program.of(trace, [columns[j][i] for i in range(n) for j in range(n)])


def forward_dynamics_program(program: Program, n: int, symmetric: bool) -> Program:
    """Accelerations from torques tau1, tau2, ...: D qdd = tau - h - c, by elimination without pivoting.

    D of an arm is positive definite, so that no pivot is zero; a symmetric D is factored as L d L^T.
    """
    trace = Trace()
    at_rest = program.with_values(_zeros(n, "qdd"))
    value, inertia = at_rest.folded(trace, {}), inertia_program(program, n, symmetric).folded(trace, {})
    rows = inertia_program(program, n, symmetric).outputs
    matrix = [[inertia(rows[n * i + j]) for j in range(n)] for i in range(n)]
    right = [
        trace.subtract(trace.record("input", f"tau{i + 1}"), value(at_rest.outputs[i])) for i in range(n)
    ]
    for k in range(n):
        for i in range(k + 1, n):
            if is_constant(matrix[i][k], 0.0):
                continue
            factor = trace.divide(matrix[i][k], matrix[k][k])
            # A symmetric matrix has equal entries below and above the diagonal.
            for j in range(i if symmetric else k + 1, n):
                matrix[i][j] = trace.subtract(matrix[i][j], trace.multiply(factor, matrix[k][j]))
            right[i] = trace.subtract(right[i], trace.multiply(factor, right[k]))
        if symmetric:
            for i in range(k + 1, n):
                for j in range(k + 1, i):
                    matrix[i][j] = matrix[j][i]
    found: list[object] = [0.0] * n
    for i in reversed(range(n)):
        for j in range(i + 1, n):
            right[i] = trace.subtract(right[i], trace.multiply(matrix[i][j], found[j]))
        found[i] = trace.divide(right[i], matrix[i][i])
    return Program.of(trace, found)


def _zeros(n: int, *names: str) -> dict[str, float]:
    return {f"{name}{j + 1}": 0.0 for name in names for j in range(n)}


# Most terms of equations shown in a notebook.
_MOST_SHOWN = 500


@dataclass(frozen=True, eq=False, kw_only=True)
class SimplifiedModel:
    """A simplified torque model of an arm, with its stated error.

    Parameters
    ----------
    level
        How far the dynamics were split, a value of `LEVELS`.
    form
        The exact dynamics that it approximates.
    terms
        Numbers by kept term, or by change, of the level's own type.
    program
        The torques as a straight-line program, from which D, h and c follow.
    refitted
        Whether kept coefficients were refitted to compensate for dropped ones.
    accuracy
        Budget, errors, and the states at which they were measured.
    provenance
        Versions, time, command.
    """

    level: Level
    form: ExactForm
    terms: Terms
    program: Program
    refitted: bool = False
    accuracy: Accuracy
    provenance: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"SimplifiedModel({self.arm.name!r}, level {self.level.name}, {self._summary})"

    @property
    def _summary(self) -> str:
        """Operations and error."""
        accuracy = self.accuracy
        joint = int(accuracy.shares.argmax())
        return (
            f"{self.operations.total} of {self.operations_full.total} operations, largest error "
            f"{percent(float(accuracy.shares[joint]))} of the {accuracy.asked.shares_of} (joint {joint + 1})"
        )

    def _repr_html_(self) -> str:
        """Its accuracy and equations, for a notebook."""
        errors = self.accuracy.errors
        columns = np.array([errors.peak_torque, self.accuracy.allowed, errors.largest, errors.rms])
        rows = [
            [joint_name(i + 1, joint.name), *(amount(x, joint.effort_unit) for x in columns[:, i].tolist())]
            for i, joint in enumerate(self.arm.joints)
        ]
        printer = Plain()
        formulas = self.formulas if len(self.terms) <= _MOST_SHOWN else ()
        lines = [printer.wrapped(formula, 100) for formula in formulas]
        legend = ", ".join(printer.legend(self.legend)) if formulas else ""
        return html_of(
            f"{self.arm.title or self.arm.name}: {self.size[0]} {self.level.keeps}",
            ["joint", "peak torque", "allowed error", "largest error", "RMS error"],
            rows,
            f"{self._summary}; budget {self.accuracy.budget}.",
            "\n".join([*lines, *filter(None, [legend])]),
        )

    @property
    def size(self) -> tuple[int, int]:
        """Number of its `level.keeps`, terms kept or steps simplified, and of all."""
        return self.level.size(self.form, self.terms)

    @property
    def arm(self) -> RobotArm:
        """The arm that it models."""
        return self.form.arm

    @property
    def drives(self) -> bool:
        """Whether drive inertia is part of it."""
        return self.form.drives

    @property
    def operations_full(self) -> OperationCount:
        """Operations of the cheapest exact torque known."""
        return self.form.operations

    @property
    def saves(self) -> bool:
        """Whether it takes fewer operations than the exact torque."""
        return self.operations.total < self.operations_full.total

    @property
    def is_exact(self) -> bool:
        """Whether it is the exact torque, with no saving and no error."""
        return not (self.saves or self.accuracy.errors.largest.any())

    @property
    def notice(self) -> str:
        """Joints whose budget is below friction or uncertainty, and what to do; "" if none."""
        return budget_notice(self.arm, self.accuracy)

    @cached_property
    def torques(self) -> Torques:
        """Its torques as harmonic terms; a ModelError if its level has none."""
        return self.level.torques(self.form, self.terms)

    @property
    def formulas(self) -> tuple[Formula, ...]:
        """Its torques as equations, one per joint."""
        return self.level.formulas(self.form, self.terms)

    @property
    def equations(self) -> Written:
        """Its D, J (drives), h and c in joint velocities, an element per line; prints, also in a notebook.

        Raises a ModelError if its level has no torque terms.
        """
        own = self.form.velocities.in_joint_velocities(self.torques)
        drives = self.arm.drive_inertia.tolist() if self.drives else ()
        factors = {factor for term in own for factor in term.monomial}
        return Written(element_formulas(own, drives), factor_legend(factors))

    @property
    def operations_in_joint_velocities(self) -> int:
        """Multiplications and additions of its torques without absolute velocities."""
        n = self.arm.n_joints
        alone = AbsoluteVelocities(tuple((joint,) for joint in range(n)), (1,) * n)
        own = self.form.velocities.in_joint_velocities(self.torques)
        return torque_program(alone, own, THOROUGH).count.total

    @property
    def legend(self) -> Legend:
        """Meaning of the names in its equations."""
        return self.level.legend(self.form, self.terms)

    @cached_property
    def operations(self) -> OperationCount:
        """Operations of one evaluation of all torques."""
        return self.program.count

    def torque(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """Generalized torque of the simplified model.

        Parameters
        ----------
        q, qd, qdd
            Joint variables, velocities and accelerations, rad (m) and per s, s^2, shape (..., n).

        Returns
        -------
        numpy.ndarray
            N m (N), shape (..., n).

        Raises
        ------
        ModelError
            If shapes do not fit, or a value is not a number, not finite or too large.
        """
        return self._evaluated(self.program, q, qd, qdd)

    def inertia(self, q: FloatArray) -> FloatArray:
        """Simplified D, kg m^2, shape (..., n, n); drive inertia, if included, is on the diagonal."""
        rows = self._evaluated(self.inertia_program, q)
        return rows.reshape(*rows.shape[:-1], self.arm.n_joints, self.arm.n_joints)

    def coriolis_centrifugal(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        """Simplified h, N m, shape (..., n)."""
        return self._evaluated(self.coriolis_centrifugal_program, q, qd)

    def gravity_loading(self, q: FloatArray) -> FloatArray:
        """Simplified c, N m, shape (..., n)."""
        return self._evaluated(self.gravity_loading_program, q)

    @cached_property
    def inertia_program(self) -> Program:
        """D as a program, its rows one after another."""
        return inertia_program(self.program, self.arm.n_joints, self.level.is_mechanical)

    @cached_property
    def coriolis_centrifugal_program(self) -> Program:
        """Program of h."""
        return coriolis_centrifugal_program(self.program, self.arm.n_joints)

    @cached_property
    def gravity_loading_program(self) -> Program:
        """The gravity loading c as a program."""
        return gravity_loading_program(self.program, self.arm.n_joints)

    def _evaluated(self, program: Program, *states: FloatArray) -> FloatArray:
        names, n = ("q", "qd", "qdd")[: len(states)], self.arm.n_joints
        arrays = [array_of(values, name, ModelError) for name, values in zip(names, states, strict=True)]
        for name, array in zip(names, arrays, strict=True):
            if array.shape[-1:] != (n,):
                what, expected = f"{name} does not fit the model of {self.arm.name}", f"shape (..., {n})"
                raise ModelError(what, where=name, expected=expected, found=str(array.shape))
            require_possible(array, name, ModelError)
        try:
            arrays = list(np.broadcast_arrays(*arrays))
        except ValueError:
            what, expected = f"{' and '.join(names)} differ in shape", "equal leading axes, or axes of 1"
            found = ", ".join(f"shape {array.shape}" for array in arrays)
            raise ModelError(what, where=", ".join(names), expected=expected, found=found) from None
        inputs = {
            f"{name}{i + 1}": row
            for name, array in zip(names, arrays, strict=True)
            for i, row in enumerate(set_points_last(array))
        }
        values = program.run(inputs)
        return np.ascontiguousarray(values.T).reshape(*arrays[0].shape[:-1], len(values))


def no_dearer(exact: ExactDynamics, model: SimplifiedModel) -> SimplifiedModel:
    """Replace a model that saves nothing by the exact one; the record of the search is kept."""
    if model.saves:
        return model
    everything = exactly(exact, model.level, model.accuracy.allowed, model.accuracy.budget)
    stated = everything.accuracy
    accuracy = replace(model.accuracy, errors=stated.errors, motions=stated.motions, norms=stated.norms)
    return replace(everything, accuracy=accuracy, provenance=model.provenance)


def exactly(exact: ExactDynamics, level: Level, allowed: FloatArray, budget: str) -> SimplifiedModel:
    """Make the exact model, in the fewest operations known."""
    form, errors = exact.form, exact.errors_of(exact.torque)
    model = SimplifiedModel(
        level=level,
        form=form,
        terms=level.terms(form),
        program=form.program,
        accuracy=Accuracy(allowed, budget, errors, exact.states.described, uncertainty=exact.uncertainty),
    )
    return measured(exact, model)


def measured(exact: ExactDynamics, model: SimplifiedModel) -> SimplifiedModel:
    """State the errors of a model's own program."""
    return replace(model, accuracy=exact.held(model.accuracy, model.torque(*exact.states.arrays)))
