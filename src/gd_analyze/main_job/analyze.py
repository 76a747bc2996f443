"""The main job in one call."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from gd_analyze.errors import UsageError
from gd_analyze.files import require_formats
from gd_analyze.main_job.find import find
from gd_analyze.main_job.folder import FILES, default_folder, require_folder, write_findings
from gd_analyze.main_job.how import Origin, Progress, Settings
from gd_analyze.results.findings import Findings
from gd_analyze.robots import RobotArm
from gd_analyze.trajectories import Trajectory


def analyze(
    arm: RobotArm,
    trajectory: Trajectory,
    out: str | Path | None = None,
    settings: Settings | None = None,
    *,
    formats: Collection[str] = tuple(FILES),
    origin: Origin | None = None,
    progress: Progress | None = None,
) -> Findings:
    """Do the main job: find everything and write it down.

    Parameters
    ----------
    arm, trajectory
        What to analyse.
    out
        Folder for the results; `reports/<arm>-<trajectory>` by default.
    settings, origin, progress
        As for `find`.
    formats
        Which files to write, of `gd_analyze.main_job.folder.FILES`.

    Returns
    -------
    Findings
        What was found; the files hold the same.

    Raises
    ------
    OutputError
        If the folder cannot be written to; nothing is computed or written then.
    StorageError
        If the machine fails while the files are written, e.g. a full disk; those of before stay.
    GdAnalyzeError
        As for `find`.
    """
    if out == "":
        raise UsageError("the name of the folder is empty", where="out", next_step="name a folder, or none")
    folder = default_folder(arm, trajectory) if out is None else Path(out)
    require_formats(formats, FILES)
    require_folder(folder, formats)
    findings = find(arm, trajectory, settings, origin=origin, progress=progress)
    if progress is not None:
        progress(f"writing {', '.join(formats)}")
    write_findings(findings, folder, formats)
    return findings
