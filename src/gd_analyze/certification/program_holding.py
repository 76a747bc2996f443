"""Level "fast": the shortest program found that keeps its budget over a region, proven or attacked."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import Certificate, certify, usual_effort
from gd_analyze.certification.falsification import (
    RANDOM_POSITIONS,
    RANDOM_STATES,
    largest_at,
    worst_found,
    worst_in_box,
)
from gd_analyze.certification.held import Held, proven
from gd_analyze.certification.tube import Tube
from gd_analyze.harmonics.expansion import TooLongError
from gd_analyze.motions.states import States
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.fast import FAST
from gd_analyze.simplification.fast_search import FastSearch, FastSettings
from gd_analyze.simplification.levels import SearchOptions
from gd_analyze.simplification.model import SimplifiedModel, exactly, with_gamma


@dataclass(frozen=True)
class _RegionSettings:
    """Numbers of states and searches over a region, and how close to the budget they go."""

    pool: int
    scouts: int  # short searches at first, for what their tests tell
    fresh: int  # searches from the exact program, scouts included
    searches: int  # in all
    most: int = 16  # in all, if none before holds
    limit: float = 0.99  # of allowed errors at the pool: elsewhere errors are somewhat larger
    untried: int = 0  # further random states of the last test


_NEAR = _RegionSettings(pool=100_000, scouts=0, fresh=3, searches=4)
_WITHIN = _RegionSettings(pool=300_000, scouts=2, fresh=4, searches=5, untried=400_000)


@dataclass(frozen=True, kw_only=True)
class _AimSettings:
    """How a search's budget follows what its proof or attack shows."""

    # Share of the budget at which a joint's next error is aimed. It is met if errors and bounds then exceed
    # those at the pool by as much as now.
    aimed_share: float = 0.995
    least_share: float = 0.5  # least share of its budget that a joint is allowed in a search
    shown_states: int = 300  # states of the region that are shown with a model, beside those given


_AIM = _AimSettings()


def program_held(
    exact: ExactDynamics,
    allowed: FloatArray,
    stated: str,
    region: Box | Tube,
    options: SearchOptions,
    *,
    certified: bool,
    effort: int,
    provenance: Mapping[str, str],
    progress: Callable[[int], None] | None,
    stage: Callable[[str], object],
) -> Held:
    """The cheapest of several programs, each searched at many states of a region and tested everywhere.

    Near a motion the budget is proven where the proof closes. In a box no state drawn, and none that an
    ascent reaches, exceeds it; it is proven if `certified`. Each test adds its worst states to those of the
    next search, and sets each joint's share of its budget: programs that exceed it are not repaired, as the
    search never leaves what holds.
    """
    settings = _NEAR if isinstance(region, Tube) else _WITHIN
    drawn, counts = _pool(region, settings.pool)
    pool = exact.joined_by(drawn, counts)
    lengths = FastSettings(fresh=settings.fresh, scouts=settings.scouts, limit=settings.limit)
    search = FastSearch(pool, allowed, options, lengths, progress=progress, stage=stage)
    share, best = np.ones(len(allowed)), None
    last = settings.searches - 1
    for turn in range(settings.most):
        program = search.program(turn)
        model = replace(search.model(program, stated, exact), provenance=dict(provenance))
        stage("testing the program")
        trial, states = _tested(model, exact, allowed, region, turn, settings, certified, effort)
        assert trial.found is not None
        if (trial.found <= allowed).all() and search.is_best():
            # One more search at least, which may be allowed more.
            last = max(last, turn + 1) if best is None else last
            best = trial
        if best is not None and (search.stopped or turn >= last):
            break
        # The share grows only after a program held, and then by the square root of the room that it left.
        largest_share = 1.0 if best is not None else share
        room = _AIM.aimed_share * allowed / np.maximum(trial.found, 1e-300)
        share = np.clip(share * np.minimum(room, np.sqrt(room)), _AIM.least_share, largest_share)
        q, qd, qdd = states
        search.learn(exact.at(States(q, qd, qdd, weights=region.counts_at(states))), share)
    if best is None:
        model = replace(with_gamma(exact, exactly(exact, FAST, allowed, stated)), provenance=dict(provenance))
        return Held(model, near=exact, stopped=search.stopped)
    exact_near = exact.joined_by(drawn[:, : _AIM.shown_states], counts[: _AIM.shown_states])
    return best._replace(model=proven(best.model, best.certificate), near=exact_near, stopped=search.stopped)


def _pool(region: Box | Tube, count: int, seed: int = 0) -> tuple[FloatArray, FloatArray]:
    """States (3, N, n) of a region, and weights of errors there (N, n).

    Errors are largest at limits, so that most states have all, or all but a few, velocities and
    accelerations there; positions are at corners of the small boxes of a tube, and anywhere in a large one.
    """
    rng = np.random.default_rng(seed)
    lower, upper, counts = region.pieces(count, rng)
    inside = rng.uniform(lower, upper)
    corners = np.where(rng.random(lower.shape) < 0.5, lower, upper)
    few_rest = np.where(rng.random(lower.shape) < 0.3, (lower + upper) / 2.0, corners)
    kind = rng.integers(0, 4, size=(3, count, 1))
    mixed = np.where(kind == 0, inside, np.where(kind == 1, few_rest, corners))
    if isinstance(region, Box):
        mixed[0] = inside[0]
    return mixed, counts


def _tested(
    model: SimplifiedModel,
    exact: ExactDynamics,
    allowed: FloatArray,
    region: Box | Tube,
    turn: int,
    settings: _RegionSettings,
    certified: bool,
    effort: int,
) -> tuple[Held, FloatArray]:
    """Proven or found errors of a model, and states (3, M, n) of the largest ones."""
    where = region.where
    if isinstance(region, Box):
        errors, states = worst_in_box(model, exact, region, allowed, turn + 1)
        if (errors <= allowed).all():
            fresh, _ = _pool(region, settings.untried, turn + 1)
            errors = np.maximum(errors, largest_at(model, exact, fresh))
        if not certified or (errors > allowed).any():
            return Held(model, None, RANDOM_POSITIONS, errors, where, tried_are="positions"), states
    else:
        errors, states = worst_found(model, exact, region, allowed, turn + 1, RANDOM_STATES)
        if (errors > allowed).any():
            return Held(model, None, RANDOM_STATES, errors, where), states
    certificate: Certificate | None = None
    with suppress(TooLongError):
        proof_effort = effort if certified else usual_effort(model, effort)
        if proof_effort is not None:
            certificate = certify(
                model, region, effort=proof_effort, harmonics=exact.form.harmonics, limit=allowed
            )
    if certificate is None:
        return Held(model, None, RANDOM_STATES, errors, where), states
    bound = certificate.counting
    return Held(model, certificate, 0, bound, where), np.stack(certificate.worst_states)[:, bound > allowed]
