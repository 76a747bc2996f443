"""Budgets that mean something, each with its model: shares of peak torque, friction and torque limit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.certification.held import Held
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import table
from gd_analyze.simplification.budget import Budget, ReferenceTorques
from gd_analyze.simplification.candidates import TooManyTermsError, terms_beyond
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.harmonic import HarmonicLevel
from gd_analyze.simplification.torque_program import READABLE

if TYPE_CHECKING:
    import xarray as xr

# Budgets beside 1 % of peak torque, and what an arm must state of every joint for each.
_NAMED = {"1% or 10% friction": "friction", "1% or 0.5% limit": "limit"}
# Budgets of larger errors, tried where no other has a readable model.
_WIDER = ("2%", "5%", "10%", "20%", "50%")
# Share of a readable model's terms that may exceed a larger budget alone: with seven joints a model keeps
# some four times as many.
_LIKELY_SHARE = 0.25


@dataclass(frozen=True, eq=False)
class Stop:
    """A budget, and its model if that has few enough terms to read."""

    budget: Budget
    held: Held | None = None
    terms_beyond: int = 0  # terms whose torque alone exceeds the budget; -1 if there are too many to count
    unsearched: str = ""  # why no model was searched: "log", "time" or "terms"

    @property
    def is_readable(self) -> bool:
        """Whether its model was searched and has few enough terms."""
        return self.held is not None and len(self.held.model.terms) <= READABLE

    @property
    def saves(self) -> bool:
        """Whether its model was searched and is not the exact one."""
        return self.held is not None and not self.held.model.is_exact


def named_budgets(arm: RobotArm) -> tuple[Budget, ...]:
    """1 % of peak torque, and the larger of it and a share of what the arm states of every joint."""
    no_torque = np.zeros(arm.n_joints)
    references = ReferenceTorques(arm, no_torque, no_torque)
    stated = [text for text, quantity in _NAMED.items() if np.isfinite(references.all(quantity)).all()]
    return tuple(map(Budget.parse, ("1%", *stated)))


def stop_at(
    exact: ExactDynamics,
    level: HarmonicLevel,
    budget: Budget,
    search: Callable[[Budget], Held],
    most: float = READABLE,
    unsearched: str = "",
) -> Stop:
    """Search a budget's model, unless it is not wanted, or more than `most` terms exceed the budget alone."""
    dynamics, beyond = exact.under(budget), -1
    try:
        beyond = terms_beyond(dynamics, level, dynamics.allowed(budget))
        if unsearched or beyond > most:
            return Stop(budget, None, beyond, unsearched or "terms")
        return Stop(budget, search(budget), beyond)
    except TooManyTermsError:
        return Stop(budget, None, beyond, "terms")


def wider_stop(
    exact: ExactDynamics, level: HarmonicLevel, budget: Budget, search: Callable[[Budget], Held]
) -> Stop | None:
    """Search the smallest larger budget that may have a readable model; None if it has none."""
    least = exact.under(budget).allowed(budget)
    for wider in map(Budget.parse, _WIDER):
        if (exact.under(wider).allowed(wider) >= least).all():
            stop = stop_at(exact, level, wider, search, _LIKELY_SHARE * READABLE)
            if stop.held is not None:
                return stop if stop.is_readable else None
    return None


def chosen_stop(stops: Sequence[Stop]) -> Stop | None:
    """The first stop with a readable model, if possible one that saves operations; None if there is none."""
    readable = [stop for stop in stops if stop.is_readable]
    return next((stop for stop in readable if stop.saves), readable[0] if readable else None)


def stops_table(stops: Sequence[Stop], positions: Sequence[int], arm: RobotArm) -> xr.Dataset:
    """Tabulate the named budgets and their models; -1 and nan where none was searched, or none is shown."""
    rows = [_row(stop) for stop in stops]
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    columns["budget"] = np.array([str(stop.budget) for stop in stops], dtype=str)
    columns["unsearched"] = np.array([stop.unsearched for stop in stops], dtype=str)
    columns["position"] = np.array(positions)
    return table("stops", columns, arm.is_revolute, {"stop": np.arange(1, len(stops) + 1)})


def _row(stop: Stop) -> dict[str, Any]:
    """Figures of a stop's model."""
    if stop.held is None:
        unknown = dict.fromkeys(
            ("terms", "operations_apart", "operations", "sines_cosines_apart", "sines_cosines"), -1
        )
        return {**unknown, "terms_beyond": stop.terms_beyond, "proven_share": np.nan, "gamma": np.nan}
    model, certificate = stop.held.model, stop.held.certificate
    gamma, allowed = model.accuracy.gamma, model.accuracy.allowed
    proven_share = np.nan if certificate is None else float((certificate.counting / allowed).max())
    return {
        "terms": len(model.terms),
        "operations_apart": model.functions.operations.total,
        "operations": model.operations.total,
        "sines_cosines_apart": model.functions.operations.sines_cosines,
        "sines_cosines": model.operations.sines_cosines,
        "terms_beyond": stop.terms_beyond,
        # The exact torque has no error but round-off.
        "proven_share": 0.0 if model.is_exact else proven_share,
        "gamma": np.nan if gamma is None else gamma,
    }
