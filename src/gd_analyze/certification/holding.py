"""Models that keep their budget over a box or a tube: proven, or tested at random states.

A model is fitted on some states and tested over the region. If a joint exceeds the budget, the worst states
found are added to those of the fit, and the joint's budget shrinks; a few rounds suffice.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import POSITIONS_PER_JOINT, Certificate, certify
from gd_analyze.certification.falsification import RANDOM_POSITIONS, RANDOM_STATES, worst_found, worst_in_box
from gd_analyze.certification.held import Held, proven
from gd_analyze.certification.tube import Tube
from gd_analyze.errors import UsageError
from gd_analyze.motions.states import States
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.coordinates import in_worthwhile_velocities, shortest
from gd_analyze.simplification.element import require_no_budget
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel, exactly, no_dearer, with_gamma, with_rewriting
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import search_terms
from gd_analyze.simplification.torque_program import ROUGH, Effort
from gd_analyze.threads import one_thread


@dataclass(frozen=True, kw_only=True)
class _RoundSettings:
    """Rounds of fitting a model and testing it over a region."""

    most_rounds: int = 16  # most rounds
    # Rounds in which the budget of an exceeding joint shrinks to `slight_shrink`. For positions, as many
    # rounds before them leave it unchanged.
    patient_rounds: int = 4
    slight_shrink: float = 0.96  # share of the budget in these rounds
    shrink_power: float = 0.5  # power of the excess by which the budget shrinks in later rounds
    continued_effort: float = 0.25  # share of a usual search in each round but the first; others continue it
    drawn_states: int = 300  # states drawn at first, beside those of the motion
    gamma_positions: int = 1000  # positions at which the model's D is compared with D
    loose_bound: float = 1.5  # ratio of a bound to the budget above which the bound is not improved
    closing_round: int = 8  # rounds after which no bound above the budget is improved


_SETTINGS = _RoundSettings()


_USUAL = SearchOptions()


@one_thread()
def simplify_held(
    exact: ExactDynamics,
    budget: Budget | str | None,
    region: Box | Tube,
    options: SearchOptions = _USUAL,
    *,
    certified: bool = False,
    effort: int = POSITIONS_PER_JOINT,
    provenance: Mapping[str, str] | None = None,
    progress: Callable[[int], None] | None = None,
    stage: Callable[[str], object] = lambda _: None,
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
        Level and effort; all rounds but the last are shorter than those of `simplify`.
    certified
        Return only a proven model, or the exact one.
    effort
        Effort of every proof, see `certify`.
    provenance, stage
        As for `simplify_exact`.
    progress
        Called with 1 after every round.

    Returns
    -------
    Held
        The model and its bounds; the exact model if none with fewer operations was found.

    Raises
    ------
    UsageError
        If not even the exact model can be certified, the tube is around other motions, or the level is
        element.
    """
    require_no_budget(options.level, f"budget {budget}")
    budget = Budget.of(budget)
    exact = exact.under(budget)
    region = _counting(region, exact)
    rounds = _Rounds(exact, budget, region, certified, effort, dict(provenance or {}), progress, stage)
    best = rounds.held(options)
    if best.model.saves or not certified:
        return best
    certificate = certify(best.model, region, harmonics=exact.form.harmonics)
    if certificate.within(best.model.accuracy.allowed).all():
        return Held(proven(best.model, certificate), certificate)
    raise UsageError(
        "not even the exact model can be certified within that budget",
        where="budget",
        expected=f"errors of at most {', '.join(f'{x:.3g}' for x in best.model.accuracy.allowed)} "
        "at all states",
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


@dataclass(frozen=True)
class _Rounds:
    """Rounds of fitting a model on some states and testing it over a region."""

    exact: ExactDynamics
    budget: Budget
    region: Box | Tube
    certified: bool
    effort: int
    provenance: dict[str, str]
    progress: Callable[[int], None] | None
    stage: Callable[[str], object]

    def held(self, options: SearchOptions) -> Held:
        """Fit and test until a model holds; in absolute velocities and, where it may pay, in joint ones."""
        # Within small margins errors are nearly linear, and largest at corners, few of which are that bad.
        lower, upper, weights = self.region.pieces(_SETTINGS.drawn_states, np.random.default_rng(0))
        drawn = np.random.default_rng(0).uniform(lower, upper)
        if isinstance(self.region, Tube):
            drawn = np.where(drawn < (lower + upper) / 2.0, lower, upper)
        sample = self.exact.joined_by(drawn, weights)
        trials = in_worthwhile_velocities(sample, self.exact.allowed(self.budget), options)
        outcomes = [
            replace(self, exact=self.exact.with_form(trial.form))._from(trial, options) for trial in trials
        ]
        whole = [held for held in outcomes if len(held.model.terms) <= options.most_terms] or outcomes[:1]
        best = shortest([held.model for held in whole])
        return next(held for held in whole if held.model is best)

    def _from(self, first: ExactDynamics, options: SearchOptions) -> Held:
        """Fit and test until a model holds, beginning at first states."""
        n, allowed, sample = self.exact.arm.n_joints, self.exact.allowed(self.budget), first
        share = np.ones(n)
        worst, counts = np.empty((3, 0, n)), np.empty((0, n))
        search = replace(
            options,
            writing=ROUGH,
            effort=options.effort * _SETTINGS.continued_effort,
            dearer=True,
            selections=[],
        )
        for turn in range(_SETTINGS.most_rounds):
            if len(counts):
                sample = first.joined_by(worst, counts)
            self.stage(f"searching at level {options.level}")
            model = search_terms(
                sample,
                Budget.of_torques(share * allowed),
                search if turn else replace(search, effort=options.effort),
            )
            model = replace(model, provenance=self.provenance)
            if len(model.terms) > options.most_terms:
                return Held(with_gamma(self.exact, model), near=sample)
            trial, states = self._over_region(model, allowed, turn)
            if self.progress is not None:
                self.progress(1)
            errors = trial.found
            assert errors is not None
            if (errors <= allowed).all():
                trial, singular = self._with_gamma(trial)
                # Where D was usable at the states of the search, it shall be so everywhere near them.
                if singular.size and turn + 1 < _SETTINGS.most_rounds:
                    worst = np.concatenate([worst, singular], axis=1)
                    counts = np.concatenate([counts, self.region.counts_at(singular)])
                    continue
                trial = self._written(trial, allowed, options.writing)
                errors = trial.found
                assert errors is not None
                if (errors <= allowed).all():
                    if not trial.model.saves:
                        break
                    return trial._replace(near=first.joined_by(worst, counts))
            worst = np.concatenate([worst, states], axis=1)
            counts = np.concatenate([counts, self.region.counts_at(states)])
            exceeds = errors > allowed
            needed = np.where(exceeds, 0.98 * allowed / np.where(exceeds, errors, 1.0), 1.0)
            # States at their worst say enough about velocities: with more of them the budget often holds.
            late = turn - (_SETTINGS.patient_rounds if trial.tried_are == "positions" else 0)
            if late >= _SETTINGS.patient_rounds:
                share = share * needed**_SETTINGS.shrink_power
            elif late >= 0:
                share = np.where(exceeds, np.minimum(share, _SETTINGS.slight_shrink), share)
        everything = with_gamma(self.exact, exactly(self.exact, options.level, allowed, str(self.budget)))
        return Held(replace(everything, provenance=self.provenance), near=first.joined_by(worst, counts))

    def _over_region(self, model: SimplifiedModel, allowed: FloatArray, turn: int) -> tuple[Held, FloatArray]:
        """Proven or found errors of a model, and the states (3, M, n) of the largest ones.

        A bound need not be tight: the program is written, and proven, anew in the end.
        """
        where, seed = self.region.where, turn + 1
        if isinstance(self.region, Box) and not self.certified:
            errors, states = worst_in_box(model, self.exact, self.region, allowed, seed)
            # States of the search are tried, too.
            errors = np.maximum(errors, model.accuracy.errors.largest)
            return Held(model, None, RANDOM_POSITIONS, errors, where, tried_are="positions"), states
        certificate = self._proof(model, allowed, tighten=False)
        loose = _SETTINGS.loose_bound if turn < _SETTINGS.closing_round else 1.0
        errors = certificate.counting
        if isinstance(self.region, Box) or self.certified or (errors <= loose * allowed).all():
            states = np.stack(certificate.worst_states)[:, errors > allowed]
            return Held(model, certificate, 0, errors, where), states
        errors, states = worst_found(model, self.exact, self.region, allowed, seed, RANDOM_STATES)
        return Held(model, certificate, RANDOM_STATES, errors, where), states

    def _with_gamma(self, trial: Held) -> tuple[Held, FloatArray]:
        """State gamma over further positions, and return the states (3, M, n) of those where it is 1 or more.

        None are returned if gamma is that large at states of the search, which then cannot make D usable.
        """
        model, nothing = trial.model, np.empty((3, 0, self.exact.arm.n_joints))
        lower, upper, _ = self.region.pieces(_SETTINGS.gamma_positions, np.random.default_rng(1))
        states = np.random.default_rng(1).uniform(lower, upper)
        drawn = self.exact.at(States(*states))
        drawn_gammas = model.gammas(drawn)
        stated_gamma = model.accuracy.gamma
        assert stated_gamma is not None  # stated by every search
        stated = model.stating(replace(model.accuracy, gamma=max(stated_gamma, float(drawn_gammas.max()))))
        is_usable = stated_gamma < 1.0
        return trial._replace(model=stated), states[:, drawn_gammas >= 1.0] if is_usable else nothing

    def _written(self, trial: Held, allowed: FloatArray, writing: Effort) -> Held:
        """Write the final program, and prove it."""
        model = _finished(trial.model, self.exact, allowed, str(self.budget), writing)
        certificate, errors = trial.certificate, trial.found
        if certificate is not None:
            certificate = self._proof(model, allowed, tighten=True)
            errors = errors if trial.tried else certificate.counting
        return trial._replace(model=proven(model, certificate), certificate=certificate, found=errors)

    def _proof(self, model: SimplifiedModel, allowed: FloatArray, *, tighten: bool) -> Certificate:
        harmonics = model.form.harmonics
        return certify(
            model, self.region, effort=self.effort, harmonics=harmonics, limit=allowed, tighten=tighten
        )


def _finished(
    model: SimplifiedModel, exact: ExactDynamics, allowed: FloatArray, stated: str, writing: Effort
) -> SimplifiedModel:
    """State the budget, and write the program with few operations."""
    if model.terms:
        model = replace(model, program=model.level.write(model.form, model.terms, writing))
    model = with_rewriting(model)
    accuracy = replace(model.accuracy, allowed=allowed, budget=stated, fitted_on=exact.states.described)
    accuracy = exact.held(accuracy, model.torque(*exact.states.arrays))
    return no_dearer(exact, model.stating(accuracy))
