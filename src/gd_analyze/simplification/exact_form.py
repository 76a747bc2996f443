"""An arm's exact dynamics as sums of terms, and as the shortest program known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from gd_analyze.arrays import ROUND_OFF_SHARE, Array, FloatArray
from gd_analyze.dynamics import newton_euler_regrouped
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.lagrangian import energy_terms, torques_of_energies
from gd_analyze.harmonics.terms import Energies, Torques
from gd_analyze.harmonics.transform import Harmonics, harmonics_of
from gd_analyze.operations.program import OperationCount, Program
from gd_analyze.operations.sharing import rewritten
from gd_analyze.operations.trace import Trace
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import describe_in_full
from gd_analyze.simplification.effort import ROUGH, Effort, Task, inputs_of, kept_programs, named, some_states
from gd_analyze.simplification.recursion import Quantity, Recursion, components
from gd_analyze.simplification.torque_program import torque_program

# Outer joints looked at first, to count terms: tens of milliseconds.
_OUTER_JOINTS = 4
# Torque terms up to which terms are worth choosing from: a seven-joint arm of general make has tens of
# thousands, and any model of them takes more operations than its recursion.
MOST_TERMS = 2000
# Joints up to which identifying the exact form takes a second, and sums of terms may take fewer operations
# than the recursion: terms grow with the fourth power of the joints, its operations with the first.
_MOST_JOINTS, _FEW_JOINTS = 8, 4
# Of so many terms at most it is looked for what they share: half a second.
_SHARED = Effort(250)
# Rewriting adds roundings: a program may differ by so many times what those of a formulation explain.
_REWRITTEN = 8


@dataclass(frozen=True, eq=False)
class ExactForm:
    """An arm's exact dynamics, with drive inertia or without; each form is made when first used."""

    arm: RobotArm
    drives: bool = False

    def __repr__(self) -> str:
        return f"ExactForm({self.arm!r}, drives={self.drives})"

    @property
    def drive_inertia(self) -> FloatArray | None:
        """Drive inertia at the joints, shape (n,); None where it does not act."""
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
    def program(self) -> Program:
        """Its torque in the fewest operations known; a second or two, and kept for the next run."""

        def shortest() -> list[Program]:
            ways = [self.recursion.program]
            if self.arm.n_joints <= _FEW_JOINTS:
                ways += [torque_program(self.velocities, self.torques, effort) for effort in (ROUGH, _SHARED)]
            return [rewritten(min(ways, key=lambda way: way.count.total))]

        def are_right(programs: Sequence[Program]) -> bool:
            return len(programs) == 1 and self._is_given_by(*programs)

        key = ["exact", describe_in_full(self.arm), self.drives]
        return kept_programs(Task(named(key), self.arm.n_joints, shortest, are_right))[0]

    def _is_given_by(self, program: Program) -> bool:
        """Whether a program gives the torque at some states, within what roundings explain."""
        states = some_states(self.arm.n_joints)
        exact = torque_of(self.arm, states, drives=self.drives)
        bound = _REWRITTEN * round_off_bounds(self.arm, *states.arrays)["torque"]
        error = np.abs(program.run(inputs_of(states)).T - exact).max()
        return bool(error <= bound + ROUND_OFF_SHARE * np.abs(exact).max())

    @cached_property
    def recursion(self) -> Recursion:
        """Its torque by the cheapest formulation as it folds, step by step, drives added."""
        trace, n = Trace(), self.arm.n_joints
        states = [trace.inputs(name, n) for name in ("q", "qd", "qdd")]
        quantities: list[tuple[Quantity, Any]] = []

        def note(link: int, values: Mapping[str, Array]) -> None:
            for kind, value in values.items():
                quantities.extend(components(kind, link, value))

        torque = newton_euler_regrouped.torque(self.arm, *states, observe=note)[:, 0]
        if self.drive_inertia is not None:
            torque = torque + self.drive_inertia * states[2][:, 0]
        quantities += [(Quantity("tau", i), value) for i, value in enumerate(torque)]
        return Recursion(tuple(trace.expressions), tuple(torque), tuple(quantities))

    @property
    def operations(self) -> OperationCount:
        """What the exact torque costs: every saving is stated against this."""
        return self.program.count


def too_many_terms(form: ExactForm) -> str:
    """What exact equations have too many of to choose terms from them: "9 joints"; "" if nothing."""
    n = form.arm.n_joints
    if n > _MOST_JOINTS:
        return f"{n} joints"
    return f"more than {MOST_TERMS} torque terms" if has_more_terms(form, MOST_TERMS) else ""


def has_more_terms(form: ExactForm, most: int) -> bool:
    """Whether the exact torque has more than `most` terms; those of the outer joints alone are told first."""
    if "torques" in vars(form):
        return len(form.torques) > most
    arm = replace(form.arm, gravity=np.zeros(3), drives=(), dh_table=(), convention="")
    outer = (
        ExactForm(replace(arm, joints=arm.joints[-count:], links=arm.links[-count:]))
        for count in range(_OUTER_JOINTS, arm.n_joints)
    )
    return any(len(each.torques) > most for each in outer) or len(form.torques) > most
