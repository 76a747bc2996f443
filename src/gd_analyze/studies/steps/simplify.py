"""The fourth step of the main job: the run's model, models of other budgets, and proven bounds."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple, TypeAlias

from gd_analyze.certification.certificate import certify, usual_effort
from gd_analyze.certification.held import Held, proven
from gd_analyze.harmonics.expansion import TooLongError
from gd_analyze.progress import Progress
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.budget_path import budget_path, joined_path
from gd_analyze.simplification.element import ELEMENT, model_by_verdicts
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.levels import level_named
from gd_analyze.simplification.model import SimplifiedModel, exactly, measured, with_gamma
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.search_time import SearchTime
from gd_analyze.simplification.simplify import Check
from gd_analyze.simplification.term_ranking import TermRanking, rank_terms
from gd_analyze.simplification.torque_program import READABLE
from gd_analyze.studies.against_log import beside_log, within_log
from gd_analyze.studies.budget_stops import Stop, chosen_stop, named_budgets, stop_at, wider_stop
from gd_analyze.studies.settings import Settings
from gd_analyze.studies.simplifying import search_model
from gd_analyze.studies.steps.decompose import RunDynamics
from gd_analyze.studies.steps.read import RunInputs
from gd_analyze.studies.steps.set_points import Points


class Efforts(NamedTuple):
    """Efforts of certificates."""

    box: int  # in a box around the states
    tube: int  # around the motion


# Tight in a box as small as a trajectory's, and around a motion.
_USUAL_EFFORTS = Efforts(box=5_000, tube=100_000)
# The same for a model not chosen by its terms: a few seconds.
_SMALL_EFFORTS = Efforts(box=500, tube=2_000)

# Searches the model of a budget.
SearchAt: TypeAlias = Callable[..., Held]


@dataclass(frozen=True, eq=False)
class _Search:
    """The run's model, and those of the named budgets."""

    exact: ExactDynamics  # under the run's budget
    budget: Budget
    stops: list[Stop]
    own_stop: Stop | None  # that of the run's budget
    is_exact: bool  # whether the exact torque stands for a model that nobody could read
    held: Held
    elements: SimplifiedModel
    worst: Points


@dataclass(frozen=True, eq=False)
class RunModels:
    """The run's model, those of other budgets, and the ranking of single terms."""

    exact: ExactDynamics  # under the run's budget
    budget: Budget
    held: Held  # the run's model
    elements: SimplifiedModel  # the model of level element
    stops: list[Stop]  # named budgets
    path: tuple[SimplifiedModel, ...]  # from a tenth to ten times the budget
    own_place: int  # place of the run's model on the path
    places: list[int]  # place of every stop on the path; -1 if it is not there
    ranking: TermRanking
    efforts: Efforts | None  # of certificates; None if the model has too many terms
    worst: Points  # further set points of a long motion

    @property
    def model(self) -> SimplifiedModel:
        """The run's model."""
        return self.held.model


def simplify_step(inputs: RunInputs, dynamics: RunDynamics, progress: Progress) -> RunModels:
    """Search the run's model and those of other budgets, and prove a bound near the motion."""
    search = _searched(inputs, dynamics, progress)
    progress.stage("trying other budgets")
    path, own_place, places = _other_budgets(dynamics, search)
    ranking = TermRanking()
    if not dynamics.too_many_terms:
        selections = [step.terms for step in path if step.level is TERM and not step.is_exact]
        ranking = rank_terms(search.exact, included=selections)
    progress.stage("bounding errors")
    efforts = None if search.is_exact else _efforts(dynamics, search.held.model)
    held = _bounded(inputs, search, efforts)
    # The bound of the run's model is that of its budget.
    own_stop = None if search.is_exact else search.own_stop
    stops = [replace(stop, held=held) if stop is own_stop else stop for stop in search.stops]
    if dynamics.verdict is not None and dynamics.comparison is not None:
        left = dynamics.exact.left_of_log
        model = beside_log(held.model, inputs.trajectory, dynamics.comparison, dynamics.verdict, left)
        held = held._replace(model=model)
    return RunModels(
        exact=search.exact,
        budget=search.budget,
        held=held,
        elements=search.elements,
        stops=stops,
        path=path,
        own_place=own_place,
        places=places,
        ranking=ranking,
        efforts=efforts,
        worst=search.worst,
    )


def _searched(inputs: RunInputs, dynamics: RunDynamics, progress: Progress) -> _Search:
    """Search the models of the named budgets, and take that of the run."""
    settings, exact = inputs.settings, dynamics.exact
    points = dynamics.points
    time = SearchTime(settings.seconds)
    search_at = partial(_model_at, inputs, points.everywhere, time, progress)
    stops, budget = _stops(dynamics, settings, search_at, time)
    exact = exact.under(budget)
    elements = with_gamma(exact, model_by_verdicts(exact, settings.verdicts, settings.dominance, budget))
    elements = elements.stating(provenance=inputs.source)
    own_stop = next((stop for stop in stops if stop.budget == budget), None)
    # Without a model that can be read, the exact torque stands for it; one asked for may be long.
    is_exact = own_stop is not None and not (
        own_stop.is_readable or (settings.budget is not None and own_stop.saves)
    )
    if settings.level is ELEMENT:
        held = Held(elements)
    elif is_exact:
        # By its parts: its terms may be a million.
        model = with_gamma(exact, exactly(exact, ELEMENT, exact.allowed(budget), str(budget)))
        held = Held(model.stating(provenance=inputs.source))
    elif own_stop is not None and own_stop.held is not None:
        held = own_stop.held
    else:
        held = search_at(exact, budget)
    (elements, model), worst = points.stated(exact, [elements, held.model])
    exact = exact.with_form(model.form)
    return _Search(exact, budget, stops, own_stop, is_exact, held._replace(model=model), elements, worst)


def _stops(
    dynamics: RunDynamics, settings: Settings, search_at: SearchAt, time: SearchTime
) -> tuple[list[Stop], Budget]:
    """Search for every named budget, and take that of the run: the one asked for, or the first readable one.

    A log that agrees with the file asks for its own. Where no named budget has a readable model, a larger one
    that has joins them. At other levels there is one budget, which is searched later.
    """
    exact, asked, is_from_log = dynamics.exact, dynamics.asked, "log" in dynamics.asked.wholes
    if settings.level is not TERM:
        return [], asked
    is_given = settings.budget is not None or is_from_log
    # A wrong file has a model of its own, which is of no use: none is searched unless it is asked for.
    is_searched = settings.budget is not None or not dynamics.is_contradicted
    named = named_budgets(exact.arm)
    stops: list[Stop] = []
    if is_from_log:
        stops.append(_stop_of_log(dynamics, search_at))
        asked = stops[0].budget
    budgets = (asked, *(budget for budget in named if budget != asked)) if is_given else named
    has_form = False
    for budget in budgets[len(stops) :]:
        is_asked = is_given and not stops
        most_terms = math.inf if is_asked else READABLE
        unsearched = "" if is_searched else "log"
        if stops and time.is_over:
            unsearched = unsearched or "time"
        # Models of one page have terms in the same velocities.
        search = partial(search_at, exact, most_terms=most_terms, same_velocities=has_form)
        stops.append(stop_at(exact, TERM, budget, search, most_terms, unsearched))
        if stops[-1].held is not None:
            exact, has_form = exact.with_form(stops[-1].held.model.form), True
    readable = chosen_stop(stops)
    is_wider_sought = is_searched and readable is None and not is_from_log and not time.is_over
    if is_wider_sought and stops[0].terms_beyond >= 0:
        wider = wider_stop(exact, TERM, budgets[0], partial(search_at, exact, most_terms=READABLE))
        stops += [] if wider is None else [wider]
    return stops, asked if is_given or readable is None else readable.budget


def _stop_of_log(dynamics: RunDynamics, search_at: SearchAt) -> Stop:
    """Search the budget that the log allows, with models at the set points and then near the motion."""
    exact, verdict = dynamics.exact, dynamics.verdict
    assert verdict is not None  # it asked for this budget
    assert verdict.resolution is not None
    stops: list[Stop] = []

    def held_within(budget: Budget, *, roughly: bool) -> Held | None:
        search = partial(search_at, exact, most_terms=READABLE, roughly=roughly)
        stops.append(stop_at(exact, TERM, budget, search))
        return stops[-1].held if stops[-1].is_readable else None

    searches = [partial(held_within, roughly=roughly) for roughly in (True, False)]
    within_log(exact, verdict.resolution, dynamics.asked, searches)
    return stops[-1]


def _model_at(
    inputs: RunInputs,
    everywhere: Sequence[Check],
    time: SearchTime,
    progress: Progress,
    exact: ExactDynamics,
    budget: Budget,
    *,
    most_terms: float = math.inf,
    same_velocities: bool = False,
    roughly: bool = False,
) -> Held:
    """Search the model of a budget near the motion, or roughly, or if it is asked for, at its set points."""
    settings = inputs.settings
    options = SearchOptions(
        level_named(settings.level),
        thorough=not roughly,
        same_velocities=same_velocities,
        most_terms=most_terms,
        time=time,
    )
    at_states = roughly or settings.at_set_points or not inputs.has_tube
    return search_model(
        exact,
        inputs.trajectory,
        budget,
        options,
        region=None if at_states else inputs.tube,
        at_states=at_states,
        proof_effort=_USUAL_EFFORTS.tube,
        everywhere=everywhere,
        provenance=inputs.source,
        progress=progress,
    )


def _other_budgets(
    dynamics: RunDynamics, search: _Search
) -> tuple[tuple[SimplifiedModel, ...], int, list[int]]:
    """Models of other budgets, those of readable stops among them; places of the run's and of every stop."""
    exact, model, stops = search.exact, search.held.model, search.stops
    if search.is_exact:
        # The exact torque stands alone: its path has no terms that others share.
        steps: Sequence[SimplifiedModel] = (model,)
    else:
        near = search.held.near or exact
        # At level element the model keeps another budget.
        steps = budget_path(near, model.accuracy.asked, measured(near, model))
    path = dynamics.points.path(exact, steps)
    models_of_stops = {
        number: stop.held.model
        for number, stop in enumerate(stops)
        if stop.is_readable and stop.held is not None and stop is not search.own_stop and not search.is_exact
    }
    measured_models = [measured(exact, stop_model) for stop_model in models_of_stops.values()]
    path, places = joined_path(path, measured_models)
    own_place = next(
        place for place, step in enumerate(path) if step.accuracy.budget == model.accuracy.budget
    )
    place_of = dict(zip(models_of_stops, places, strict=True))
    if search.own_stop is not None and not search.is_exact:
        place_of[stops.index(search.own_stop)] = own_place
    return path, own_place, [place_of.get(number, -1) for number in range(len(stops))]


def _efforts(dynamics: RunDynamics, model: SimplifiedModel) -> Efforts | None:
    """Efforts of the model's certificates; None if it has too many terms, or too long a program."""
    is_short = not dynamics.too_many_terms
    if is_short and model.has_terms:
        return _USUAL_EFFORTS
    with suppress(TooLongError):
        if (is_short or not model.is_exact) and usual_effort(model) is not None:
            return _USUAL_EFFORTS if is_short else _SMALL_EFFORTS
    return None


def _bounded(inputs: RunInputs, search: _Search, efforts: Efforts | None) -> Held:
    """Prove a bound near the motion where the search did not."""
    held = search.held
    if not inputs.has_tube or held.certificate is not None or efforts is None:
        return held
    certificate = certify(held.model, inputs.tube, effort=efforts.tube, harmonics=search.exact.form.harmonics)
    return held._replace(model=proven(held.model, certificate), certificate=certificate)
