"""Models that keep their budget over a box or a tube: proven, or tested at random states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import POSITIONS_PER_JOINT, Certificate, certify
from gd_analyze.certification.falsification import (
    POSITIONS_AT_ONCE,
    RANDOM_POSITIONS,
    RANDOM_STATES,
    STATES_AT_ONCE,
    worst_found,
    worst_in_box,
)
from gd_analyze.certification.held import Held, proven
from gd_analyze.certification.tube import Tube
from gd_analyze.errors import UsageError
from gd_analyze.motions.states import States
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.candidates import require_few_terms
from gd_analyze.simplification.coordinates import in_cheaper_velocities
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import (
    MOST_ROUNDS,
    USUAL,
    Check,
    Excess,
    Searched,
    at_states,
    stated,
    until_it_holds,
    warn_of_time,
)
from gd_analyze.text import LARGEST
from gd_analyze.threads import one_thread

DRAWN_STATES = 300  # states drawn from the region that a search looks at from the first round on
# States at their worst say enough about velocities: with more positions the budget of a box often holds.
BOX_PATIENCE = 4
GAMMA_POSITIONS = 1000  # positions of the region at which the model's D is compared with D
# Ratio of a bound to the budget above which random states are tried instead of improving the bound.
LOOSE_BOUND = 1.5
CLOSING_ROUND = 8  # round from which on no bound above the budget counts as close


@one_thread()
def simplify_held(
    exact: ExactDynamics,
    budget: Budget | str | float | None,
    region: Box | Tube,
    options: SearchOptions = USUAL,
    *,
    certified: bool = False,
    effort: int = POSITIONS_PER_JOINT,
    everywhere: Sequence[Check] = (),
    provenance: Mapping[str, str] | None = None,
    progress: Progress = NO_PROGRESS,
) -> Held:
    """Simplify as far as a budget allows at every state of a box, or of a tube around a motion.

    Along a motion the budget is proven; if the bound stays above it, it holds at 200 000 random states and at
    those reached by an ascent from the worst. In a box a model keeps it at 20 000 random positions with the
    worst velocities and accelerations of each, and at those reached by an ascent from the worst. Each of
    several motions has its own budget.

    Parameters
    ----------
    exact
        Exact dynamics at the first states; shares in the budget are of their peak torque.
    budget
        Allowed torque error per joint; by default 1 % of each joint's peak torque.
    region
        The states.
    options
        Level and effort; all rounds but the first are shorter.
    certified
        Return only a proven model, or the exact one.
    effort
        Effort of every proof, see `certify`.
    everywhere, provenance, progress
        As for `simplify_exact`.

    Returns
    -------
    Held
        The model and its bounds; the exact model if none with fewer operations was found.

    Raises
    ------
    UsageError
        If not even the exact model can be certified, the tube is around other motions, or the level has no
        terms to choose from.
    """
    require_few_terms(exact, options.level)
    budget = Budget.of(budget)
    exact = exact.under(budget)
    region = _counting(region, exact)
    allowed = exact.allowed(budget)
    first = exact.joined_by(*_drawn(region))
    patience = BOX_PATIENCE if isinstance(region, Box) else 0
    progress.stage(options.stage)
    first = in_cheaper_velocities(first, allowed, options)
    over_region = _OverRegion(exact.with_form(first.form), region, allowed, certified, effort)
    checks: list[Check] = [at_states(first, allowed), *everywhere, over_region.attacked]
    outcome = until_it_holds(
        first, budget, allowed, options, checks, proof=over_region.proven, patience=patience
    )
    held = over_region.held(outcome)
    model = stated(exact, held.model).stating(provenance=provenance)
    if model.saves:
        gammas = (held.model.accuracy.gamma, model.accuracy.gamma)
        gamma = max(gamma for gamma in gammas if gamma is not None)
        model = model.stating(replace(model.accuracy, gamma=gamma))
        held = held._replace(model=proven(model, held.certificate))
    else:
        held = Held(model, near=held.near)
    warn_of_time(model, outcome, options.time)
    if model.saves or not certified:
        return held
    certificate = certify(model, region, harmonics=exact.form.harmonics)
    if certificate.within(allowed).all():
        return Held(proven(model, certificate), certificate)
    raise UsageError(
        "not even the exact model can be certified within that budget",
        where="budget",
        expected=f"errors of at most {', '.join(f'{x:.3g}' for x in allowed)} at all states",
        found=f"round-off bounded by {', '.join(f'{x:.3g}' for x in certificate.certified)}",
        next_step="allow a larger error, or fewer states: a smaller box, or smaller margins",
    )


def _counting(region: Box | Tube, exact: ExactDynamics) -> Box | Tube:
    """Weight errors near each of several motions as at its set points."""
    states = exact.states
    if states.weights is None or not states.motions or not isinstance(region, Tube):
        return region
    if region.motion is None or region.fingerprint != states.described.get("trajectory_fingerprint"):
        expected, message = f"one around {states.in_words}", "the tube is around other motions"
        raise UsageError(message, where="region", expected=expected, found=region.where)
    first = [motion.first for motion in states.motions]
    return replace(region, weights=states.weights[first][region.motion])


def _drawn(region: Box | Tube) -> tuple[FloatArray, FloatArray]:
    """States drawn from a region, (3, N, n), and what errors count there, (N, n)."""
    lower, upper, weights = region.pieces(DRAWN_STATES, np.random.default_rng(0))
    drawn = np.random.default_rng(0).uniform(lower, upper)
    if isinstance(region, Tube):
        # Within small margins errors are nearly linear, and largest at corners, few of which are that bad.
        drawn = np.where(drawn < (lower + upper) / 2.0, lower, upper)
    return drawn, weights


@dataclass
class _OverRegion:
    """Checks over a region: states are tried there, and what none of them breaks is proven."""

    exact: ExactDynamics
    region: Box | Tube
    allowed: FloatArray
    certified: bool
    effort: int
    _last: Held | None = None  # the last model that no state broke
    _gamma: float | None = None  # its gamma over positions of the region

    def attacked(self, model: SimplifiedModel, turn: int) -> Excess:
        """Look for states where a model exceeds its budget or, where it holds, where its D is not usable."""
        self._last, excess = self._tried(model, turn, STATES_AT_ONCE)
        if excess.states.size or turn + 1 == MOST_ROUNDS:
            return excess
        return self._excess(self._singular(model), excess.errors)

    def proven(self, model: SimplifiedModel, turn: int) -> Excess:
        """Prove what no state broke, or try more states; where a bound exceeds the budget, its worst join."""
        if isinstance(self.region, Box) and not self.certified:
            return self._excess(np.empty((3, 0, len(self.allowed))), self.allowed)
        certificate = self._proof(model)
        bound = certificate.counting
        loose = LOOSE_BOUND if turn < CLOSING_ROUND else 1.0
        if self.certified or (bound <= loose * self.allowed).all():
            self._last = Held(model, certificate, 0, bound, self.region.where)
            return self._excess(np.stack(certificate.worst_states)[:, bound > self.allowed], bound)
        held, excess = self._tried(model, turn, RANDOM_STATES)
        self._last = held._replace(certificate=certificate)
        return excess

    def _tried(self, model: SimplifiedModel, turn: int, count: int) -> tuple[Held, Excess]:
        """Try states drawn from the region, or positions with the worst velocities and accelerations."""
        seed, where = turn + 1, self.region.where
        if isinstance(self.region, Box):
            count, tried_are = POSITIONS_AT_ONCE if self.certified else RANDOM_POSITIONS, "positions"
            errors, states = worst_in_box(model, self.exact, self.region, self.allowed, seed, count)
        else:
            tried_are = "states"
            errors, states = worst_found(model, self.exact, self.region, self.allowed, seed, count)
        return Held(model, None, count, errors, where, tried_are=tried_are), self._excess(states, errors)

    def _excess(self, states: FloatArray, errors: FloatArray) -> Excess:
        return Excess(states, self.region.counts_at(states), errors, is_of_region=True)

    def held(self, outcome: Searched) -> Held:
        """How a model that a search ended with is known to hold, if it was checked last."""
        model, last = outcome.model, self._last
        if last is None or last.model is not model:
            return Held(model, near=outcome.sample)
        stated = model.stating(replace(model.accuracy, gamma=self._gamma))
        return last._replace(model=stated, near=outcome.sample)

    def _singular(self, model: SimplifiedModel) -> FloatArray:
        """Positions, as states (3, M, n), at which gamma is 1 or more; none if a usable D is out of reach.

        Where D was usable at the states of the search, it shall be so everywhere near them.
        """
        lower, upper, _ = self.region.pieces(GAMMA_POSITIONS, np.random.default_rng(1))
        states = np.random.default_rng(1).uniform(lower, upper)
        gammas = model.gammas(self.exact.at(States(*states)))
        stated = model.accuracy.gamma
        assert stated is not None  # of every search, at its states
        self._gamma = max(stated, float(gammas.max()))
        is_usable = model.has_terms and stated < 1.0
        return states[:, gammas >= 1.0] if is_usable else states[:, :0]

    def _proof(self, model: SimplifiedModel) -> Certificate:
        harmonics, limit = self.exact.form.harmonics, np.minimum(self.allowed, LARGEST)
        return certify(model, self.region, effort=self.effort, harmonics=harmonics, limit=limit)
