"""Which files of a folder are trajectories."""

from __future__ import annotations

from pathlib import Path

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.files import RESULT_FILES
from gd_analyze.motions.open_log import format_by_name
from gd_analyze.text import visible

# Text that may be a motion; whatever is neither that nor a log by its name is passed over.
_TEXT = frozenset({".csv", ".tsv", ".txt", ".dat", ".log"})


def is_folder_of_motions(path: Path) -> bool:
    """Whether a path is a folder, and not one that is a single recording."""
    return path.is_dir() and format_by_name(path) is None


def trajectory_files(folder: Path) -> list[Path]:
    """List the trajectories of a folder, by name.

    Files that end in .csv, .tsv, .txt, .dat or .log count, and logs that are told by their names, folders of
    bags among them; hidden ones do not, nor what the main job writes, nor what lies in other folders.

    Raises
    ------
    TrajectoryError
        If there are none, or the folder cannot be read.
    """
    try:
        entries = sorted(folder.iterdir(), key=lambda path: path.name)
    except OSError as error:
        raise TrajectoryError(
            "cannot read the folder of trajectories",
            where=Location(folder),
            found=error.strerror or str(error),
            next_step="give the path of a folder you may read",
        ) from None
    shown = [path for path in entries if not path.name.startswith(".")]
    found = [path for path in shown if _may_be_one(path)]
    if not found:
        names = [visible(path.name) for path in shown]
        raise TrajectoryError(
            "the folder holds no trajectories",
            where=Location(folder),
            expected=f"files that end in {', '.join(sorted(_TEXT))}; bags, .parquet or .yaml",
            found=", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
            if names
            else "nothing",
            next_step="name the files themselves, or another folder",
        )
    return found


def _may_be_one(path: Path) -> bool:
    if path.name in RESULT_FILES.values():
        return False
    return format_by_name(path) is not None or (path.is_file() and path.suffix.lower() in _TEXT)
