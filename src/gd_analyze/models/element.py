"""Models at the text's own level: each effect of each element kept or dropped."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from gd_analyze.errors import ModelError
from gd_analyze.models.element_level import parts_of, trace_parts
from gd_analyze.models.simplified import SimplifiedModel
from gd_analyze.operations import OperationCount, Program
from gd_analyze.robots import RobotArm


@dataclass(frozen=True, eq=False, kw_only=True)
class ElementModel(SimplifiedModel):
    """A model of kept parts.

    Parameters
    ----------
    kept
        Labels of what is kept, see `gd_analyze.models.parts_of`.
    """

    kept: tuple[str, ...]

    def __post_init__(self) -> None:
        known = [part.label for part in parts_of(self.arm.n_joints)]
        unknown = sorted(set(self.kept) - set(known))
        if unknown:
            raise ModelError(
                f"{unknown[0]!r} is not a part of a {self.arm.n_joints}-joint arm",
                expected=f"labels such as {known[0]!r} or {known[-1]!r}",
            )

    @property
    def dropped(self) -> tuple[str, ...]:
        """Labels of what is left out."""
        kept = set(self.kept)
        return tuple(part.label for part in parts_of(self.arm.n_joints) if part.label not in kept)

    @cached_property
    def programs(self) -> dict[str, Program]:
        """Programs of the kept parts."""
        return part_programs(self.arm, self.kept, self.drives)


def part_programs(arm: RobotArm, kept: tuple[str, ...], drives: bool) -> dict[str, Program]:
    """Programs of some parts."""
    traced = trace_parts(arm)
    expressions = traced.keep(frozenset(kept), arm.drive_inertia if drives else None)
    return {name: Program.of(traced.trace, list(array.ravel())) for name, array in expressions.items()}


def part_operations(arm: RobotArm, kept: tuple[str, ...], drives: bool) -> OperationCount:
    """Operations of one torque evaluation with some parts."""
    traced = trace_parts(arm)
    torque = traced.keep(frozenset(kept), arm.drive_inertia if drives else None)["torque"]
    return Program.of(traced.trace, list(torque)).count


def operations_of_all_parts(arm: RobotArm, drives: bool) -> OperationCount:
    """Operations of one torque evaluation with every part kept."""
    return part_operations(arm, tuple(part.label for part in parts_of(arm.n_joints)), drives)
