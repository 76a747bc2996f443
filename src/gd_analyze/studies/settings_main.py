"""How to analyse, what came before, and whom to tell."""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass, fields
from typing import Any, Protocol

from gd_analyze.certification.tube import Margin
from gd_analyze.errors import UsageError
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.level import Level
from gd_analyze.simplification.levels import level_named


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How the main job analyses an arm along a trajectory.

    Parameters
    ----------
    budget
        Allowed torque error, or its text such as "1% or 10% friction"; 1 % of each joint's peak torque by
        default.
    level, refit, operations
        How to simplify, see `gd_analyze.simplification.search_options.SearchOptions`; by default the level
        that takes the fewest operations of
        those that are promising for the arm.
    drives
        Include drive inertia as a separate contribution; by default where the arm describes drives.
    margin
        How far states may be from the motion for which the model's errors are bounded, or its text such as
        "1deg,1mm,qd=2%,qdd=5%", which is the default.
    fit_friction
        Say which friction, fitted to measured torques beside the model, explains them best; none of it
        becomes part of the model.
    christoffel, by_link, terms
        What else to keep of the decomposition, see `decompose`.

    Raises
    ------
    UsageError
        If there is no such level, budget or margin are not understood, or the budget is of the norm.
    """

    budget: Budget | str | None = None
    level: str | Level | None = None
    refit: bool = False
    operations: int | None = None
    drives: bool | None = None
    margin: Margin | str | None = None
    fit_friction: bool = False
    christoffel: bool = True
    by_link: bool = False
    terms: bool = False

    def __post_init__(self) -> None:
        budget = Budget.of(self.budget).require_per_joint(
            "the main job's results, which show every joint beside what it is allowed,",
            'gd-analyze simplify ROBOT TRAJECTORY --budget "..." takes it',
        )
        object.__setattr__(self, "budget", budget)
        object.__setattr__(self, "margin", Margin.of(self.margin))
        if self.level is not None:
            object.__setattr__(self, "level", level_named(self.level))

    @property
    def asked(self) -> Budget:
        """The budget as a value."""
        return Budget.of(self.budget)

    def described(self) -> dict[str, Any]:
        """All of it as JSON values."""
        values = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        level = None if self.level is None else level_named(self.level).name
        return values | {"budget": self.asked.entries, "level": level, "margin": str(self.margin)}

    def unusual(self) -> list[str]:
        """Options that are off their defaults, as words of a file name: "budget-0.5pct", "refit"."""
        own, usual = self.described(), Settings().described()
        values = {name: value for name, value in own.items() if value != usual[name]}
        if "budget" in values:
            values["budget"] = str(self.asked).replace("%", "pct")
        return [_word(name.replace("_", "-"), value) for name, value in values.items()]


def settings_of(settings: Settings | None, options: dict[str, Any]) -> Settings:
    """Take settings as users of the library give them: as a value, or field by field.

    Raises
    ------
    UsageError
        If both are given, or there is no such field.
    """
    if not options:
        return settings or Settings()
    names = [entry.name for entry in fields(Settings)]
    unknown = sorted(set(options) - set(names))
    if settings is not None or unknown:
        near = difflib.get_close_matches(unknown[0], names, n=1) if unknown else []
        raise UsageError(
            f"there is no option {unknown[0]!r}" if unknown else "settings are given twice",
            where=unknown[0] if unknown else "settings",
            expected=", ".join(names) if unknown else "an object, or its fields one by one",
            next_step=f"did you mean {near[0]!r}?" if near else None,
        )
    return Settings(**options)


def _word(name: str, value: Any) -> str:
    """Say an option in signs that any file's name may have."""
    if isinstance(value, bool):
        return name if value else f"no-{name}"
    return f"{name}-{re.sub('[^A-Za-z0-9.]+', '_', str(value))}"


@dataclass(frozen=True)
class Origin:
    """What came before the main job.

    Parameters
    ----------
    command
        What the user typed.
    warnings
        Warnings given while the input was read.
    """

    command: str = ""
    warnings: tuple[str, ...] = ()


class Progress(Protocol):
    """Whom to tell how far the work is."""

    def __call__(self, label: str, total: int | None = None) -> None:
        """Begin a stage of `total` steps, or of an unknown number."""

    def advance(self, steps: int) -> None:
        """Note that some steps are done."""


class Silent:
    """Keeps it to itself."""

    def __call__(self, label: str, total: int | None = None) -> None:
        """Do nothing."""

    def advance(self, steps: int) -> None:
        """Do nothing."""
