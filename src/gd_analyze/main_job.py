"""The main job: arm and trajectory in; decomposition, ranking, model, store and reports out."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection, Iterable
from pathlib import Path

import numpy as np

from gd_analyze.certification import Box, certify
from gd_analyze.decomposition import decompose
from gd_analyze.dominance import peak_magnitude, rank
from gd_analyze.errors import GdAnalyzeWarning, UsageError
from gd_analyze.findings import Beyond, Findings
from gd_analyze.models import (
    ElementModel,
    ErrorTable,
    HarmonicModel,
    Level,
    SimplifiedModel,
    evaluate,
)
from gd_analyze.pinocchio_check import cross_check
from gd_analyze.provenance import provenance
from gd_analyze.results import FILES, default_folder, require_writable, write_findings
from gd_analyze.robots import RobotArm
from gd_analyze.simplification import (
    Budget,
    ExactDynamics,
    TermRanking,
    payload_effect,
    rank_terms,
    simplify_exact,
    states_in_box,
    trade_off,
)
from gd_analyze.simplification.trade_off import KINDS
from gd_analyze.trajectories import Trajectory

# Torque terms of an exact form up to which terms are worth choosing from: a seven-joint arm of general make
# has tens of thousands, and any model of them more operations than one of whole elements.
_MOST_TERMS = 2000
# Joints up to which identifying the exact form takes no more than a second.
_MOST_JOINTS = 8
# Multiples of the budget that the report's curve shows, and states drawn to try a model beyond its own.
_FACTORS = (0.5, 1.0, 2.0, 5.0)
_DRAWN = 1000
# Of the certificate: close to the truth in a box as small as a trajectory's.
_EFFORT = 5_000


def find(
    arm: RobotArm,
    trajectory: Trajectory,
    *,
    budget: Budget | None = None,
    level: Level | None = None,
    refit: bool = False,
    operations: int | None = None,
    drives: bool = False,
    coupling: bool = True,
    by_link: bool = False,
    terms: bool = False,
    command: str = "",
    warned: Iterable[str] = (),
    progress: Callable[[int], None] | None = None,
) -> Findings:
    """Decompose, check, rank and simplify; nothing is written.

    Parameters
    ----------
    arm, trajectory
        What to analyse.
    budget
        Allowed torque error; 1 % of each joint's peak torque by default.
    level, refit, operations
        How to simplify, see `simplify`; by default level "term", and "element", the text's own method, for
        an arm whose exact equations have so many terms that fewer would not be fewer operations.
    drives
        Include drive inertia as a separate contribution.
    coupling, by_link, terms
        What else to keep of the decomposition, see `decompose`.
    command
        What the user typed, for provenance.
    warned
        Warnings given while the input was read; those given here are added.
    progress
        Called with the number of set points done since the last call.

    Returns
    -------
    Findings
        Everything found.

    Raises
    ------
    GdAnalyzeError
        If the input does not fit together, or a result disagrees with Pinocchio.
    """
    budget = budget or Budget()
    budget.allowed(np.ones(arm.n_joints))  # a budget of a wrong length shall fail before any computing
    source = provenance(command)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GdAnalyzeWarning)
        dataset = decompose(
            arm,
            trajectory,
            coupling=coupling,
            by_link=by_link,
            terms=terms,
            drives=drives,
            progress=progress,
        )
        dataset.attrs |= source
        residuals = cross_check(arm, dataset)
        allowed = budget.allowed(peak_magnitude(dataset.torque.values))
        dominance = rank(dataset, budget=allowed)
        exact = ExactDynamics.of(arm, dataset)
        elements = simplify_exact(exact, budget, level="element", provenance=source)
        assert isinstance(elements, ElementModel)  # as the level says
        if level is None:
            many = _told_to_stay_with_elements(exact)
        else:
            many = level == "element" and _is_large(exact)
        level = level or ("element" if many else "term")
        model: SimplifiedModel = elements
        if level != "element":
            model = simplify_exact(
                exact,
                budget,
                level=level,
                refit=refit,
                operations=operations,
                thorough=False,
                provenance=source,
            )
        elif operations is not None:
            model = simplify_exact(exact, budget, level=level, operations=operations, provenance=source)
    return Findings(
        arm=arm,
        trajectory=trajectory,
        decomposition=dataset,
        dominance=dominance,
        harmonics=None if many else exact.harmonics,
        model=model,
        evaluation=evaluate(model, trajectory, dataset),
        element_model=elements,
        terms=TermRanking.none() if many else rank_terms(exact),
        trade_off=trade_off(
            exact, budget, factors=_FACTORS, kinds=KINDS[:1] if many else KINDS, thorough=False
        ),
        beyond=_beyond(exact, model),
        residuals=residuals,
        warnings=(*warned, *_told(caught)),
        provenance=source,
    )


def _is_large(exact: ExactDynamics) -> bool:
    """Whether an arm has too many joints, or its exact equations too many terms, to choose from."""
    return exact.arm.n_joints > _MOST_JOINTS or len(exact.torques) > _MOST_TERMS


def _told_to_stay_with_elements(exact: ExactDynamics) -> bool:
    if not _is_large(exact):
        return False
    if exact.arm.n_joints > _MOST_JOINTS:
        what = f"{exact.arm.n_joints} joints, more than {_MOST_JOINTS}"
    else:
        what = f"exact equations of {len(exact.torques)} terms, more than {_MOST_TERMS}"
    warnings.warn(
        f"{exact.arm.name} has {what}: simplified by elements, and single terms are not ranked here",
        GdAnalyzeWarning,
        stacklevel=3,
    )
    return True


def _beyond(exact: ExactDynamics, model: SimplifiedModel) -> Beyond:
    """Hold a model against states it was not made for."""
    arm, states = exact.arm, exact.states
    certificate = None
    if isinstance(model, HarmonicModel):
        certificate = certify(
            model,
            Box.around(states.q, states.qd, states.qdd),
            effort=_EFFORT,
            harmonics=exact.harmonics,
        )
    table = None
    if arm.has_all_limits:
        drawn = ExactDynamics(arm, states_in_box(arm, _DRAWN), model.drives)
        torque = model.torque(drawn.states.q, drawn.states.qd, drawn.states.qdd)
        table = ErrorTable.of(drawn.torque, torque)
    return Beyond(certificate, table, _DRAWN if table else 0, payload_effect(model, states))


def _told(caught: list[warnings.WarningMessage]) -> list[str]:
    """Our own warnings as sentences; those of other libraries go on to whoever listens."""
    for item in caught:
        if not issubclass(item.category, GdAnalyzeWarning):
            warnings.warn_explicit(item.message, item.category, item.filename, item.lineno)
    return [str(item.message) for item in caught if issubclass(item.category, GdAnalyzeWarning)]


def analyze(
    arm: RobotArm,
    trajectory: Trajectory,
    out: str | Path | None = None,
    *,
    formats: Collection[str] = tuple(FILES),
    budget: Budget | None = None,
    level: Level | None = None,
    refit: bool = False,
    operations: int | None = None,
    drives: bool = False,
    coupling: bool = True,
    by_link: bool = False,
    terms: bool = False,
    command: str = "",
    warned: Iterable[str] = (),
    progress: Callable[[int], None] | None = None,
) -> Findings:
    """Do the main job: find everything and write it down.

    Parameters
    ----------
    arm, trajectory
        What to analyse.
    out
        Folder for the results; `reports/<arm>-<trajectory>` by default.
    formats
        Which files to write, of `FILES`.
    budget, level, refit, operations, drives, coupling, by_link, terms, command, warned, progress
        As for `find`.

    Returns
    -------
    Findings
        What was found; the files hold the same.

    Raises
    ------
    OutputError
        If the folder cannot be written to; nothing is computed or written then.
    GdAnalyzeError
        As for `find`.
    """
    folder = default_folder(arm, trajectory) if out is None else Path(out)
    unknown = sorted(set(formats) - set(FILES))
    if unknown:
        raise UsageError(
            f"there is no format {unknown[0]!r}", where="formats", expected=", ".join(FILES), found=unknown[0]
        )
    require_writable(folder)
    findings = find(
        arm,
        trajectory,
        budget=budget,
        level=level,
        refit=refit,
        operations=operations,
        drives=drives,
        coupling=coupling,
        by_link=by_link,
        terms=terms,
        command=command,
        warned=warned,
        progress=progress,
    )
    write_findings(findings, folder, formats)
    return findings
