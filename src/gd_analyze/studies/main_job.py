"""The main job: arm and trajectory in; decomposition, ranking, model and bounds out."""

from __future__ import annotations

import difflib
import math
import re
import warnings
from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np

from gd_analyze.arrays import evenly
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import certify, usual_effort
from gd_analyze.certification.held import Held, proven
from gd_analyze.certification.holding import simplify_held
from gd_analyze.certification.tube import Tube
from gd_analyze.diagnosis.diagnose import diagnosed
from gd_analyze.dynamics.decomposition import MOST_KEPT, decompose, decompose_on_demand
from gd_analyze.dynamics.dominance import DOMINANCE_THRESHOLD, rank
from gd_analyze.dynamics.dominance_over_time import dominance_over_time
from gd_analyze.dynamics.measured_torque import compared, require_torques
from gd_analyze.dynamics.pinocchio_check import Residual, cross_check
from gd_analyze.dynamics.robustness import robustness
from gd_analyze.dynamics.torque_limits import warn_of_torque_limits
from gd_analyze.errors import GdAnalyzeWarning, LeadingWarning, TrajectoryError, UsageError, warnings_said
from gd_analyze.files import RESULT_FILES, require_one_run
from gd_analyze.harmonics.expansion import TooLongError
from gd_analyze.motions.limits import check_against_arm
from gd_analyze.motions.margin import Margin
from gd_analyze.motions.pool import GivenMotions, taken_apart, trajectory_of
from gd_analyze.motions.states import states_in_box
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.results import motion_tables, run_tables
from gd_analyze.results.diagnosis_result import diagnosis_table
from gd_analyze.results.findings import Findings, provenance_of_run
from gd_analyze.results.motion_result import is_described, torque_warning
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.robots.description import describe_in_full
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.robots.uncertainty import StatedUncertainty, with_uncertainty
from gd_analyze.simplification.budget import Budget, ReferenceTorques
from gd_analyze.simplification.budget_path import budget_path, joined_path
from gd_analyze.simplification.effort import READABLE
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.exact import ExactDynamics, too_many_terms, warn_without_torque
from gd_analyze.simplification.fast import FAST
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.level import Level
from gd_analyze.simplification.levels import SearchOptions, level_named
from gd_analyze.simplification.model import SimplifiedModel, exactly, measured, with_gamma
from gd_analyze.simplification.model_torque import payload_effect
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.simplification.term_ranking import TermRanking, rank_terms
from gd_analyze.simplification.verdicts import VERDICT_SOURCES, model_by_verdicts, require_no_budget
from gd_analyze.studies.budget_stops import Stop, chosen_stop, named_budgets, stop_at, stops_table, wider_stop
from gd_analyze.studies.long_motion import LongMotion
from gd_analyze.studies.study_files import write_findings
from gd_analyze.threads import one_thread

if TYPE_CHECKING:
    import xarray as xr

# States drawn to test a model beyond its own.
_DRAWN = 1000
# Most set points whose decomposition is stored by default, 150 MB for six joints: evaluating one again takes
# less time than writing it.
MOST_STORED = 2**17
# Arms drawn from the stated uncertainties: probabilities near 95 % are known to within 0.5 %.
_SAMPLES = 2000
# Efforts of certificates: tight in a box as small as a trajectory's, and around a motion.
_Efforts: TypeAlias = tuple[int, int] | None
_EFFORTS = 5_000, 100_000
# The same for a model not chosen by its terms: a few seconds.
_LITTLE = 500, 2_000


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How the main job analyses an arm along a trajectory.

    Parameters
    ----------
    budget
        Allowed torque error, or its text such as "1% or 10% friction". By default 1 % of peak torque or, if
        its model has more terms than one can read, the next of `named_budgets`.
    level, refit, operations
        How to simplify, see `gd_analyze.simplification.levels.SearchOptions`.
    verdicts
        At level "element", keep the dominant part of every element by verdicts over the set points ("own") or
        by [FGL87]'s ("text"). This level is written without a search: its error is stated as its
        budget; `budget` only says which elements are negligible.
    at_set_points
        Keep the budget at the set points only; by default it holds near the motion, near each of several, see
        `simplify`. With `operations` it holds at the set points.
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

    budget: Budget | str | None = None
    level: str | Level = TERM
    refit: bool = False
    operations: int | None = None
    verdicts: str = "own"
    at_set_points: bool = False
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
        if self.budget is not None:
            object.__setattr__(self, "budget", Budget.of(self.budget))
        object.__setattr__(self, "margin", Margin.of(self.margin))
        if isinstance(self.uncertainty, str):
            object.__setattr__(self, "uncertainty", StatedUncertainty.parse(self.uncertainty))
        level = level_named(self.level)
        SearchOptions(level, self.refit, self.operations)  # refuses options that no search accepts
        if self.operations is not None or self.at_set_points:
            require_no_budget(level, f"operations {self.operations}, at_set_points {self.at_set_points}")
        if self.verdicts not in VERDICT_SOURCES or (self.verdicts != "own" and level is not ELEMENT):
            expected = f"{' or '.join(VERDICT_SOURCES)}, with level element"
            found = f"{self.verdicts}, level {level}"
            raise UsageError("these verdicts are of no use", where="verdicts", expected=expected, found=found)
        object.__setattr__(self, "level", level)
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


class JobProgress(Protocol):
    """Receiver of progress."""

    def __call__(self, label: str, total: int | None = None) -> None:
        """Begin a stage of `total` steps, or of an unknown number."""

    def advance(self, steps: int) -> None:
        """Note that some steps are done."""

    def ranked(self, ranking: xr.Dataset, budget: str) -> None:
        """Take the first answer, the result of `rank` at a budget, while models are searched."""


class _Silent:
    def __call__(self, label: str, total: int | None = None) -> None: ...

    def advance(self, steps: int) -> None: ...

    def ranked(self, ranking: xr.Dataset, budget: str) -> None: ...


@one_thread()
def analyze(
    arm: RobotArm | str | Path,
    trajectory: GivenMotions,
    out: str | Path | None = None,
    settings: Settings | None = None,
    *,
    formats: Collection[str] = tuple(RESULT_FILES),
    overwrite: bool = False,
    **options: Any,
) -> Findings:
    """Run the main job: find everything, and write it to a folder if one is named.

    Parameters
    ----------
    arm, trajectory
        What to analyse, along one motion or several; or a shipped name, or the path of a file. A folder
        stands for all trajectories in it.
    out
        Folder for the results; without it nothing is written.
    settings, options
        A `Settings` object, or its fields one by one, such as ``budget="0.5%"``.
    formats
        Files to write, of "h5", "json", "csv", "html" and "pdf".
    overwrite
        Replace a run in the folder of another arm or motion, or with other options.

    Returns
    -------
    Findings
        What was found; the files hold the same.

    Raises
    ------
    UsageError
        If an option or format is unknown, or settings and options are both given.
    OutputError
        If the folder cannot be written to or holds another run; nothing is computed or written.
    StorageError
        If the machine fails while the files are written, e.g. a full disk; earlier files remain.
    GdAnalyzeError
        As for `find`.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> findings = gd.analyze("puma560", "pick-and-place", budget="5%")
    >>> findings.model.operations.total < findings.model.operations_full.total
    True
    """
    names = [entry.name for entry in fields(Settings)]
    for name in sorted(options.keys() - names):
        near = difflib.get_close_matches(name, names, n=1)
        what, hint = f"there is no option {name!r}", f"did you mean {near[0]!r}?" if near else None
        raise UsageError(what, where=name, expected=", ".join(names), next_step=hint)
    if settings is not None and options:
        raise UsageError("settings are given twice", where="settings", expected="an object or its fields")
    how = settings or Settings(**options)
    if out is None:
        return find(arm, trajectory, how)
    if out == "":
        raise UsageError("the name of the folder is empty", where="out", next_step="name a folder, or none")
    folder, arm = Path(out), arm_of(arm)
    motion = trajectory_of(trajectory, arm)
    mark = source_of(arm, motion, how)["run"]
    strangers = require_one_run(folder, RESULT_FILES, formats, mark, overwrite=overwrite)
    findings = find(arm, motion, how)
    write_findings(findings, folder, formats, strangers)
    return findings


@one_thread()
def find(
    arm: RobotArm | str | Path,
    trajectory: GivenMotions,
    settings: Settings | None = None,
    *,
    command: str = "",
    warned: Iterable[str] = (),
    progress: JobProgress | None = None,
) -> Findings:
    """Decompose, check, rank and simplify; nothing is written.

    Parameters
    ----------
    arm, trajectory
        What to analyse, along one motion or several; or a shipped name, or the path of a file. A folder
        stands for all trajectories in it.
    settings
        Settings of the main job, see `Settings` for the defaults.
    command, warned
        What the user typed, and warnings given while the input was read; those given here are added.
    progress
        Told the stages of the work.

    Returns
    -------
    Findings
        Everything found.

    Raises
    ------
    GdAnalyzeError
        If inputs do not fit together, friction is to be fitted without measured torques, or a result
        disagrees with Pinocchio.
    """
    job = _job(arm, trajectory, settings or Settings(), command, progress or _Silent())
    job.stage("decomposing", job.trajectory.n_set_points)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GdAnalyzeWarning)
        _warn_of_inputs(job)
        evaluation = _evaluated(job)
        search = _searched(job, evaluation)
        if evaluation.too_many_terms:
            text = (
                f"{job.arm.name} has {evaluation.too_many_terms}: elements are ranked, single terms are not"
            )
            warnings.warn(text, GdAnalyzeWarning, stacklevel=2)
    messages = warnings_said(caught, warned)
    job.stage("trying other budgets")
    budgets = _other_budgets(job, evaluation, search)
    job.stage("bounding errors")
    search = _bounded(job, evaluation, search)
    trajectory, dataset = job.trajectory, evaluation.dataset
    if evaluation.long is not None:
        trajectory = trajectory.at(np.union1d(evaluation.long.shown, search.worst))
        dataset = decompose(job.arm, trajectory, **job.stored)
        dataset.attrs |= job.source
    evaluation = replace(evaluation, dataset=dataset)
    return Findings(
        arm=job.arm,
        trajectory=trajectory,
        tables=_tables(job, trajectory, evaluation, search, budgets),
        model=search.held.model,
        element_model=search.held.model if level_named(job.how.level) is ELEMENT else search.elements,
        ranked_terms={ranked.term: ranked.weight for ranked in budgets.ranking.terms},
        warnings=tuple(dict.fromkeys(messages)),
        provenance=job.source,
    )


@dataclass(frozen=True, eq=False)
class _Job:
    """What is asked: an arm, a motion and settings."""

    arm: RobotArm
    trajectory: Trajectory
    how: Settings
    source: dict[str, str]  # origin of the results
    stage: JobProgress
    tube: Tube
    has_tube: bool  # whether states near the motion are known

    @property
    def stored(self) -> dict[str, Any]:
        """Options of a decomposition that is stored."""
        christoffel = self.how.christoffel
        if christoffel is None:
            christoffel = self.trajectory.n_set_points <= MOST_KEPT
        how = self.how
        return {"by_link": how.by_link, "terms": how.terms, "drives": how.drives, "christoffel": christoffel}


@dataclass(frozen=True, eq=False)
class _Evaluation:
    """The exact dynamics at the set points, checked."""

    dataset: xr.Dataset
    exact: ExactDynamics
    residuals: tuple[Residual, ...]
    measured_torque: xr.Dataset | None
    diagnosis: xr.Dataset | None  # where measured torques contradict the arm
    too_many_terms: str  # why single terms are not ranked; "" if they are
    long: LongMotion | None  # a motion of more set points than are kept


@dataclass(frozen=True, eq=False)
class _Search:
    """The run's model, and those of the named budgets."""

    exact: ExactDynamics  # under the run's budget
    budget: Budget
    stops: list[Stop]
    own_stop: Stop | None  # that of the run's budget
    is_exact: bool  # whether the exact torque stands for a model that nobody could read
    held: Held
    elements: SimplifiedModel  # the model of level element
    dominance: xr.Dataset
    worst: np.ndarray  # further set points of a long motion


@dataclass(frozen=True, eq=False)
class _OtherBudgets:
    """Models from a tenth to ten times the budget, and the ranking of single terms."""

    path: tuple[SimplifiedModel, ...]
    own: int  # place of the run's model on the path
    places: dict[int, int]  # place on the path by number of the stop
    ranking: TermRanking


def _job(
    arm: RobotArm | str | Path, trajectory: GivenMotions, how: Settings, command: str, stage: JobProgress
) -> _Job:
    """Read the inputs, and refuse those that do not fit together."""
    arm = arm_of(arm)
    if how.uncertainty is not None:
        arm = with_uncertainty(arm, how.uncertainty)
    motion = trajectory_of(trajectory, arm)
    if how.fit_friction:
        require_torques(motion)
    no_torque = np.zeros(arm.n_joints)
    how.asked.allowed(ReferenceTorques(arm, no_torque, no_torque))  # a budget that does not fit fails first
    tube, has_tube = _tube_along(arm, motion, Margin.of(how.margin))
    return _Job(arm, motion, how, source_of(arm, motion, how, command), stage, tube, has_tube)


def _warn_of_inputs(job: _Job) -> None:
    warn_of_implausible(job.arm, stacklevel=2)
    for motion in taken_apart(job.trajectory):
        check_against_arm(motion, job.arm)
    if job.trajectory.n_stated == 1:
        warnings.warn(
            f"trajectory {job.trajectory.name} is one set point: verdicts, ranking and model are of this "
            "state and its surroundings; what other states need, or anything over time, takes a motion",
            GdAnalyzeWarning,
            stacklevel=2,
        )


def _evaluated(job: _Job) -> _Evaluation:
    """Decompose the dynamics at the set points, and check them against Pinocchio and the log's torques."""
    arm, motion, how = job.arm, job.trajectory, job.how
    long = None
    if motion.n_set_points > MOST_KEPT and not motion.motions and motion.recording is None:
        long = LongMotion.of(arm, motion, how.drives, job.stage.advance)
        dataset = decompose(arm, motion.at(long.searched), drives=how.drives, christoffel=False)
    else:
        dataset = decompose_on_demand(arm, motion, **job.stored, progress=job.stage.advance)
    job.stage("checking and ranking")
    dataset.attrs |= job.source
    residuals = cross_check(arm, dataset)
    exact = ExactDynamics.of(arm, dataset)
    warn_without_torque(exact)
    warn_of_torque_limits(arm, exact.states, exact.torque)
    measured_torque = diagnosis = None
    if motion.recording is not None and motion.recording.torque is not None:
        comparison = compared(arm, motion, np.asarray(dataset.torque.values))
        measured_torque = motion_tables.measured_torque_table(
            comparison, motion, fit_friction=how.fit_friction
        )
        if not is_described(measured_torque):
            diagnosis, answer = _diagnosis(arm, motion)
            text = torque_warning(measured_torque, arm, diagnosis, answer)
            warnings.warn(text, LeadingWarning, stacklevel=2)
    return _Evaluation(
        dataset, exact, residuals, measured_torque, diagnosis, too_many_terms(exact.form), long
    )


def _diagnosis(arm: RobotArm, motion: Trajectory) -> tuple[xr.Dataset | None, str]:
    """Why log and arm contradict each other, and the answer; no table if nothing can be compared."""
    try:
        tabulated = diagnosis_table(diagnosed(arm, [motion]))
    except UsageError as error:
        return None, f"No diagnosis: {error.what}."
    return tabulated, str(tabulated.attrs["answer"])


def _searched(job: _Job, evaluation: _Evaluation) -> _Search:
    """Search the models of the named budgets, and take that of the run."""
    how, stage, dataset = job.how, job.stage, evaluation.dataset
    level, exact, long = level_named(how.level), evaluation.exact, evaluation.long
    first = exact.under(how.asked)
    ranking = rank(dataset, threshold=how.dominance, budget=first.allowed(how.asked))
    stage.ranked(ranking, str(how.asked))
    stops, budget = _stops(exact, how, partial(_model_at, job))
    exact = exact.under(budget)
    own_stop = next((stop for stop in stops if stop.budget == budget), None)
    # Without a model that can be read, the exact torque stands for it; one asked for may be long.
    is_exact = own_stop is not None and not (
        own_stop.is_readable or (how.budget is not None and own_stop.saves)
    )
    searched = [stop.held for stop in stops if stop is own_stop and stop.held is not None]

    def models_at(exact: ExactDynamics) -> tuple[SimplifiedModel, Held]:
        elements = with_gamma(exact, model_by_verdicts(exact, how.verdicts, how.dominance))
        elements = replace(elements, provenance=job.source)
        if level is ELEMENT:
            return elements, Held(elements)
        if is_exact:
            model = with_gamma(exact, exactly(exact, FAST, exact.allowed(budget), str(budget)))
            return elements, Held(replace(model, provenance=job.source))
        # The first call searches no second time.
        return elements, searched.pop() if searched else _model_at(job, exact, budget)

    worst, extremes = np.empty(0, dtype=np.intp), None
    if long is None:
        elements, held = models_at(exact)
    else:
        exact, elements, held, worst = long.settled(exact, models_at)
        extremes = long.extremes
    dominance = rank(dataset, threshold=how.dominance, budget=exact.allowed(budget), extremes=extremes)
    return _Search(exact, budget, stops, own_stop, is_exact, held, elements, dominance, worst)


def _model_at(
    job: _Job, exact: ExactDynamics, budget: Budget, *, shortest: bool = True, most_terms: float = math.inf
) -> Held:
    """Search the model of a budget, near the motion or at its set points."""
    how, stage = job.how, job.stage
    options = SearchOptions(
        level_named(how.level), how.refit, how.operations, write=shortest, most_terms=most_terms
    )
    if how.at_set_points or how.operations is not None or not job.has_tube:
        model = simplify_exact(
            exact, budget, options, progress=stage.advance, provenance=job.source, stage=stage
        )
        return Held(model)
    return simplify_held(
        exact, budget, job.tube, options, effort=_EFFORTS[1], provenance=job.source, stage=stage
    )


def _other_budgets(job: _Job, evaluation: _Evaluation, search: _Search) -> _OtherBudgets:
    """Models of other budgets, those of readable stops among them, and the ranking of single terms."""
    exact, model, long = search.exact, search.held.model, evaluation.long
    if search.is_exact:
        # The exact torque stands alone: its path has no terms that others share.
        path: Sequence[SimplifiedModel] = (model,)
    else:
        near = search.held.near or exact
        # With a limit on operations, and at level element, the model keeps another budget.
        path = budget_path(near, model.accuracy.asked, measured(near, model))
    path = tuple(measured(exact, step) for step in path) if long is None else long.path(exact, path)
    models = {
        number: stop.held.model
        for number, stop in enumerate(search.stops)
        if stop.is_readable and stop.held is not None and stop is not search.own_stop and not search.is_exact
    }
    path, stop_places = joined_path(path, [measured(exact, each) for each in models.values()])
    own = next(place for place, step in enumerate(path) if step.accuracy.budget == model.accuracy.budget)
    places = dict(zip(models, stop_places, strict=True))
    if search.own_stop is not None and not search.is_exact:
        places[search.stops.index(search.own_stop)] = own
    ranking = TermRanking()
    if not evaluation.too_many_terms:
        selections = [step.terms for step in path if step.level is TERM and not step.is_exact]
        ranking = rank_terms(exact, also=selections)
    return _OtherBudgets(path, own, places, ranking)


def _bounded(job: _Job, evaluation: _Evaluation, search: _Search) -> _Search:
    """Prove a bound near the motion where the search did not."""
    held, model = search.held, search.held.model
    efforts = _efforts(evaluation, search)
    if not job.has_tube or held.certificate is not None or efforts is None:
        return search
    certificate = certify(model, job.tube, effort=efforts[1], harmonics=search.exact.form.harmonics)
    model = proven(model, certificate)
    return replace(search, held=held._replace(model=model, certificate=certificate))


def _tables(
    job: _Job, trajectory: Trajectory, evaluation: _Evaluation, search: _Search, budgets: _OtherBudgets
) -> dict[str, xr.Dataset]:
    """All tables of a run, as `schema.csv` declares them; of a long motion at the set points shown."""
    arm, how = job.arm, job.how
    dataset, long, exact = evaluation.dataset, evaluation.long, search.exact
    held, model, dominance = search.held, search.held.model, search.dominance
    tube = job.tube
    if job.has_tube and held.certificate is None:
        tube = replace(tube, note=_why_unproven(model))
    # From a long pool, set points are taken evenly; peaks are over all.
    over_time = dataset.isel(time=evenly(trajectory.n_set_points, MOST_KEPT)) if long is None else dataset
    tables = {
        "trajectory": motion_tables.trajectory_table(arm, trajectory),
        "decomposition": dataset,
        "cross_check": run_tables.cross_check_table(evaluation.residuals, arm),
        "dominance": dominance,
        "dominance_over_time": dominance_over_time(over_time, dominance),
        "simplified_model": run_tables.model_table(model, dataset),
        "parts": run_tables.parts_table(search.elements, exact, dominance),
        "by_verdicts": run_tables.verdicts_table(exact, how.dominance),
        "terms": run_tables.terms_table(budgets.ranking, arm, not evaluation.too_many_terms),
        "budgets": run_tables.budgets_table(budgets.path, budgets.own, budgets.ranking),
        "beyond": _beyond(exact, model, budgets.ranking, _efforts(evaluation, search)),
        "tube": run_tables.tube_table(model, tube, held, Margin.of(how.margin)),
    }
    if search.stops:
        places = [budgets.places.get(number, -1) for number in range(len(search.stops))]
        tables["stops"] = stops_table(search.stops, places, arm)
    if trajectory.recording is not None and trajectory.recording.measured:
        tables["recording"] = motion_tables.recording_table(arm, trajectory, dataset, dominance)
    if evaluation.measured_torque is not None:
        tables["measured_torque"] = evaluation.measured_torque
    if evaluation.diagnosis is not None:
        tables["diagnosis"] = evaluation.diagnosis
    if trajectory.motions:
        allowed = [alone.allowed(search.budget) for alone in exact.by_motion.values()]
        ranked = motion_tables.rank_by_motion(arm, dataset, trajectory, allowed)
        tables["motions"] = motion_tables.motions_table(
            arm, trajectory, dominance, ranked, model.accuracy, held.certificate
        )
    if long is not None:
        stores_every = how.every_set_point
        if stores_every is None:
            stores_every = long.motion.n_set_points <= MOST_STORED
        if stores_every:
            tables["every_set_point"] = motion_tables.every_set_point_table(
                arm, long.motion, model, **job.stored
            )
    if arm.spread is not None or any(link.uncertainty is not None for link in arm.links):
        tables["robustness"] = robustness(arm, trajectory, threshold=how.dominance, samples=_SAMPLES)
    return tables


def _stops(exact: ExactDynamics, how: Settings, search_at: Callable[..., Held]) -> tuple[list[Stop], Budget]:
    """Search for every named budget, and take that of the run: the one asked for, or the first readable one.

    At other levels, and with a limit on operations, there is one budget, which is searched later.
    """
    level = level_named(how.level)
    if level is not TERM or how.operations is not None:
        return [], how.asked
    named = named_budgets(exact.arm)
    budgets = named if how.budget is None else (how.asked, *(each for each in named if each != how.asked))
    stops: list[Stop] = []
    for budget in budgets:
        is_asked = how.budget is not None and not stops
        # Programs of models that are not the run's are not searched for their shortest form.
        is_own = is_asked or (
            how.budget is None and not any(stop.is_readable and stop.saves for stop in stops)
        )
        most_terms = math.inf if is_asked else READABLE
        search = partial(search_at, exact, shortest=is_own, most_terms=most_terms)
        stops.append(stop_at(exact, TERM, budget, search, most_terms))
    readable = chosen_stop(stops)
    if readable is None and stops[0].terms_beyond >= 0 and (wider := wider_stop(exact, TERM, budgets[0])):
        stops.append(wider)
    return stops, how.asked if how.budget is not None or readable is None else readable.budget


def source_of(arm: RobotArm, trajectory: Trajectory, how: Settings, command: str = "") -> dict[str, str]:
    """Origin of the results; the inputs and what the results state of the motion mark the run."""
    asked = [arm.name, trajectory.name, how.described, *(motion.name for motion in trajectory.motions)]
    motion = [trajectory.fingerprint, trajectory.origin, trajectory.derivatives_from]
    return provenance_of_run(command, asked, [describe_in_full(arm), motion], repeats=True)


def _efforts(evaluation: _Evaluation, search: _Search) -> _Efforts:
    """Efforts of the certificates in a box and along a motion; None if the model has too many terms."""
    if search.is_exact:
        return None
    if not evaluation.too_many_terms:
        return _EFFORTS
    model = search.held.model
    with suppress(TooLongError):
        if not model.is_exact and usual_effort(model) is not None:
            return _LITTLE
    return None


def _beyond(
    exact: ExactDynamics, model: SimplifiedModel, ranking: TermRanking, efforts: _Efforts
) -> xr.Dataset:
    """Test a model at states it was not fitted on."""
    arm, states = exact.arm, exact.states
    certificate = errors = None
    if efforts is not None:
        box = Box.around(*states.arrays)
        certificate = certify(model, box, effort=efforts[0], harmonics=exact.form.harmonics)
    if arm.has_all_limits:
        drawn = exact.at(states_in_box(arm, _DRAWN))
        errors = drawn.errors_of(model.torque(*drawn.states.arrays))
    payload, drawn_states = payload_effect(model, states), _DRAWN if errors else 0
    return run_tables.beyond_table(model, certificate, errors, payload, ranking.uncertainty, drawn_states)


def _tube_along(arm: RobotArm, motion: Trajectory, margin: Margin) -> tuple[Tube, bool]:
    """Enclose a motion in a tube; if that fails, return a tube without known states, and False."""
    try:
        return Tube.along(arm, motion, margin), True
    except TrajectoryError as error:
        # Statements about the set points themselves remain true.
        unknown = np.full((1, 3, arm.n_joints), np.nan)
        margins, note = margin.along(arm, motion), f"Not certified: {error.what} ({error.details['where']})."
        return Tube(unknown, unknown, motion.time[:1], motion.time[-1:], margins, motion.name, 0, note), False


def _why_unproven(model: SimplifiedModel) -> str:
    why = "the model is the exact torque, with no error but round-off to bound"
    if not model.is_exact:
        why = f"{model.arm.name} has too many equations to be written out here; `gd-analyze certify` does it"
    return f"Not certified: {why}."


def default_folder(arm: RobotArm, trajectory: Trajectory, settings: Settings) -> Path:
    """Default folder of the results; its name contains the options that are not defaults."""
    words, usual = [arm.name, trajectory.name], Settings().described
    for key, value in settings.described.items():
        if value != usual[key]:
            name = key.replace("_", "-")
            text = str(settings.asked).replace("%", "pct") if key == "budget" else str(value)
            said = f"{name}-{re.sub('[^A-Za-z0-9.]+', '_', text)}"
            words.append(said if not isinstance(value, bool) else name if value else f"no-{name}")
    return Path("reports") / "-".join(words)
