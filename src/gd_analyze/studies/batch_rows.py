"""Rows of a batch: arm, motion and options, from a table, a file of combinations, or folders of logs."""

from __future__ import annotations

import csv
import difflib
import hashlib
import io
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import islice, product
from pathlib import Path
from typing import Any, get_type_hints

from gd_analyze.errors import Location, UsageError, require_type
from gd_analyze.files import read_at_most
from gd_analyze.motions.formats import files_in, shipped_trajectories
from gd_analyze.robots.arm_numbers import EXAMPLES, ArmNumber
from gd_analyze.robots.catalogue import builtin_arms
from gd_analyze.robots.limits import parsed_yaml
from gd_analyze.robots.text_file import parsed_toml, read_text
from gd_analyze.studies.settings import Settings
from gd_analyze.units import Quantity

# Other options of a row: how the arm is chosen from its file, and what it carries.
PICKED = ("tip", "base", "lock", "limits", "gravity", "drive_inertia")
SETTING_NAMES = tuple(entry.name for entry in fields(Settings))
KEYS = ("arm", "trajectory", "payload", *PICKED, *SETTING_NAMES)
_FLAG = "true or false"
_EXPECTED = {"dominance": "a share such as 10% or 0.1"}
_FLAGS = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}
_COMBINED = (".yaml", ".yml", ".toml")
_ROBOTS = frozenset({".urdf", ".toml", ".xml", ".mjcf"})
# Most bytes of a table.
_MOST_TABLE_BYTES = 100_000_000
# Most rows: some hundred MB.
MOST_ROWS = 1_000_000
# Most bytes of an input that travels with its task.
MOST_TRAVELLING_BYTES = 1_000_000

BatchRow = Mapping[str, Any]


def rows_in(path: Path) -> list[BatchRow]:
    """Rows of a CSV table, of a YAML or TOML file, or of a folder of folders, one per robot with its logs.

    In YAML and TOML every combination of the lists' entries is a row; with a list `rows` of tables, each
    table is combined with every combination. Paths are relative to the table's folder.

    Raises
    ------
    UsageError
        If there are no rows, a key is neither one of `KEYS` nor a number of an arm, or a row lacks arm or
        trajectory.
    ArmError
        If the file cannot be read.
    """
    if path.is_dir():
        rows = list(_of_folders(path))
    else:
        text, kind = read_text(path, "table of a batch", _MOST_TABLE_BYTES), path.suffix.lower()
        if kind in _COMBINED:
            read = parsed_toml if kind == ".toml" else parsed_yaml
            rows = list(_combined(read(path, text, "table of a batch"), path))
        else:
            text = text.removeprefix("\ufeff")
            between = max(",;\t", key=text.partition("\n")[0].count)
            lines = csv.DictReader(io.StringIO(text), delimiter=between, restkey="(beyond the header)")
            _require_distinct(lines.fieldnames or (), path)
            named = ({str(k).strip(): v for k, v in row.items() if v not in (None, "")} for row in lines)
            rows = list(islice(named, MOST_ROWS + 1))
            _require_few(len(rows), path)
    return checked_rows(rows, str(path))


def _require_distinct(names: Sequence[str], path: Path) -> None:
    """Refuse a table of two columns of one name."""
    stripped = [name.strip() for name in names]
    for name in filter(None, stripped):
        if stripped.count(name) > 1:
            message, step = f"there are {stripped.count(name)} columns {name}", "keep one of them"
            raise UsageError(message, where=f"{path}, header", next_step=step)


def checked_rows(rows: Sequence[BatchRow], where: str) -> list[BatchRow]:
    """Refuse rows with an unknown option or without arm or trajectory, and an empty table."""
    for number, row in enumerate(rows, start=1):
        place = f"{where}, row {number}"
        require_type(row, Mapping, place, "a mapping of options")
        for key in row:
            if key not in KEYS and ArmNumber.named(str(key)) is None:
                near = difflib.get_close_matches(str(key), KEYS, n=1)
                step, message = f"did you mean {near[0]!r}?" if near else None, f"there is no option {key!r}"
                expected = f"{', '.join(KEYS)}; or a number of the arm: {EXAMPLES}"
                raise UsageError(message, where=place, expected=expected, next_step=step)
        for key in ("arm", "trajectory"):
            if key not in row:
                raise UsageError(f"the row has no {key}", where=place, expected="arm and trajectory")
        for key in ("limits", "drive_inertia"):
            if str(row.get(key, "")).endswith((".toml", ".yaml", ".yml")):
                raise UsageError(f"{key} of a row cannot be a file", where=place, next_step="give the values")
    if not rows:
        raise UsageError("there are no rows", where=where, expected="at least one, with arm and trajectory")
    return list(rows)


def _of_folders(folder: Path) -> Iterator[BatchRow]:
    """A row per log: each in the folder of its robot, with the robot's file or by a built-in name."""
    for robot in sorted(path for path in folder.iterdir() if path.is_dir()):
        robot_files = sorted(path for path in robot.iterdir() if path.suffix.lower() in _ROBOTS)
        if len(robot_files) > 1 or (not robot_files and robot.name not in builtin_arms()):
            names = ", ".join(path.name for path in robot_files) or "none"
            message = "a robot's folder needs one robot file, or the name of a built-in arm"
            raise UsageError(message, where=Location(robot), found=names)
        arm = str(robot_files[0].relative_to(folder)) if robot_files else robot.name
        yield from ({"arm": arm, "trajectory": str(log.relative_to(folder))} for log in files_in(robot) or ())


def _combined(document: Any, path: Path) -> Iterator[BatchRow]:
    rows = document.get("rows", [{}]) if isinstance(document, dict) else None
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        expected = "keys with a value or a list of values each, and `rows`, a list of such tables"
        raise UsageError("this is not a table of a batch", where=Location(path), expected=expected)
    lists = {key: x if isinstance(x, list) else [x] for key, x in document.items() if key != "rows"}
    free_lists = [{key: values for key, values in lists.items() if key not in row} for row in rows]
    _require_few(sum(math.prod(map(len, free.values())) for free in free_lists), path)
    for row, free in zip(rows, free_lists, strict=True):
        yield from ({**dict(zip(free, chosen, strict=True)), **row} for chosen in product(*free.values()))


def _require_few(count: int, path: Path) -> None:
    """Refuse more rows than memory holds."""
    if count > MOST_ROWS:
        count_text = f"{count}" if path.suffix.lower() in _COMBINED else "more"
        message, step = "the table has too many rows", "divide it into several tables"
        expected = f"1 to {MOST_ROWS}"
        raise UsageError(message, where=Location(path), expected=expected, found=count_text, next_step=step)


def picked_of(row: BatchRow) -> dict[str, Any]:
    """Options by which the row chooses the arm from its file, as arguments of `load_arm`."""
    options: dict[str, Any] = {key: str(row[key]) for key in PICKED if key in row}
    several = {key: options[key].split(",") for key in ("lock", "limits") if "=" in options.get(key, "")}
    return options | several


def varied_in(row: BatchRow) -> dict[str, Any]:
    """Numbers of the arm that the row replaces, by name."""
    return {key: value for key, value in row.items() if key not in KEYS}


def settings_of(row: BatchRow) -> dict[str, Any]:
    """Values of the row's `Settings`; a UsageError names one that cannot be read."""
    kinds, settings = get_type_hints(Settings), {}
    for key, value in row.items():
        if key not in SETTING_NAMES:
            continue
        text = str(value).strip()
        parsed: Any = text
        if bool in (kinds[key], *getattr(kinds[key], "__args__", ())):
            parsed = _FLAGS.get(text.lower())
        elif key == "dominance":
            parsed = Quantity.si_of(text, "share")
        if parsed is None:
            raise UsageError(
                "the option cannot be read", where=key, expected=_EXPECTED.get(key, _FLAG), found=text
            )
        settings[key] = parsed
    return settings


@dataclass(frozen=True)
class RowInput:
    """A shipped name, a small file with its bytes, or a large file or folder by path and digest."""

    name: str
    content: bytes | None = None
    path: str = ""
    digest: str = ""

    @classmethod
    def of(cls, word: str, shipped: Mapping[str, Path], base_folder: Path) -> RowInput:
        """Take the input that a word of the table names; the word alone where there is no such file."""
        path = (base_folder / word).resolve()
        if word in shipped or not path.exists():
            return cls(word if word in shipped else str(path), digest=word)
        small = path.is_file() and path.stat().st_size <= MOST_TRAVELLING_BYTES
        content = read_at_most(path, MOST_TRAVELLING_BYTES) if small else None
        return cls(path.name, content, str(path), digest_of(path))

    def at(self, folder: Path) -> str:
        """Name or path for a reader; bytes are unpacked into the folder. UsageError if a file has changed."""
        if self.content is not None:
            (folder / self.name).write_bytes(self.content)
            return str(folder / self.name)
        digest = digest_of(Path(self.path)) if self.path else self.digest
        if digest != self.digest:
            message, step = "the file differs on this worker", "let all workers see the same files"
            raise UsageError(
                message, where=self.path, expected=self.digest[:16], found=digest[:16], next_step=step
            )
        return self.path or self.name


# Bytes that are read at a time for a digest.
_BYTES_AT_ONCE = 2**20


def digest_of(path: Path) -> str:
    """SHA-256 of a file, or of names and contents of all files in a folder; "" where there is none."""
    digest = hashlib.sha256()
    for member in sorted(path.rglob("*")) if path.is_dir() else [path]:
        if member.is_file():
            digest.update(str(member.relative_to(path)).encode())
            with member.open("rb") as file:
                while piece := file.read(_BYTES_AT_ONCE):
                    digest.update(piece)
    return digest.hexdigest() if path.exists() else ""


def row_inputs(row: BatchRow, base_folder: Path) -> tuple[RowInput, RowInput]:
    """Arm and trajectory of a row."""
    arm, trajectory = str(row["arm"]), str(row["trajectory"])
    return (
        RowInput.of(arm, builtin_arms(), base_folder),
        RowInput.of(trajectory, shipped_trajectories(), base_folder),
    )
