"""From a path to a table: which reader takes it, with names from its header, its messages or the user."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from os import PathLike
from pathlib import Path

import numpy as np

from gd_analyze.errors import Location, TrajectoryError, argument
from gd_analyze.files import RESULT_FILES, megabytes, read_at_most, shipped
from gd_analyze.motions.arrays_and_lists import (
    begins_json,
    has_lists,
    read_json,
    read_list_cells,
    read_matlab,
    read_numpy,
)
from gd_analyze.motions.reading import Reading, refusal
from gd_analyze.motions.ros import echoed_names, read_bag
from gd_analyze.motions.stated_rate import stated_rate
from gd_analyze.motions.table import LogTable, ParquetTable
from gd_analyze.motions.text import TextTable, is_number, refuse_long_names
from gd_analyze.motions.units_by_numbers import rate_of_factors
from gd_analyze.motions.velocities import derivative_factors
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.text import in_python, visible

_LFS = b"version https://git-lfs"
_BAGS, _JSON = (".db3", ".mcap", ".bag"), (".jsonl", ".ndjson")
_READERS: dict[str, Callable[[Path], LogTable]] = {
    **dict.fromkeys((".parquet", ".pq"), ParquetTable),
    **dict.fromkeys((".npz", ".npy"), read_numpy),
    ".mat": read_matlab,
}
# Suffixes of text files in a folder that may be motions.
_TEXT = frozenset({".csv", ".tsv", ".txt", ".dat", ".log"})
# Limit for a pipe; a million set points of seven joints with all digits take 0.45 GB.
_LARGEST_STREAM_BYTES = 1_000_000_000
# Positions, and what may be their derivatives.
_DERIVATIVES = ("q", "qd", "qdd")


def shipped_trajectories() -> dict[str, Path]:
    """Shipped trajectory files by name, in alphabetical order."""
    return shipped("trajectories", ".csv")


def files_in(folder: Path) -> list[Path] | None:
    """Trajectories of a folder, by name, except hidden files and results; None if it is not a folder."""
    if not folder.is_dir() or _is_bag(folder):
        return None
    try:
        entries = sorted(folder.iterdir(), key=lambda path: path.name)
    except OSError as error:
        raise _unreadable(folder, error) from None
    suffixes = {*_TEXT, *_BAGS, *_JSON, *_READERS}
    visible_paths = [path for path in entries if not path.name.startswith(".")]
    logs = [p for p in visible_paths if _is_bag(p) or (p.is_file() and p.suffix.lower() in suffixes)]
    trajectories = [path for path in logs if path.name not in RESULT_FILES.values()]
    if not trajectories:
        names = ", ".join(visible(path.name) for path in visible_paths[:5]) or "nothing"
        names += f" and {len(visible_paths) - 5} more" if len(visible_paths) > 5 else ""
        expected = f"files that end in {', '.join(sorted(_TEXT))}; bags or .parquet"
        step = "name the files themselves, or another folder"
        raise refusal("the folder holds no trajectories", Location(folder), expected, names, step)
    return trajectories


def _is_bag(folder: Path) -> bool:
    return (folder / "metadata.yaml").is_file()


def log_source(path_or_name: str | Path) -> tuple[Path, str, str, bytes | None]:
    """Path, name and origin of a motion, and its bytes if it can be read only once."""
    if not isinstance(path_or_name, str | PathLike):
        expected = "the name of a shipped one, or the path of a file"
        raise refusal("this is not a trajectory", "trajectory", expected, in_python(path_or_name))
    shipped_files, path = shipped_trajectories(), Path(path_or_name)
    if str(path_or_name) == "-":
        return Path("standard input"), "stdin", "read from standard input", _stream(None)
    if str(path_or_name) in shipped_files:
        return shipped_files[str(path_or_name)], path.name, f"shipped trajectory {path_or_name}", None
    origin = f"read from {path_or_name}"
    with suppress(OSError, ValueError):
        if path.is_file() or _is_bag(path):
            return path, path.stem, origin, None
    return path, path.stem, origin, _stream(path)


def _stream(path: Path | None) -> bytes:
    """All bytes of a pipe, or of standard input."""
    name = path or Path("standard input")
    try:
        data = read_at_most(path or sys.stdin.buffer, _LARGEST_STREAM_BYTES)
    except (FileNotFoundError, ValueError):
        shipped_files = shipped_trajectories()
        near = difflib.get_close_matches(name.stem, shipped_files, n=1)
        message, reason = f"there is no trajectory {str(name)!r}", "neither an existing file nor a known name"
        expected = f"a CSV file, a log or a shipped trajectory ({', '.join(shipped_files)})"
        step = f"did you mean {near[0]!r}?" if near else "check the path, or see `gd-analyze plan`"
        raise refusal(message, Location(name), expected, reason, step) from None
    except OSError as error:
        raise _unreadable(name, error) from None
    if data is None:
        most, step = megabytes(_LARGEST_STREAM_BYTES), "write fewer set points, or split the motion"
        raise refusal("the trajectory is too large to be read", Location(name), f"up to {most}", "more", step)
    return data


def _unreadable(path: Path, error: OSError) -> TrajectoryError:
    reason, step = error.strerror or str(error), "give a path you may read"
    expected = "a file" if isinstance(error, IsADirectoryError) else "a file, or a folder of files"
    return refusal("cannot read the trajectory", Location(path), expected, reason, step)


def _begin(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return file.read(len(_LFS))
    except OSError as error:
        raise _unreadable(path, error) from None


def log_table(path: Path, reading: Reading, data: bytes | None, progress: Progress, joints: int) -> LogTable:
    """The table of a file, with names from its header, its messages, or the user."""
    suffix = path.suffix.lower() if data is None else ""
    begin = data if data is not None else b"" if path.is_dir() else _begin(path)
    if begin.startswith(_LFS):
        content, step = "a pointer of Git LFS", "`git lfs pull` in its repository fetches the file itself"
        raise refusal("this is not a log", Location(path), "the log itself", content, step)
    if path.suffix.lower() in (".yaml", ".yml") or begin.startswith(b"header:"):
        expected, content = "a bag, or what `ros2 topic echo --csv` prints", "messages in YAML"
        step = "record a bag with `ros2 bag record /joint_states`, or echo the topic as CSV"
        raise refusal("the log cannot be read", Location(path), expected, content, step)
    if path.is_dir() or suffix in _BAGS:
        return read_bag(path, reading.topic, progress)
    if suffix in _READERS:
        return _READERS[suffix](path)
    if suffix in _JSON or begins_json(begin):
        return read_json(path, data)
    table = TextTable(path, data)
    where = Location(path, table.layout.first)
    if (table.names or table.first_cells)[0].lstrip().startswith("<"):
        expected, content = "a log: text in columns, a bag or Parquet", "XML, as robots' files are"
        raise refusal("this is not a log", where, expected, content, "name the robot first, then the log")
    cells = table.first_cells
    if not any(table.names) and (echoed := echoed_names(cells)) is not None:
        refuse_long_names(echoed, where)
        table.require_constant({k: c for k, c in enumerate(cells) if k > 2 and c and not is_number(c)})
        table.names = echoed
        return table
    if not any(table.names) and not reading.map:
        content, step = f"numbers in {len(cells)} columns", _naming(table, joints)
        raise refusal("the file has no header line", where, "the names of the columns", content, step)
    if not has_lists(table):
        return table
    if not any(table.names):
        table.names = tuple(f"#{k + 1}" for k in range(len(cells)))
    return read_list_cells(table)


def _naming(table: LogTable, joints: int) -> str:
    """What names the columns: time, positions, and derivatives where the numbers are derivatives."""
    width = len(table.names)
    # As many columns as joints, or a multiple, leave no column for time.
    has_time = width % joints > 0 or joints == 1
    begins = range(has_time, width - joints + 1, joints)
    numeric = [k for k in begins if all(_is_numeric(table, k + joint) for joint in range(joints))]
    roles = dict(zip(numeric, _derivatives(table, has_time, numeric, joints), strict=False))
    options = ["time=#1" if has_time else f"time={stated_rate(table)[0]}"]
    options += [f"{role}={_numbers(begin, joints)}" for begin, role in roles.items()]
    step = f"if these are the columns: {argument('map', options)}"
    others = [begin for begin in numeric if begin not in roles]
    if others:
        torques = f"torque={_numbers(others[0], joints)}"
        step += f", and {torques} where these are torques, or currents beside `torque_constant`"
    return step


def _numbers(begin: int, joints: int) -> str:
    return f"#{begin + 1}..#{begin + joints}" if joints > 1 else f"#{begin + 1}"


def _is_numeric(table: LogTable, column: int) -> bool:
    return all(isinstance(cell, float) for cell in table.head(column))


def _derivatives(table: LogTable, has_time: bool, begins: Sequence[int], joints: int) -> list[str]:
    """Roles of the first blocks of columns: each is the derivative of the one before."""
    begins = begins[: len(_DERIVATIVES)]
    columns = [*range(has_time), *(k + joint for k in begins for joint in range(joints))]
    if not begins or not all(_is_numeric(table, k) for k in columns[:has_time]):
        return ["q"]
    numbers = table.read(columns, (), NO_PROGRESS).numbers
    numbers = numbers[np.isfinite(numbers).all(axis=1)]
    blocks = np.split(numbers[:, has_time:], len(begins), axis=1)
    roles = ["q"]
    for role, previous, values in zip(_DERIVATIVES[1:], blocks, blocks[1:], strict=False):
        time = numbers[:, 0] if has_time else np.arange(float(len(numbers)))
        factors, contradicts = derivative_factors(time, previous, values)
        # Without instants the factor is the rate of the samples.
        if contradicts.any() and (has_time or not rate_of_factors(factors[np.isfinite(factors)])):
            break
        roles.append(role)
    return roles
