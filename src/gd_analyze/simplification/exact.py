"""An arm's exact dynamics: as sums of terms, and as the cheapest program known."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from gd_analyze.arguments import require_flags_of
from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics import newton_euler_regrouped
from gd_analyze.files import shipped
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.identity import largest_difference
from gd_analyze.harmonics.lagrangian import energy_terms, torques_of, torques_of_energies
from gd_analyze.harmonics.squares import Squares
from gd_analyze.harmonics.terms import (
    DYNAMICS_QUANTITIES,
    Energies,
    EnergyTerm,
    Torques,
    TorqueTerm,
    Velocity,
)
from gd_analyze.harmonics.transform import Harmonics, harmonics_of
from gd_analyze.operations.functions import (
    Functions,
    bias_program,
    functions_of,
    gravity_loading_program,
    inertia_program,
    motion_program,
)
from gd_analyze.operations.program import OperationCount, Program, fewest
from gd_analyze.operations.sharing import rewritten
from gd_analyze.operations.trace import Trace
from gd_analyze.robots.arm import USUAL_GRAVITY, RobotArm
from gd_analyze.robots.bodies import MOST_JOINTS_WITH_TERMS
from gd_analyze.robots.description import fingerprint
from gd_analyze.simplification.kept_program import Programs, Task, kept_programs, program_name
from gd_analyze.simplification.torque_program import ROUGH, program_of_terms, torque_program

_QUICK_JOINTS = 6  # most joints of an arm whose terms are all counted at once
# Outer joints of a longer arm whose terms are counted first, which takes tens of milliseconds.
_OUTER_JOINTS = 4
# Most joints for which sums of terms may take fewer operations than the recursion: the number of terms
# grows with the fourth power of the number of joints, the operations of the recursion with the first.
_JOINTS_OF_SUMS = 4
# Terms per operation known from which on their sums take more: of Panda and Gen3, a term takes 0.4 or
# more.
_TERMS_PER_OPERATION = 5
# Most terms of D or c, or of a short arm's torque, whose sums share parts: half a second.
_SHARED_TERMS = 250

# Most torque terms that are written out to choose from: a second, for a general seven-joint arm of 30 000.
MOST_TERMS = 60_000
# Relative difference up to which a constant of D is the drive's inertia alone.
_EQUAL_DRIVES = 1e-12
# Rewriting changes rounding: by 1e-15 of a joint's torque for up to eight joints.
REWRITTEN = 1e-11


@dataclass(frozen=True, eq=False)
class ExactForm:
    """An arm's exact dynamics, as sums of terms and as programs; each is computed on first use.

    `SimplifiedModel.form` and `ExactDynamics.form` have one.

    Parameters
    ----------
    arm
        The arm.
    drives
        Whether drive inertia is included; an ArmError if the arm describes no drives.
    """

    arm: RobotArm
    drives: bool = False

    def __post_init__(self) -> None:
        require_flags_of(self)
        if self.drives:
            _ = self.arm.drive_inertia  # an ArmError, unless the arm describes drives

    def __repr__(self) -> str:
        return f"ExactForm({self.arm!r}, drives={self.drives})"

    def of_arm(self, arm: RobotArm) -> ExactForm:
        """The same dynamics of an arm that differs only in what they do not depend on, such as friction."""
        assert fingerprint(arm, self.drives) == fingerprint(self.arm, self.drives)
        form = copy(self)
        object.__setattr__(form, "arm", arm)
        return form

    @property
    def drive_inertia(self) -> FloatArray | None:
        """Drive inertia at the joints, shape (n,); None if not included."""
        return self.arm.drive_inertia if self.drives else None

    @cached_property
    def velocities(self) -> AbsoluteVelocities:
        """Velocities and accelerations in which parallel axes are summed."""
        return AbsoluteVelocities.of(self.arm)

    @cached_property
    def harmonics(self) -> Harmonics:
        """The dynamics as sums of basis functions, by effect and link."""
        return harmonics_of(self.arm)

    @cached_property
    def energies(self) -> Energies:
        """Every term of the energies and its coefficient."""
        return energy_terms(self.harmonics, self.drive_inertia)

    @cached_property
    def torques(self) -> Torques:
        """Every torque term and its weight."""
        return torques_of_energies(self.energies, self.velocities)

    @cached_property
    def upper_torques(self) -> Torques:
        """Those of h', of c' and of the upper triangle of D', as D' is symmetric."""
        return {term: weight for term, weight in self.torques.items() if term.is_upper}

    @cached_property
    def in_joint_velocities(self) -> ExactForm:
        """The same dynamics with terms in the joints' own velocities; equal if no axes are parallel."""
        return JointForm(self.arm, self.drives, absolute=self) if self.velocities.before else self

    def torques_of_energy(self, term: EnergyTerm) -> Torques:
        """Torque terms of one energy term with unit coefficient."""
        return torques_of(term, self.velocities)

    @cached_property
    def program(self) -> Program:
        """Its torque in the fewest operations known: shipped, or found in a second or two and then cached."""
        (program,) = self._kept(["torque"], self._shortest_torque, (self.recursion,))
        return program

    @cached_property
    def functions(self) -> Functions:
        """D, h and c as functions of their own, each in the fewest operations known.

        They are shipped, or found in some seconds and then cached.
        """
        references = self._functions_of_recursion
        return Functions(*self._kept(DYNAMICS_QUANTITIES, self._shortest_functions, references))

    @property
    def program_at_hand(self) -> Program:
        """Its torque in the fewest operations known without a search: shipped, or the recursion."""
        return self.program if self._is_shipped else self.recursion

    @property
    def functions_at_hand(self) -> Functions:
        """D, h and c likewise."""
        return self.functions if self._is_shipped else self._functions_of_recursion

    @cached_property
    def squares(self) -> Squares:
        """The form of squares in which D, h and c are printed, beside the drives' inertia."""
        exact = dict(self.velocities.in_joint_velocities(self.torques))
        for joint, inertia in enumerate(() if self.drive_inertia is None else self.drive_inertia.tolist()):
            constant = TorqueTerm(joint, (Velocity(2, joint),), ())
            if inertia and abs(exact.get(constant, inertia) - inertia) <= _EQUAL_DRIVES * inertia:
                exact.pop(constant, None)
        return Squares.of(exact)

    def printed(self, torques: Torques) -> Torques:
        """Torques as D, h and c print: in joint velocities, with squares in one form."""
        return self.squares.sum(self.velocities.in_joint_velocities(torques))

    def _kept(
        self, names: Sequence[str], write: Callable[[], Programs], references: Sequence[Program]
    ) -> Programs:
        """Programs as shipped, from the cache, or newly written; they compute what the references do."""

        def are_right(programs: Programs) -> bool:
            pairs = zip(programs, references, strict=True)
            return all(_is_shorter_form(*pair, self.arm.is_revolute) for pair in pairs)

        path = shipped("programs", ".json").get(shipped_name(self))
        values = None if path is None else [json.loads(path.read_bytes())[name] for name in names]
        key = program_name(["exact", *names, fingerprint(self.arm, self.drives)])
        return kept_programs(Task(key, self.arm.n_joints, write, are_right, values))

    def _shortest_torque(self) -> Programs:
        programs = [self.recursion]
        if self.arm.n_joints <= _JOINTS_OF_SUMS:
            programs += [
                torque_program(self.velocities, self.torques, effort) for effort in (ROUGH, _SHARED_TERMS)
            ]
        if not self.arm.gravity_vector.any():
            programs.append(motion_program(self._with_gravity.program))
        return (rewritten(fewest(programs)),)

    def _shortest_functions(self) -> Programs:
        """D, h and c; D depends on no gravity, c on no drives, and h on neither."""
        own = functions_to_rewrite(self, self.program)
        if not np.array_equal(self.arm.gravity_vector, USUAL_GRAVITY):
            level = self._with_gravity.functions
            h = fewest([level.coriolis_centrifugal, own.coriolis_centrifugal])
            return fewest([level.inertia, own.inertia]), h, rewritten(own.gravity_loading)
        if self.drives:
            links = ExactForm(self.arm).functions
            h = fewest([links.coriolis_centrifugal, own.coriolis_centrifugal])
            return rewritten(own.inertia), h, fewest([links.gravity_loading, own.gravity_loading])
        return tuple(map(rewritten, own))

    @property
    def _with_gravity(self) -> ExactForm:
        """The same arm under usual gravity, which may be shipped: D and h depend on none."""
        return ExactForm(replace(self.arm, gravity_vector=np.array(USUAL_GRAVITY)), self.drives)

    @cached_property
    def recursion(self) -> Program:
        """Its torque by the cheapest formulation, folded, step by step, with drives."""
        trace, n = Trace(), self.arm.n_joints
        states = [trace.inputs(name, n) for name in ("q", "qd", "qdd")]
        torque = newton_euler_regrouped.torque(self.arm, *states)[:, 0]
        if self.drive_inertia is not None:
            torque = torque + self.drive_inertia * states[2][:, 0]
        return Program.of(trace, list(torque))

    @cached_property
    def _functions_of_recursion(self) -> Functions:
        return functions_of(self.recursion, self.arm.n_joints, symmetric=True)

    @property
    def _is_shipped(self) -> bool:
        return shipped_name(self) in shipped("programs", ".json")

    @property
    def operations(self) -> OperationCount:
        """Operations of the exact torque: every saving is stated against them."""
        return self.program.count


def functions_to_rewrite(form: ExactForm, torque: Program) -> Functions:
    """D, h and c as they follow from a torque's program or, in fewer operations, from their own terms."""
    n = form.arm.n_joints
    bias = rewritten(bias_program(torque, n))
    inertia = [inertia_program(torque, n, symmetric=True)]
    c = [gravity_loading_program(bias, n), gravity_loading_program(torque, n)]
    if not too_many_terms(form):
        inertia += _of_own_terms(form, "inertia", inertia[0].count.total)
        c += _of_own_terms(form, "gravity_loading", c[0].count.total)
    return Functions(fewest(inertia), motion_program(bias), fewest(c))


def _of_own_terms(form: ExactForm, quantity: str, operations: int) -> Iterator[Program]:
    """Programs of the terms of D or c in absolute and in joint velocities, unless they are very many."""
    torques = {term: weight for term, weight in form.torques.items() if term.quantity == quantity}
    if len(torques) > _TERMS_PER_OPERATION * operations:
        return
    effort = _SHARED_TERMS
    yield program_of_terms(quantity, form.velocities, torques, effort)
    if form.velocities.before:
        in_joints = AbsoluteVelocities.of_joints(form.arm.n_joints)
        yield program_of_terms(quantity, in_joints, form.velocities.in_joint_velocities(torques), effort)


def _is_shorter_form(program: Program, reference: Program, is_revolute: Sequence[bool]) -> bool:
    """Whether a program computes what a reference does, in no more operations."""
    if program.count.total > reference.count.total:
        return False
    difference, size = largest_difference(program, reference, is_revolute, REWRITTEN)
    # An output that is zero up to round-off has that of the others.
    return bool((difference <= REWRITTEN * size.max()).all())


@dataclass(frozen=True, eq=False, repr=False)
class JointForm(ExactForm):
    """Exact dynamics with terms in the joints' own velocities; all else is that of the absolute ones."""

    absolute: ExactForm = field(kw_only=True)

    @cached_property
    def velocities(self) -> AbsoluteVelocities:
        """Every joint by itself."""
        return AbsoluteVelocities.of_joints(self.arm.n_joints)

    @cached_property
    def torques(self) -> Torques:
        """Every torque term and its weight."""
        return self.absolute.velocities.in_joint_velocities(self.absolute.torques)

    def torques_of_energy(self, term: EnergyTerm) -> Torques:
        """Torque terms of one energy term with unit coefficient."""
        return self.absolute.velocities.in_joint_velocities(self.absolute.torques_of_energy(term))

    @property
    def harmonics(self) -> Harmonics:
        """The dynamics as sums of basis functions."""
        return self.absolute.harmonics

    @property
    def energies(self) -> Energies:
        """Every term of the energies, in absolute velocities, and its coefficient."""
        return self.absolute.energies

    @property
    def program(self) -> Program:
        """Its torque in the fewest operations known."""
        return self.absolute.program

    @property
    def functions(self) -> Functions:
        """D, h and c in the fewest operations known."""
        return self.absolute.functions

    @property
    def squares(self) -> Squares:
        """The form of squares."""
        return self.absolute.squares


def shipped_name(form: ExactForm) -> str:
    """Name of the file with an arm's exact program, if one is shipped: "puma560-drives"."""
    return f"{form.arm.name}-drives" if form.drives else form.arm.name


def too_many_terms(form: ExactForm) -> str:
    """Reason why exact equations are too long to choose terms from: "9 joints, more than 8"; or ""."""
    n = form.arm.n_joints
    if n > MOST_JOINTS_WITH_TERMS:
        return f"{n} joints, more than {MOST_JOINTS_WITH_TERMS}"
    return f"more than {MOST_TERMS} torque terms" if has_more_terms(form, MOST_TERMS) else ""


def has_more_terms(form: ExactForm, most: int) -> bool:
    """Whether the exact torque has more than `most` terms; those of the outer joints are counted first."""
    if "torques" in vars(form) or form.arm.n_joints <= _QUICK_JOINTS:
        return len(form.torques) > most
    arm = replace(form.arm, gravity_vector=np.zeros(3), drives=(), dh_table=(), spread=None)
    outer = (
        ExactForm(replace(arm, joints=arm.joints[-count:], links=arm.links[-count:]))
        for count in range(_OUTER_JOINTS, arm.n_joints, 2)
    )
    return any(len(outer_form.torques) > most for outer_form in outer) or len(form.torques) > most
