"""The main job in one call."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

from gd_analyze.errors import UsageError
from gd_analyze.motions.pool import GivenMotions, trajectory_of
from gd_analyze.results.findings import Findings
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.studies.find import find, source_of
from gd_analyze.studies.folder import FILES, require_folder, write_findings
from gd_analyze.studies.settings_main import Settings, settings_of


def analyze(
    arm: RobotArm | str | Path,
    trajectory: GivenMotions,
    out: str | Path | None = None,
    settings: Settings | None = None,
    *,
    formats: Collection[str] = tuple(FILES),
    overwrite: bool = False,
    **options: Any,
) -> Findings:
    """Do the main job: find everything, and write it down where a folder is named.

    Parameters
    ----------
    arm, trajectory
        What to analyse, along one motion or several; or a shipped name, or the path of a file. A folder
        stands for all trajectories in it.
    out
        Folder for the results; nothing is written without one.
    settings, options
        How, see `Settings`: an object, or its fields one by one, such as ``budget="0.5%"``.
    formats
        Which files to write, of `gd_analyze.studies.folder.FILES`.
    overwrite
        Replace a run of another arm, motion or other options that the folder holds.

    Returns
    -------
    Findings
        What was found; the files hold the same.

    Raises
    ------
    UsageError
        If there is no such option or format, or settings and options are both given.
    OutputError
        If the folder cannot be written to, or holds another run; nothing is computed or written then.
    StorageError
        If the machine fails while the files are written, e.g. a full disk; those of before stay.
    GdAnalyzeError
        As for `find`.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> findings = gd.analyze("puma560", "pick-and-place", budget="5%")
    >>> findings.model.operations.total < findings.model.operations_full.total
    True
    """
    how = settings_of(settings, options)
    if out is None:
        return find(arm, trajectory, how)
    if out == "":
        raise UsageError("the name of the folder is empty", where="out", next_step="name a folder, or none")
    folder, arm = Path(out), arm_of(arm)
    motion = trajectory_of(trajectory, arm)
    strangers = require_folder(folder, formats, source_of(arm, motion, how)["run"], overwrite=overwrite)
    findings = find(arm, motion, how)
    write_findings(findings, folder, formats, strangers)
    return findings
