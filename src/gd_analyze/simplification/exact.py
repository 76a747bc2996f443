"""An arm's exact dynamics: as sums of terms, and as the cheapest program known."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Set
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics import newton_euler_regrouped
from gd_analyze.files import shipped
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.identity import largest_difference
from gd_analyze.harmonics.lagrangian import energy_terms, torques_of_energies
from gd_analyze.harmonics.terms import DYNAMICS_QUANTITIES, Energies, Torques
from gd_analyze.harmonics.transform import Harmonics, harmonics_of
from gd_analyze.operations.functions import Functions, functions_of
from gd_analyze.operations.program import OperationCount, Program
from gd_analyze.operations.sharing import rewritten
from gd_analyze.operations.trace import Trace
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import describe_in_full
from gd_analyze.simplification.kept_program import Task, kept_program, program_name
from gd_analyze.simplification.torque_program import ROUGH, Effort, functions_of_terms, torque_program


@dataclass(frozen=True, kw_only=True)
class _ExactSettings:
    """Which exact programs are tried, and for how many joints and terms."""

    quick_joints: int = 6  # most joints of an arm whose terms are all counted at once
    # Outer joints of a longer arm whose terms are counted first, which takes tens of milliseconds.
    outer_joints: int = 4
    identified_joints: int = 8  # most joints for which identifying the exact form takes a second
    # Most joints for which sums of terms may take fewer operations than the recursion: the number of terms
    # grows with the fourth power of the number of joints, the operations of the recursion with the first.
    joints_of_sums: int = 4
    # Terms per operation known from which on their sums take more: of Panda and Gen3, a term takes 0.4 or
    # more.
    terms_per_operation: int = 5
    # Sums of terms with this multiple of the operations known may take fewer with shared parts.
    nearly_known: float = 1.2


_SETTINGS = _ExactSettings()
# Effort of sharing parts of sums: half a second.
_SHARING = Effort(250)

# Most torque terms that are written out to choose from: a second, for a general seven-joint arm of 30 000.
MOST_TERMS = 60_000
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
        Whether drive inertia is included.
    """

    arm: RobotArm
    drives: bool = False

    def __repr__(self) -> str:
        return f"ExactForm({self.arm!r}, drives={self.drives})"

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
    def program(self) -> Program:
        """Its torque in the fewest operations known: shipped, or found in a second or two and then cached."""

        def shortest() -> Program:
            programs = [self.recursion]
            if self.arm.n_joints <= _SETTINGS.joints_of_sums:
                programs += [
                    torque_program(self.velocities, self.torques, effort) for effort in (ROUGH, _SHARING)
                ]
            return rewritten(min(programs, key=lambda program: program.count.total))

        key = ["exact", describe_in_full(self.arm), self.drives]
        path = shipped("programs", ".json").get(shipped_name(self))
        values = None if path is None else json.loads(path.read_bytes())
        return kept_program(
            Task(program_name(key), self.arm.n_joints, shortest, self._is_short_torque, values)
        )

    @cached_property
    def functions(self) -> Functions:
        """D, h and c as functions of their own, each in the fewest operations known."""
        functions = functions_of(self.program, self.arm.n_joints, symmetric=True)
        if self.arm.n_joints > _SETTINGS.identified_joints:
            return functions
        operations_known = dict(
            zip(DYNAMICS_QUANTITIES, (program.count.total for program in functions), strict=True)
        )
        numbers = Counter(term.quantity for term in self.torques)
        of_few_terms = {
            quantity
            for quantity in operations_known
            if numbers[quantity] < _SETTINGS.terms_per_operation * operations_known[quantity]
        }
        nested = functions_of_terms(self.velocities, self._torques_of(of_few_terms), ROUGH)
        # Shared parts take time to find: only where nested sums come close.
        counts = dict(zip(DYNAMICS_QUANTITIES, (program.count.total for program in nested), strict=True))
        close = {
            quantity
            for quantity in of_few_terms
            if counts[quantity] < _SETTINGS.nearly_known * operations_known[quantity]
        }
        shared = functions_of_terms(self.velocities, self._torques_of(close), _SHARING)
        return Functions(
            *(
                min(programs, key=lambda program: program.count.total) if quantity in close else programs[0]
                for quantity, *programs in zip(DYNAMICS_QUANTITIES, functions, nested, shared, strict=True)
            )
        )

    def _torques_of(self, quantities: Set[str]) -> Torques:
        return {term: weight for term, weight in self.torques.items() if term.quantity in quantities}

    def _is_short_torque(self, program: Program) -> bool:
        """Whether a program computes the torque, in no more operations than the recursion."""
        recursion = self.recursion
        if program.count.total > recursion.count.total:
            return False
        difference, size = largest_difference(program, recursion, self.arm.is_revolute, REWRITTEN)
        return bool((difference <= REWRITTEN * size).all())

    @cached_property
    def recursion(self) -> Program:
        """Its torque by the cheapest formulation, folded, step by step, with drives."""
        trace, n = Trace(), self.arm.n_joints
        states = [trace.inputs(name, n) for name in ("q", "qd", "qdd")]
        torque = newton_euler_regrouped.torque(self.arm, *states)[:, 0]
        if self.drive_inertia is not None:
            torque = torque + self.drive_inertia * states[2][:, 0]
        return Program.of(trace, list(torque))

    @property
    def operations(self) -> OperationCount:
        """Operations of the exact torque: every saving is stated against them."""
        return self.program.count


def shipped_name(form: ExactForm) -> str:
    """Name of the file with an arm's exact program, if one is shipped: "puma560-drives"."""
    return f"{form.arm.name}-drives" if form.drives else form.arm.name


def too_many_terms(form: ExactForm) -> str:
    """Reason why exact equations are too long to choose terms from: "9 joints"; "" if they are not."""
    n = form.arm.n_joints
    if n > _SETTINGS.identified_joints:
        return f"{n} joints"
    return f"more than {MOST_TERMS} torque terms" if has_more_terms(form, MOST_TERMS) else ""


def has_more_terms(form: ExactForm, most: int) -> bool:
    """Whether the exact torque has more than `most` terms; those of the outer joints are counted first."""
    if "torques" in vars(form) or form.arm.n_joints <= _SETTINGS.quick_joints:
        return len(form.torques) > most
    arm = replace(form.arm, gravity=np.zeros(3), drives=(), dh_table=(), convention="", spread=None)
    outer = (
        ExactForm(replace(arm, joints=arm.joints[-count:], links=arm.links[-count:]))
        for count in range(_SETTINGS.outer_joints, arm.n_joints, 2)
    )
    return any(len(outer_form.torques) > most for outer_form in outer) or len(form.torques) > most
