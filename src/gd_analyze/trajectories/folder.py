"""Which files of a folder are trajectories."""

from __future__ import annotations

from pathlib import Path

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.run import RESULT_FILES
from gd_analyze.visible import visible

# Files that a folder of motions may hold motions in; whatever has another suffix is passed over.
SUFFIXES = frozenset(
    {".csv", ".tsv", ".txt", ".dat", ".log", ".bag", ".mcap", ".db3", ".parquet", ".yaml", ".yml"}
)
# What a folder holds that is a recording by itself: rosbag2 keeps its messages beside this file.
_OF_A_BAG = "metadata.yaml"


def is_folder_of_motions(path: Path) -> bool:
    """Whether a path is a folder, and not one that is a single recording."""
    return path.is_dir() and not (path / _OF_A_BAG).is_file()


def trajectory_files(folder: Path) -> list[Path]:
    """List the trajectories of a folder, by name.

    Files with a suffix of `SUFFIXES` count, and folders that are a recording; hidden ones do not, nor what
    the main job writes, nor what lies in other folders.

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
            expected=f"files that end in {', '.join(sorted(SUFFIXES))}",
            found=", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
            if names
            else "nothing",
            next_step="name the files themselves, or another folder",
        )
    return found


def _may_be_one(path: Path) -> bool:
    if path.is_dir():
        return not is_folder_of_motions(path)
    return path.suffix.lower() in SUFFIXES and path.name not in RESULT_FILES.values()
