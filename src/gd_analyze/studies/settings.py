"""Settings of the main job, and the folder that is named after them."""

from __future__ import annotations

import re
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from gd_analyze.arguments import require_flags_of
from gd_analyze.diagnosis.answer import is_identified
from gd_analyze.dynamics.dominance import DOMINANCE_THRESHOLD
from gd_analyze.errors import UsageError, require_type
from gd_analyze.motions.margin import Margin
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.uncertainty import StatedUncertainty
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.element import require_search, require_verdicts
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.level import Level
from gd_analyze.simplification.levels import level_named
from gd_analyze.simplification.search_time import SEARCH_SECONDS, SearchTime


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How the main job analyses an arm along a trajectory.

    Parameters
    ----------
    budget
        Allowed torque error: a text such as "1% or 10% friction", or a number, 0.01 for 1 % of peak torque.
        By default that or, if its model has more terms than one can read, the next of `named_budgets`.
    level
        How to simplify, see `gd_analyze.simplify`.
    verdicts
        At level "element", keep the dominant part of every element by verdicts over the set points ("own") or
        by [FGL87]'s ("text"). This level is written without a search: its error is stated as its
        budget; `budget` only says which elements are negligible.
    at_set_points
        Keep the budget at the set points only; by default it holds near the motion, near each of several, see
        `simplify`.
    seconds
        Processor time of all searches; then the best model that holds is the answer, or the exact torque.
    drives
        Include drive inertia as a separate contribution; by default if the arm describes drives.
    margin
        How far from the motion the budget holds and errors are bounded, or its text such as
        "1deg,1mm,qd=2%,qdd=5%", which is the default.
    dominance
        Share of an element's peak that leaving a part out may change, see `rank`.
    uncertainty
        Standard uncertainties of all links in place of those the arm states, or their text, see `robustness`.
    fit_friction
        Fit friction to measured torques; it does not become part of the model.
    christoffel, by_link, terms
        Further results of `decompose` to keep; by default h_ijk for up to `MOST_KEPT` set points.
    every_set_point
        Above `MOST_KEPT` set points tables hold a selection; also store D, h, c and torques at every set
        point. By default up to `MOST_STORED`.

    Raises
    ------
    UsageError
        If an option is not understood or not between its limits.
    """

    budget: Budget | str | float | None = None
    level: str | Level = TERM
    verdicts: str = "own"
    at_set_points: bool = False
    seconds: float = SEARCH_SECONDS
    drives: bool | None = None
    margin: Margin | str | None = None
    dominance: float = DOMINANCE_THRESHOLD
    uncertainty: StatedUncertainty | str | None = None
    fit_friction: bool = False
    christoffel: bool | None = None
    by_link: bool = False
    terms: bool = False
    every_set_point: bool | None = None

    def __post_init__(self) -> None:
        require_flags_of(self)
        if self.budget is not None:
            object.__setattr__(self, "budget", Budget.of(self.budget))
        object.__setattr__(self, "margin", Margin.of(self.margin))
        if isinstance(self.uncertainty, str):
            object.__setattr__(self, "uncertainty", StatedUncertainty.parse(self.uncertainty))
        SearchTime(self.seconds)  # raises an error if it is no time
        level = level_named(self.level)
        if self.at_set_points:
            require_search(level, "at_set_points")
        require_verdicts(self.verdicts, level)
        object.__setattr__(self, "level", level)
        require_type(self.dominance, (float, int), "dominance", "a share between 0 and 1")
        if not 0.0 < self.dominance < 1.0:
            found, expected = f"{self.dominance:g}", "a share between 0 and 1"
            raise UsageError("this is not a share", where="dominance", expected=expected, found=found)

    @property
    def asked(self) -> Budget:
        """The parsed budget; 1 % of peak torque if none is given."""
        return Budget.of(self.budget)

    @property
    def described(self) -> dict[str, Any]:
        """All settings as JSON values."""
        values = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return values | {
            "budget": self.asked.entries,
            "level": level_named(self.level).name,
            "margin": str(self.margin),
            "uncertainty": None if self.uncertainty is None else str(self.uncertainty),
        }


def default_folder(arm: RobotArm, trajectory: Trajectory, settings: Settings) -> Path:
    """Default folder of the results; its name contains the options that are not defaults."""
    words, usual = [arm.name, trajectory.name], Settings().described
    if is_identified(arm):
        words.insert(1, "identified")
    for key, value in settings.described.items():
        if value != usual[key]:
            name = key.replace("_", "-")
            if isinstance(value, bool):
                words.append(name if value else f"no-{name}")
            else:
                text = str(settings.asked).replace("%", "pct") if key == "budget" else str(value)
                words.append(f"{name}-{re.sub('[^A-Za-z0-9.]+', '_', text)}")
    return Path("reports") / "-".join(words)
