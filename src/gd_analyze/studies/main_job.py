"""The main job: arm and trajectory in; decomposition, ranking, model and bounds out, in five steps."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from types import NoneType
from typing import Any

from gd_analyze.arguments import strict, words_of
from gd_analyze.errors import UsageError, Warned, require_type
from gd_analyze.files import RESULT_FILES, path_of, require_one_run
from gd_analyze.motions.pool import GivenMotions, trajectory_of
from gd_analyze.motions.read import read_trajectory
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.results.findings import Findings
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_with_masses
from gd_analyze.studies.settings import Settings
from gd_analyze.studies.steps.collect import collect_step
from gd_analyze.studies.steps.decompose import decompose_step, rank_step, warn_of_too_many_terms
from gd_analyze.studies.steps.read import read_step, source_of, warn_of_inputs
from gd_analyze.studies.steps.simplify import simplify_step
from gd_analyze.studies.study_files import write_findings
from gd_analyze.threads import one_thread


@strict
@one_thread()
def analyze(
    arm: RobotArm | str | Path,
    trajectory: GivenMotions,
    out: str | Path | None = None,
    settings: Settings | None = None,
    *,
    formats: str | Collection[str] = tuple(RESULT_FILES),
    overwrite: bool = False,
    progress: Progress = NO_PROGRESS,
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
    progress
        Told the stages of the work, see `Progress`.

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

    Warns
    -----
    GdAnalyzeWarning
        Of all that is suspicious about arm and motion; `Findings.warnings` has the same.

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
        message, hint = f"there is no option {name!r}", f"did you mean {near[0]!r}?" if near else None
        raise UsageError(message, where=name, expected=", ".join(names), next_step=hint)
    if settings is not None and options:
        raise UsageError("settings are given twice", where="settings", expected="an object or its fields")
    require_type(settings, (Settings, NoneType), "settings", "a Settings object, or None")
    formats = words_of(formats, RESULT_FILES, "formats")
    parsed = settings or Settings(**options)
    if out is None:
        return find(arm, trajectory, parsed, progress=progress)
    if out == "":
        raise UsageError("the name of the folder is empty", where="out", next_step="name a folder, or none")
    folder, warned = path_of(out), Warned()
    with warned.collecting():
        arm = arm_with_masses(arm)
        motion = trajectory_of(trajectory, arm, partial(read_trajectory, progress=progress))
    mark = source_of(arm, motion, parsed)["run"]
    strangers = require_one_run(folder, RESULT_FILES, formats, mark, overwrite=overwrite)
    findings = find(arm, motion, parsed, warned=warned.texts, progress=progress)
    del motion  # the findings hold what is shown of a long one, whose memory the reports can use
    write_findings(findings, folder, formats, strangers, progress=progress)
    return findings


@one_thread()
def find(
    arm: RobotArm | str | Path,
    trajectory: GivenMotions,
    settings: Settings | None = None,
    *,
    command: str = "",
    warned: Iterable[str] = (),
    progress: Progress = NO_PROGRESS,
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
        Told the stages of the work, see `Progress`.

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
    warned_so_far = Warned(list(dict.fromkeys(warned)))
    settings = settings or Settings()

    with warned_so_far.collecting():
        inputs = read_step(arm, trajectory, settings, command, progress)
        warn_of_inputs(inputs)
        dynamics = decompose_step(inputs, progress)
    with warned_so_far.collecting():
        ranking = rank_step(inputs, dynamics, dynamics.asked)
        warn_of_too_many_terms(dynamics)
    progress.ranked(ranking, str(dynamics.asked))
    with warned_so_far.collecting():
        models = simplify_step(inputs, dynamics, progress)
    with warned_so_far.collecting():
        findings = collect_step(inputs, dynamics, models)
    return replace(findings, warnings=tuple(warned_so_far.texts))
