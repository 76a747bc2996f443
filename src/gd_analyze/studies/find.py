"""The main job's computing: arm and trajectory in; decomposition, ranking, model, curve and bounds out."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import Certificate, certify, expansion_of
from gd_analyze.certification.tube import Margin, Tube
from gd_analyze.dynamics.dominance import rank
from gd_analyze.dynamics.long_decomposition import decompose_on_demand
from gd_analyze.dynamics.measured_torque import compared, require_torques
from gd_analyze.dynamics.pinocchio_check import cross_check
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError
from gd_analyze.harmonics.expansion import TooLongError
from gd_analyze.motions.checks import check_against_arm
from gd_analyze.motions.pool import GivenMotions, taken_apart, trajectory_of
from gd_analyze.motions.states import states_in_box
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.results import tables
from gd_analyze.results.budgets_table import budgets_table
from gd_analyze.results.findings import Findings
from gd_analyze.results.motions_table import motions_table, rank_by_motion
from gd_analyze.results.provenance import provenance_of_run
from gd_analyze.results.recording_table import recording_table
from gd_analyze.results.torque_table import measured_torque_table
from gd_analyze.results.torque_words import is_described, torque_warning
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.robots.description import describe_in_full
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.simplification.budget import Budget, ReferenceTorques
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.evaluation import payload_effect
from gd_analyze.simplification.exact import ExactDynamics, warn_without_torque
from gd_analyze.simplification.exact_form import too_many_terms
from gd_analyze.simplification.levels import level_named
from gd_analyze.simplification.model import SimplifiedModel, no_dearer
from gd_analyze.simplification.ranking import TermRanking, rank_terms
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.simplification.term import TERM
from gd_analyze.simplification.trade_off import PATH_FACTORS, budget_path, kinds_for, trade_off
from gd_analyze.studies.settings_main import Origin, Progress, Settings, Silent

if TYPE_CHECKING:
    import xarray as xr

# Levels whose curves take tenths of a second.
_QUICK_CURVES = (ELEMENT, TERM, ENERGY)
# Multiples of the budget that the report's curve shows, and states drawn to try a model beyond its own.
_FACTORS = (0.5, 1.0, 2.0, 5.0)
_DRAWN = 1000
# Of certificates: close to the truth in a box as small as a trajectory's, and along a motion that is told.
_EFFORT, _EFFORT_OF_TUBE = 5_000, 100_000
# The same of a model that is not chosen by its terms, where it has no more than so many: a few seconds.
_LITTLE, _MOST_WRITTEN = (500, 2_000), 150_000


def find(
    arm: RobotArm | str | Path,
    trajectory: GivenMotions,
    settings: Settings | None = None,
    *,
    origin: Origin | None = None,
    progress: Progress | None = None,
) -> Findings:
    """Decompose, check, rank and simplify; nothing is written.

    Parameters
    ----------
    arm, trajectory
        What to analyse, along one motion or several; or a shipped name, or the path of a file. A folder
        stands for all trajectories in it.
    settings
        How; see `Settings` for what is done by default.
    origin
        The command, for provenance, and warnings given before; those given here, and those that arm and
        trajectory deserve, are added.
    progress
        Told the stages of the work.

    Returns
    -------
    Findings
        Everything found.

    Raises
    ------
    GdAnalyzeError
        If the input does not fit together, friction shall be fitted where no torque was measured, or a result
        disagrees with Pinocchio.
    """
    arm, how = arm_of(arm), settings or Settings()
    trajectory = trajectory_of(trajectory, arm)
    if how.fit_friction:
        require_torques(trajectory)
    none = np.zeros(arm.n_joints)
    _ = how.asked.allowed(
        ReferenceTorques(arm, none, none)
    )  # what does not fit shall fail before any computing
    before, stage = origin or Origin(), progress or Silent()
    source = source_of(arm, trajectory, how, before.command)
    stage("decomposing", trajectory.n_set_points)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GdAnalyzeWarning)
        warn_of_implausible(arm, stacklevel=2)
        for motion in taken_apart(trajectory):
            check_against_arm(motion, arm)
        dataset = decompose_on_demand(
            arm,
            trajectory,
            christoffel=how.christoffel,
            by_link=how.by_link,
            terms=how.terms,
            drives=how.drives,
            progress=stage.advance,
        )
        stage("checking and ranking")
        dataset.attrs |= source
        residuals = cross_check(arm, dataset)
        exact = ExactDynamics.of(arm, dataset).under(how.asked)
        warn_without_torque(exact)
        measured = _measured_torque(arm, trajectory, dataset, how)
        dominance = rank(dataset, budget=exact.allowed(how.asked))
        elements = simplify_exact(exact, how.asked, SearchOptions(ELEMENT, dearer=True), provenance=source)
        level = None if how.level is None else level_named(how.level)
        many = (level is None or not level.has_torque_terms) and too_many_terms(exact.form)
        if level is ELEMENT and how.operations is None:
            model = no_dearer(exact, elements)
        else:
            search = SearchOptions(level, how.refit, how.operations, thorough=level is ELEMENT)
            model = simplify_exact(
                exact, how.asked, search, provenance=source, progress=stage.advance, stage=stage
            )
        if many:
            warnings.warn(
                f"{arm.name} has {too_many_terms(exact.form)}: elements are ranked, single terms are not",
                GdAnalyzeWarning,
                stacklevel=2,
            )
    stage("trying other budgets")
    ranking = TermRanking() if many else rank_terms(exact)
    asked = _asked(exact, how.asked, model)
    path = budget_path(exact, asked, model)
    through = {(model.level, how.refit and model.level.has_torque_terms): path}
    # The curve of a recursion takes seconds: it is drawn where it is that of the model.
    kinds = [kind for kind in kinds_for(exact.form) if kind[0] in (*_QUICK_CURVES, model.level)]
    points = trade_off(exact, asked, factors=_FACTORS, kinds=kinds, thorough=False, through=through)
    stage("bounding errors")
    efforts = _efforts(model, many)
    recorded = {}
    if trajectory.recording is not None and trajectory.recording.measured:
        recorded["recording"] = recording_table(arm, trajectory, dataset, dominance)
    return Findings(
        arm=arm,
        trajectory=trajectory,
        tables={
            "trajectory": tables.trajectory_table(arm, trajectory),
            "decomposition": dataset,
            "cross_check": tables.cross_check_table(residuals, arm),
            "dominance": dominance,
            "simplified_model": tables.model_table(model, dataset, model.torque(*exact.states.arrays)),
            "parts": tables.parts_table(elements, exact, dominance),
            "terms": tables.terms_table(ranking, arm, not many),
            "trade_off": tables.trade_off_table(points, arm, how.asked.shares_of),
            "budgets": budgets_table(path, PATH_FACTORS, ranking),
            "beyond": _beyond(exact, model, ranking, efforts),
            "tube": _tube(exact, model, trajectory, Margin.of(how.margin), efforts),
            **recorded,
            **measured,
            **_by_motion(exact, dataset, trajectory, dominance, how, model),
        },
        model=model,
        element_model=elements,
        ranked_terms={ranked.term: ranked.weight for ranked in ranking.terms},
        warnings=tuple(dict.fromkeys([*before.warnings, *_told(caught)])),
        provenance=source,
    )


def source_of(arm: RobotArm, trajectory: Trajectory, how: Settings, command: str = "") -> dict[str, str]:
    """Where the results come from; what they depend on, and what of the motion they state, marks the run."""
    asked = [arm.name, trajectory.name, how.described(), *(motion.name for motion in trajectory.motions)]
    motion = [trajectory.fingerprint, trajectory.origin, trajectory.rates_from]
    return provenance_of_run(command, asked, [describe_in_full(arm), motion], repeats=True)


def _by_motion(
    exact: ExactDynamics,
    dataset: xr.Dataset,
    trajectory: Trajectory,
    dominance: xr.Dataset,
    how: Settings,
    model: SimplifiedModel,
) -> dict[str, xr.Dataset]:
    """Tell of each motion by itself, where there are several."""
    if not trajectory.motions:
        return {}
    allowed = [alone.allowed(how.asked) for alone in exact.by_motion.values()]
    ranked = rank_by_motion(exact.arm, dataset, trajectory, allowed)
    return {"motions": motions_table(exact.arm, trajectory, dominance, ranked, model.accuracy)}


def _asked(exact: ExactDynamics, budget: Budget, model: SimplifiedModel) -> Budget:
    """Give the budget that a model keeps to: scaled where a number of operations was asked for."""
    return budget.scaled(float((model.accuracy.allowed / exact.allowed(budget)).max()))


def _measured_torque(
    arm: RobotArm, trajectory: Trajectory, dataset: xr.Dataset, how: Settings
) -> dict[str, xr.Dataset]:
    """Hold the exact torque against the measured one, where there is one, and warn where it is another."""
    if trajectory.recording is None or trajectory.recording.torque is None:
        return {}
    comparison = compared(arm, trajectory, np.asarray(dataset.torque.values))
    table = measured_torque_table(comparison, trajectory, fit_friction=how.fit_friction)
    if not is_described(table):
        warnings.warn(torque_warning(table, arm.name), GdAnalyzeWarning, stacklevel=3)
    return {"measured_torque": table}


def _efforts(model: SimplifiedModel, many: bool) -> tuple[int, int] | None:
    """Efforts of the certificates in a box and along a motion; None for a model of too many terms for any."""
    if not many:
        return _EFFORT, _EFFORT_OF_TUBE
    if not model.saves:
        return None
    try:
        written = expansion_of(model)
    except TooLongError:
        return None
    terms = sum(np.count_nonzero(row.coefficients) for row in written.rows)
    return _LITTLE if terms <= _MOST_WRITTEN else None


def _beyond(
    exact: ExactDynamics, model: SimplifiedModel, ranking: TermRanking, efforts: tuple[int, int] | None
) -> xr.Dataset:
    """Hold a model against states it was not made for."""
    arm, states = exact.arm, exact.states
    certificate: Certificate | None = None
    if efforts is not None:
        box = Box.around(*states.arrays)
        certificate = certify(model, box, effort=efforts[0], harmonics=exact.form.harmonics)
    errors = None
    if arm.has_all_limits:
        drawn = exact.at(states_in_box(arm, _DRAWN))
        errors = drawn.errors_of(model.torque(*drawn.states.arrays))
    payload, drawn_states = payload_effect(model, states), _DRAWN if errors else 0
    return tables.beyond_table(model, certificate, errors, payload, ranking.uncertainty, drawn_states)


def _tube(
    exact: ExactDynamics,
    model: SimplifiedModel,
    motion: Trajectory,
    margin: Margin,
    efforts: tuple[int, int] | None,
) -> xr.Dataset:
    """Bound a model's errors around the motion, where its equations are few enough to be written out."""
    arm = exact.arm
    certificate = None
    try:
        tube = Tube.along(arm, motion, margin)
        if efforts is None:
            why = "the exact torque is given, so that there is no error but round-off to bound"
            if model.saves:
                large = "more equations than are written out here"
                why = f"{arm.name} has {large}; `gd-analyze certify` takes its time"
            tube = replace(tube, note=f"Not certified: {why}.")
        else:
            certificate = certify(model, tube, effort=efforts[1], harmonics=exact.form.harmonics)
    except TrajectoryError as error:
        # What is said of the set points themselves is as true as before.
        unknown = np.full((1, 3, arm.n_joints), np.nan)
        margins, note = margin.along(arm, motion), f"Not certified: {error.what} ({error.details['where']})."
        tube = Tube(unknown, unknown, motion.time[:1], motion.time[-1:], margins, motion.name, 0, note)
    return tables.tube_table(model, tube, certificate, margin)


def _told(caught: list[warnings.WarningMessage]) -> list[str]:
    """Our own warnings as sentences; those of other libraries go on to whoever listens."""
    for item in caught:
        if not issubclass(item.category, GdAnalyzeWarning):
            warnings.warn_explicit(item.message, item.category, item.filename, item.lineno)
    return [str(item.message) for item in caught if issubclass(item.category, GdAnalyzeWarning)]
