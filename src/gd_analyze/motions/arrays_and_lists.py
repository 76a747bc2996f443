"""Logs of arrays and lists: NumPy's and MATLAB's files, JSON, and lists in the cells of a text table.

None of these readers executes what a file contains: pickled objects are refused.
"""

from __future__ import annotations

import json
import math
import re
import zipfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.files import megabytes, read_at_most
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.table import ArrayTable, changed_names, gathered, nanoseconds_in, refusing_damage
from gd_analyze.motions.text import TextTable
from gd_analyze.text import counted, in_python, json_fault, number_in

# Of arrays and of files of arrays, in bytes.
_LARGEST_ARRAYS_BYTES = 1_000_000_000
# Python's objects take ten times as much memory as their text.
_LARGEST_JSON_BYTES = 200_000_000
# Joins the names of nested tables.
_BELOW = "/"
_IS_LIST = re.compile(r"\s*[\[(].*[\])]\s*", re.DOTALL)
_BETWEEN = re.compile(r"[\s,;]+")

Record = Mapping[str, Any]


def read_numpy(path: Path) -> ArrayTable:
    """Read the arrays of an .npz, or the fields of an .npy."""
    with_pickles = "arrays of numbers, saved with numpy.savez('log.npz', time=time, q=q)"
    with _refusing_damage(path, "NumPy's file", with_pickles):
        if path.suffix.lower() == ".npz":
            with zipfile.ZipFile(path) as file:
                _require_size(path, sum(member.file_size for member in file.infolist()))
            with np.load(path, allow_pickle=False) as archive:
                return _table_of_arrays(path, {name: archive[name] for name in archive.files})
        array = np.load(path, allow_pickle=False)
        if array.dtype.names:
            return _table_of_arrays(path, {name: array[name] for name in array.dtype.names})
    command = f"import numpy; numpy.savetxt('log.csv', numpy.load({str(path)!r}), delimiter=',')"
    step = f'python -c "{command}" writes it as CSV, for `map=["q=#2..#7"]` and so on'
    content = f"an array of shape {array.shape} without names"
    raise refusal("the columns have no names", Location(path), "named arrays, an .npz", content, step)


def read_matlab(path: Path) -> ArrayTable:
    """Read the arrays and structures of a .mat file of any version."""
    import h5py
    import scipy.io

    with _refusing_damage(path, "MATLAB's file", "arrays or structures, saved with save('log.mat', ...)"):
        _require_size(path, path.stat().st_size)
        if not h5py.is_hdf5(path):
            return _table_of_arrays(path, scipy.io.loadmat(path, simplify_cells=True))
        arrays: dict[str, Any] = {}  # version 7.3

        def take(name: str, node: object) -> None:
            if isinstance(node, h5py.Dataset) and node.dtype.kind in "iuf" and not name.startswith("#"):
                _require_size(path, node.nbytes)
                arrays[name] = node[()]

        with h5py.File(path) as file:
            file.visititems(take)
        return _table_of_arrays(path, arrays)


def _refusing_damage(path: Path, kind: str, expected: str) -> AbstractContextManager[None]:
    step = "save it again, without objects, or as CSV"
    return refusing_damage(path, f"the log cannot be read as {kind}", expected, step)


def _require_size(path: Path, size: int) -> None:
    if size > _LARGEST_ARRAYS_BYTES:
        raise _too_large(path, _LARGEST_ARRAYS_BYTES, megabytes(size))


def _too_large(path: Path, most: int, size: str) -> TrajectoryError:
    message, step = "the log is too large to be read at once", "save it as Parquet or CSV"
    return refusal(message, Location(path), f"up to {megabytes(most)}", size, step)


def _table_of_arrays(path: str | Path, tree: Mapping[str, Any]) -> ArrayTable:
    """A table of the arrays that have a value, or several, per row; others describe the log.

    As many rows as most arrays have values along one of their sides; columns of a matrix are numbered from 1.
    """
    arrays = {name: np.asarray(value).squeeze() for name, value in _flattened(tree)}
    numeric = {
        name: array
        for name, array in arrays.items()
        if array.dtype.kind in "iuf" and array.ndim in (1, 2) and array.size
    }
    sides = Counter(side for array in numeric.values() for side in {*array.shape})
    if not sides:
        content = ", ".join(f"{name} {array.shape}" for name, array in [*arrays.items()][:12]) or "nothing"
        expected = "arrays with a value per instant, such as time (N) and q (N, n)"
        raise refusal("the file contains no arrays of a motion", Location(path), expected, content)
    rows = max(sides, key=lambda side: (sides[side], side))
    columns: dict[str, NDArray[Any]] = {}
    for name, array in numeric.items():
        if array.shape == (rows,):
            columns[name] = array
        elif rows in array.shape:
            matrix = array.T if array.shape[0] == rows else array
            columns |= {f"{name}_{k}": column for k, column in enumerate(matrix, start=1)}
    about = tuple(
        f"{name.rpartition(_BELOW)[2]} = {array}" for name, array in arrays.items() if not array.ndim
    )
    return ArrayTable(path, tuple(columns), tuple(map(_stored, columns.values())), about=about)


def _stored(values: NDArray[Any]) -> NDArray[Any]:
    """Integers that 64 bits hold, else floats."""
    is_whole = values.dtype.kind == "i" or (values.dtype.kind == "u" and values.dtype.itemsize < 8)
    return values.astype(np.int64 if is_whole else float)


def _flattened(tree: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Values of nested tables, with the names on the way to them."""
    for name, value in tree.items():
        if isinstance(value, Mapping):
            yield from _flattened(value, f"{before}{name}{_BELOW}")
        else:
            yield f"{before}{name}", value


def begins_json(begin: bytes) -> bool:
    """Whether a text begins as JSON does; lists of numbers are left to other readers."""
    return re.match(rb"(\xef\xbb\xbf)?\s*(\{|\[\s*\{)", begin) is not None


def read_json(path: Path, data: bytes | None) -> ArrayTable:
    """Read JSON: an object per line, a list of objects, or one object of arrays."""
    content = read_at_most(path, _LARGEST_JSON_BYTES) if data is None else data
    if content is None or len(content) > _LARGEST_JSON_BYTES:
        raise _too_large(path, _LARGEST_JSON_BYTES, "more")
    text = content.decode("utf-8-sig", errors="replace")
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
    if len(lines) > 1 and isinstance(_parsed(path, *lines[0]), Mapping):
        return _table_of_rows(path, ((number, _parsed(path, number, line)) for number, line in lines))
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        place = Location(path, getattr(error, "lineno", None), getattr(error, "colno", None))
        raise _not_json(place, json_fault(error)) from None
    if isinstance(document, Mapping):
        with _refusing_damage(path, "JSON", "lists of numbers, of equal length"):
            return _table_of_arrays(path, document)
    rows = document if isinstance(document, list) else [document]
    return _table_of_rows(path, ((number, _record(path, number, row)) for number, row in enumerate(rows, 1)))


def _parsed(path: Path, number: int, line: str) -> Record | TrajectoryError:
    try:
        return _record(path, number, json.loads(line))
    except (ValueError, RecursionError) as error:
        return _not_json(Location(path, number), json_fault(error))


def _record(path: Path, number: int, row: object) -> Record | TrajectoryError:
    if isinstance(row, Mapping):
        return dict(_flattened(row))
    return _not_json(Location(path, number), in_python(row))


def _not_json(where: Location, content: str) -> TrajectoryError:
    expected, step = 'an object per line: {"time": 0.0, "q": [0.1, 0.2]}', "correct or remove the line"
    return refusal("the line is not a JSON object", where, expected, content, step)


def has_lists(table: TextTable) -> bool:
    """Whether cells of the first row are lists."""
    return any(_IS_LIST.fullmatch(cell) for cell in table.first_cells)


def read_list_cells(table: TextTable) -> ArrayTable:
    """Read a text table with lists in its cells, as pandas writes them."""

    def value_in(cell: str) -> object:
        if _IS_LIST.fullmatch(cell):
            entries = _BETWEEN.split(cell.strip().strip("[]()").strip(" ,"))
            words = [entry.strip("'\"") for entry in entries]
            numbers = [number_in(word) for word in words]
            return words if None in numbers else numbers
        if re.fullmatch(r"[-+]?[0-9]{1,18}", cell):
            return int(cell)
        return table.value(cell)

    def values_in(cells: list[str] | TrajectoryError) -> Record | TrajectoryError:
        if isinstance(cells, TrajectoryError):
            return cells
        return dict(zip(table.names, map(value_in, cells), strict=True))

    return _table_of_rows(Path(table.path), ((number, values_in(cells)) for number, cells in table.rows()))


def _table_of_rows(path: Path, rows: Iterable[tuple[int, Record | TrajectoryError]]) -> ArrayTable:
    """A table of rows with their lines: a column per number, and one per element of a list.

    A list of names that is the same in every row names the elements of lists of its length.
    """
    lines: list[int] = []
    wrong: dict[int, TrajectoryError] = {}
    labels: dict[str, list[str]] = {}  # lists of names
    elements: dict[str, list[str]] = {}  # columns of each number or list

    def numbers_of(line: int, row: Record) -> Iterator[tuple[str, float]]:
        for name, value in row.items():
            is_label = isinstance(value, list) and value and all(isinstance(entry, str) for entry in value)
            if is_label and labels.setdefault(name, value) != value:
                joints = f"{', '.join(value)} in {name}"
                raise changed_names(Location(path, line), ", ".join(labels[name]), joints)
        for name, value in row.items():
            date = nanoseconds_in(value) if isinstance(value, str) else None
            numbers = _numbers(value) if date is None else [date]
            if numbers is None:
                continue
            name = name if date is None else f"{name} [ns]"
            if name not in elements:
                numbered = [f"{name}_{k + 1}" for k in range(len(numbers))]
                named = ([f"{of}{_BELOW}{name}" for of in words] for words in labels.values())
                fitting = (columns for columns in named if len(columns) == len(numbers))
                elements[name] = next(fitting, numbered) if isinstance(value, list) else [name]
            if len(numbers) != len(elements[name]):
                expected = f"{counted(len(elements[name]), 'number')}, as in the first row"
                message, where = f"{name} has another length", Location(path, line)
                wrong[len(lines)] = refusal(message, where, expected, str(len(numbers)))
                continue
            yield from zip(elements[name], numbers, strict=True)

    def records() -> Iterator[dict[str, float]]:
        for line, row in rows:
            if isinstance(row, TrajectoryError):
                wrong[len(lines)] = row
            yield {} if isinstance(row, TrajectoryError) else dict(numbers_of(line, row))
            lines.append(line)

    columns = gathered(records())
    if not columns:
        if wrong:
            raise wrong[min(wrong)]
        raise refusal("the log has no numbers", Location(path), "numbers or lists of numbers", "none")
    arrays = tuple(map(_stored, columns.values()))
    return ArrayTable(path, tuple(columns), arrays, lines=tuple(lines), wrong=wrong)


def _numbers(value: object) -> list[float] | None:
    """Numbers of a list, or a number as a list of one; nan for null, None for anything else."""
    numbers: list[float] = []
    for entry in value if isinstance(value, list) else [value]:
        if isinstance(entry, bool) or not isinstance(entry, int | float | None):
            return None
        is_beyond = isinstance(entry, int) and abs(entry) >= 2**63
        numbers.append(math.nan if entry is None else math.inf if is_beyond else entry)
    return numbers or None
