"""The main job: arm and trajectory in; decomposition, ranking, model and bounds out."""

from __future__ import annotations

import difflib
import math
import re
import warnings
from collections.abc import Callable, Collection, Iterable
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
from gd_analyze.dynamics.decomposition import MOST_KEPT, decompose, decompose_on_demand
from gd_analyze.dynamics.dominance import DOMINANCE_THRESHOLD, rank
from gd_analyze.dynamics.dominance_over_time import dominance_over_time
from gd_analyze.dynamics.measured_torque import compared, require_torques
from gd_analyze.dynamics.pinocchio_check import cross_check
from gd_analyze.dynamics.robustness import robustness
from gd_analyze.dynamics.torque_limits import warn_of_torque_limits
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError, UsageError, warnings_said
from gd_analyze.files import RESULT_FILES, require_one_run
from gd_analyze.harmonics.expansion import TooLongError
from gd_analyze.motions.limits import check_against_arm
from gd_analyze.motions.margin import Margin
from gd_analyze.motions.pool import GivenMotions, taken_apart, trajectory_of
from gd_analyze.motions.states import states_in_box
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.results import motion_tables, run_tables
from gd_analyze.results.findings import Findings, provenance_of_run
from gd_analyze.results.motion_result import is_described, torque_warning
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.robots.description import describe_in_full
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.robots.uncertainty import with_uncertainty
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
from gd_analyze.simplification.verdicts import VERDICTS, model_by_verdicts, require_no_budget
from gd_analyze.studies.budget_stops import Stop, chosen, named_budgets, stop_at, stops_table, wider_stop
from gd_analyze.studies.long_motion import LongMotion
from gd_analyze.studies.study_files import write_findings

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
        by the founding text's ("text"). This level is written without a search: its error is stated as its
        budget; `budget` only says which elements are negligible.
    at_set_points
        Keep the budget at the set points only; by default it holds near the motion, near each of several, see
        `simplify_held`. With `operations` it holds at the set points.
    drives
        Include drive inertia as a separate contribution; by default if the arm describes drives.
    margin
        How far from the motion the budget holds and errors are bounded, or its text such as
        "1deg,1mm,qd=2%,qdd=5%", which is the default.
    dominance
        Share of an element's peak that leaving a part out may change, see `rank`.
    uncertainty
        Standard uncertainties of all links in place of those the arm states, see `robustness`.
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
    uncertainty: str | None = None
    fit_friction: bool = False
    christoffel: bool | None = None
    by_link: bool = False
    terms: bool = False
    every_set_point: bool | None = None

    def __post_init__(self) -> None:
        if self.budget is not None:
            object.__setattr__(self, "budget", Budget.of(self.budget))
        object.__setattr__(self, "margin", Margin.of(self.margin))
        level = level_named(self.level)
        SearchOptions(level, self.refit, self.operations)  # refuses options that no search accepts
        if self.operations is not None or self.at_set_points:
            require_no_budget(level, f"operations {self.operations}, at_set_points {self.at_set_points}")
        if self.verdicts not in VERDICTS or (self.verdicts != "own" and level is not ELEMENT):
            expected = f"{' or '.join(VERDICTS)}, with level element"
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
        }


class Progress(Protocol):
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


def find(
    arm: RobotArm | str | Path,
    trajectory: GivenMotions,
    settings: Settings | None = None,
    *,
    command: str = "",
    warned: Iterable[str] = (),
    progress: Progress | None = None,
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
    arm, how = arm_of(arm), settings or Settings()
    if how.uncertainty is not None:
        arm = with_uncertainty(arm, how.uncertainty)
    trajectory = trajectory_of(trajectory, arm)
    if how.fit_friction:
        require_torques(trajectory)
    none = np.zeros(arm.n_joints)
    how.asked.allowed(ReferenceTorques(arm, none, none))  # a budget that does not fit fails before computing
    stage, source = progress or _Silent(), source_of(arm, trajectory, how, command)
    stage("decomposing", trajectory.n_set_points)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GdAnalyzeWarning)
        warn_of_implausible(arm, stacklevel=2)
        for motion in taken_apart(trajectory):
            check_against_arm(motion, arm)
        if trajectory.n_stated == 1:
            warnings.warn(
                f"trajectory {trajectory.name} is one set point: verdicts, ranking and model are of this "
                "state and its surroundings; what other states need, or anything over time, takes a motion",
                GdAnalyzeWarning,
                stacklevel=2,
            )
        kept: dict[str, Any] = {"by_link": how.by_link, "terms": how.terms, "drives": how.drives}
        kept["christoffel"] = (
            trajectory.n_set_points <= MOST_KEPT if how.christoffel is None else how.christoffel
        )
        long = None
        if trajectory.n_set_points > MOST_KEPT and not trajectory.motions and trajectory.recording is None:
            long = LongMotion.of(arm, trajectory, how.drives, stage.advance)
            dataset = decompose(arm, trajectory.at(long.searched), drives=how.drives, christoffel=False)
        else:
            dataset = decompose_on_demand(arm, trajectory, **kept, progress=stage.advance)
        stage("checking and ranking")
        dataset.attrs |= source
        residuals = cross_check(arm, dataset)
        exact = ExactDynamics.of(arm, dataset)
        warn_without_torque(exact)
        warn_of_torque_limits(arm, exact.states, exact.torque)
        measured_torque = None
        if trajectory.recording is not None and trajectory.recording.torque is not None:
            beside, fit = compared(arm, trajectory, np.asarray(dataset.torque.values)), how.fit_friction
            measured_torque = motion_tables.measured_torque_table(beside, trajectory, fit_friction=fit)
            if not is_described(measured_torque):
                warnings.warn(torque_warning(measured_torque, arm.name), GdAnalyzeWarning, stacklevel=2)
        level = level_named(how.level)
        many = too_many_terms(exact.form)
        tube, is_known = _tube_along(arm, trajectory, Margin.of(how.margin))
        usual = SearchOptions(level, how.refit, how.operations)
        at_set_points = how.at_set_points or how.operations is not None

        def search_at(
            exact: ExactDynamics, budget: Budget, *, shortest: bool = True, most_terms: float = math.inf
        ) -> Held:
            options: dict[str, Any] = {"provenance": source, "stage": stage}
            search = replace(usual, write=shortest, most_terms=most_terms)
            if at_set_points or not is_known:
                return Held(simplify_exact(exact, budget, search, progress=stage.advance, **options))
            return simplify_held(exact, budget, tube, search, effort=_EFFORTS[1], **options)

        first = exact.under(how.asked)
        stage.ranked(rank(dataset, threshold=how.dominance, budget=first.allowed(how.asked)), str(how.asked))
        stops, asked = _stops(exact, how, search_at)
        exact = exact.under(asked)
        by_budget = {str(stop.budget): stop.held for stop in stops}
        own_stop = next((stop for stop in stops if stop.budget == asked), None)
        # Without a model that can be read, the exact torque stands for it; one asked for may be long.
        is_exact = own_stop is not None and not (
            own_stop.is_readable or (how.budget is not None and own_stop.saves)
        )

        def models_at(exact: ExactDynamics) -> tuple[SimplifiedModel, Held]:
            elements = with_gamma(exact, model_by_verdicts(exact, how.verdicts, how.dominance))
            elements = replace(elements, provenance=source)
            if level is ELEMENT:
                return elements, Held(elements)
            if is_exact:
                everything = exactly(exact, FAST, exact.allowed(asked), str(asked))
                return elements, Held(replace(with_gamma(exact, everything), provenance=source))
            # The first call searches no second time.
            return elements, by_budget.pop(str(asked), None) or search_at(exact, asked)

        if long is None:
            elements, held = models_at(exact)
        else:
            exact, elements, held, worst = long.settled(exact, models_at)
        extremes = None if long is None else long.extremes
        dominance = rank(dataset, threshold=how.dominance, budget=exact.allowed(asked), extremes=extremes)
        if many:
            text = f"{arm.name} has {many}: elements are ranked, single terms are not"
            warnings.warn(text, GdAnalyzeWarning, stacklevel=2)
    said = warnings_said(caught, warned)
    stage("trying other budgets")
    model, near = held.model, held.near or exact
    # With a limit on operations, and at level element, the model keeps another budget.
    path = (model,) if is_exact else budget_path(near, model.accuracy.asked, measured(near, model))
    path = tuple(measured(exact, each) for each in path) if long is None else long.path(exact, path)
    # The exact torque stands alone: its path has no terms that others share.
    other_stops = [stop for stop in stops if stop.is_readable and stop is not own_stop and not is_exact]
    others = [stop.held.model for stop in other_stops if stop.held is not None]
    path, places = joined_path(path, [measured(exact, other) for other in others])
    own = next(place for place, each in enumerate(path) if each.accuracy.budget == model.accuracy.budget)
    ranking = TermRanking()
    if not many:
        ranking = rank_terms(
            exact, also=[each.terms for each in path if each.level is TERM and not each.is_exact]
        )
    stage("bounding errors")
    efforts = None if is_exact else _efforts(model, bool(many))
    if is_known and held.certificate is None and efforts is not None:
        certificate = certify(model, tube, effort=efforts[1], harmonics=exact.form.harmonics)
        model = proven(model, certificate)
        held = held._replace(certificate=certificate)
    elif is_known and held.certificate is None:
        tube = replace(tube, note=_why_unproven(model))
    if long is not None:
        trajectory = trajectory.at(np.union1d(long.shown, worst))
        dataset = decompose(arm, trajectory, **kept)
        dataset.attrs |= source
    # From a long pool, set points are taken evenly; peaks are over all.
    taken = dataset.isel(time=evenly(trajectory.n_set_points, MOST_KEPT)) if long is None else dataset
    tables = {
        "trajectory": motion_tables.trajectory_table(arm, trajectory),
        "decomposition": dataset,
        "cross_check": run_tables.cross_check_table(residuals, arm),
        "dominance": dominance,
        "dominance_over_time": dominance_over_time(taken, dominance),
        "simplified_model": run_tables.model_table(model, dataset),
        "parts": run_tables.parts_table(elements, exact, dominance),
        "by_verdicts": run_tables.verdicts_table(exact, how.dominance),
        "terms": run_tables.terms_table(ranking, arm, not many),
        "budgets": run_tables.budgets_table(path, own, ranking),
        "beyond": _beyond(exact, model, ranking, efforts),
        "tube": run_tables.tube_table(model, tube, held, Margin.of(how.margin)),
    }
    if stops:
        shown = iter(places)
        at = [next(shown) if stop in other_stops else -1 for stop in stops]
        if own_stop is not None and not is_exact:
            at[stops.index(own_stop)] = own
        tables["stops"] = stops_table(stops, at, arm)
    if trajectory.recording is not None and trajectory.recording.measured:
        tables["recording"] = motion_tables.recording_table(arm, trajectory, dataset, dominance)
    if measured_torque is not None:
        tables["measured_torque"] = measured_torque
    if trajectory.motions:
        allowed = [alone.allowed(asked) for alone in exact.by_motion.values()]
        ranked = motion_tables.rank_by_motion(arm, dataset, trajectory, allowed)
        tables["motions"] = motion_tables.motions_table(
            arm, trajectory, dominance, ranked, model.accuracy, held.certificate
        )
    if long is not None and (
        long.motion.n_set_points <= MOST_STORED if how.every_set_point is None else how.every_set_point
    ):
        tables["every_set_point"] = motion_tables.every_set_point_table(arm, long.motion, model, **kept)
    if arm.spread is not None or any(link.uncertainty is not None for link in arm.links):
        tables["robustness"] = robustness(arm, trajectory, threshold=how.dominance, samples=_SAMPLES)
    return Findings(
        arm=arm,
        trajectory=trajectory,
        tables=tables,
        model=model,
        element_model=model if level is ELEMENT else elements,
        ranked_terms={ranked.term: ranked.weight for ranked in ranking.terms},
        warnings=tuple(dict.fromkeys(said)),
        provenance=source,
    )


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
    readable = chosen(stops)
    if readable is None and stops[0].terms_beyond >= 0 and (wider := wider_stop(exact, TERM, budgets[0])):
        stops.append(wider)
    return stops, how.asked if how.budget is not None or readable is None else readable.budget


def source_of(arm: RobotArm, trajectory: Trajectory, how: Settings, command: str = "") -> dict[str, str]:
    """Origin of the results; the inputs and what the results state of the motion mark the run."""
    asked = [arm.name, trajectory.name, how.described, *(motion.name for motion in trajectory.motions)]
    motion = [trajectory.fingerprint, trajectory.origin, trajectory.derivatives_from]
    return provenance_of_run(command, asked, [describe_in_full(arm), motion], repeats=True)


def _efforts(model: SimplifiedModel, many: bool) -> _Efforts:
    """Efforts of the certificates in a box and along a motion; None if the model has too many terms."""
    if not many:
        return _EFFORTS
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
