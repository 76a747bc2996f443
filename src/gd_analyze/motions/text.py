"""A log in a text file: comma, semicolon, tab or blanks; read in blocks, and only the columns needed."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.layout import EMPTY, Layout, layout_of, require_number, split_cells, wrong_width
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.roles import is_of_set_points
from gd_analyze.motions.table import HEAD_ROWS, Columns, LogTable, Progress, Stamps, no_progress
from gd_analyze.motions.writing import GAP
from gd_analyze.text import LARGEST, number_in

_BLOCK = 8_000_000  # bytes read at once
_HEAD_BYTES = 1_000_000
# Doubles hold smaller instants to a few nanoseconds; of larger ones the whole part is taken off first.
_EXACT_ENOUGH = 1e6
_NEEDS_LOOK = re.compile(rb"(?m)^[ \t]*(?:#|$)")
_NOT_GIVEN = sorted({word for empty in EMPTY for word in (empty, empty.upper(), empty.capitalize(), "NaN")})


@dataclass(frozen=True, eq=False)
class _Block:
    """Some rows: their bytes without comments, their lines in the file, and gaps before them."""

    data: bytes
    numbers: Sequence[int]
    gaps: Sequence[int] = ()

    @property
    def lines(self) -> list[str]:
        return self.data.decode("utf-8", errors="replace").removesuffix("\n").split("\n")


class TextTable(LogTable):
    """A text file, or the bytes of one; `names` are those of a file that has none."""

    def __init__(self, path: str | Path, data: bytes | None = None, names: tuple[str, ...] = ()) -> None:
        self.path, self.data = path, data
        with self._opened() as file:
            head = file.read(_HEAD_BYTES)
        self._refuse_binary(head)
        try:
            text = head.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = head.decode("latin-1")
        lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        self.first_lines = lines if len(head) < _HEAD_BYTES else lines[:-1] or lines
        self.layout: Layout = layout_of(self.first_lines, path)
        self.names = names or self.layout.names
        self.set_points = not names and any(self.names) and all(map(is_of_set_points, self.names))
        self._head: list[list[str]] = []
        for number, line in enumerate(self.first_lines[self.layout.first - 1 :], self.layout.first):
            if line.strip() and not line.lstrip().startswith("#") and len(self._head) < HEAD_ROWS:
                cells = split_cells(line, self.layout.delimiter, Location(path, number))
                self._head.append([cell.strip() for cell in cells])

    @property
    def first_cells(self) -> list[str]:
        """Cells of the first row."""
        return self._head[0]

    def require_constant(self, first: Mapping[int, str], *, or_empty: bool = False) -> None:
        """Raise a TrajectoryError where a column of text is not in every row as in the first, or empty."""
        columns = sorted(first)
        for block in self._blocks(no_progress):
            if not block.numbers:
                continue
            frame = self._parsed(block, columns, frozenset(columns))
            for column in columns:
                for row, cell in enumerate(frame[column].to_numpy(dtype=object)):
                    # An empty cell is read as nan.
                    if cell.strip() != first[column] if isinstance(cell, str) else not or_empty:
                        raise refusal(
                            "the joints' names change",
                            Location(self.path, block.numbers[row], column + 1),
                            "the same names in every row",
                            [str(cell), f"{first[column]} before"],
                            "keep the rows of one arm in a file of their own",
                        )

    def head(self, column: int) -> list[str | float]:
        """First cells of a column."""
        read: list[str | float] = []
        for row in self._head:
            cell = row[column] if column < len(row) else ""
            number = number_in(self.layout.plain(cell))
            read.append(float("nan") if cell.lower() in EMPTY else cell if number is None else number)
        return read

    def stands(self, column: int) -> bool:
        """Whether the first cells are all the same."""
        cells = {row[column] for row in self._head if column < len(row)}
        return len(self._head) > 1 and len(cells) == 1 and "" not in cells

    def where(self, row: int | None = None, column: int | None = None) -> Location:
        """Place in the file; to find a row's line takes as long as to read the file."""
        line = self.layout.header or None if row is None else self._line(row)[0]
        return Location(self.path, line, None if column is None else column + 1)

    def cell(self, row: int, column: int) -> str:
        """A cell as it is written."""
        number, line = self._line(row)
        return split_cells(line, self.layout.delimiter, Location(self.path, number))[column].strip()

    def _line(self, row: int) -> tuple[int, str]:
        for block in self._blocks(no_progress):
            if row < len(block.numbers):
                return block.numbers[row], block.lines[row]
            row -= len(block.numbers)
        raise IndexError(row)

    def read(
        self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress = no_progress
    ) -> Columns:
        """Read columns in one pass through the file."""
        parts: list[Any] = [np.empty((0, len(numbers)))]
        texts: list[list[Any]] = [[np.empty(0, dtype=object)] for _ in stamps]
        gaps: list[int] = []
        rows = 0
        for block in self._blocks(progress):
            gaps += [rows + gap for gap in block.gaps]
            rows += len(block.numbers)
            if block.numbers:
                frame = self._parsed(block, sorted({*numbers, *stamps}), frozenset(stamps))
                values = frame[list(numbers)].to_numpy(dtype=float) if numbers else np.empty((len(frame), 0))
                if np.isinf(values).any() or (np.abs(values) > LARGEST).any():
                    self._locate(block, numbers, frozenset())
                parts.append(values)
                for text, column in zip(texts, stamps, strict=True):
                    text.append(frame[column].to_numpy(dtype=object))
        table = np.concatenate(parts)
        parts.clear()
        pairs = zip(texts, stamps, strict=True)
        instants = tuple(self._stamps(np.concatenate(text), column) for text, column in pairs)
        return Columns(table, instants, tuple(gap for gap in dict.fromkeys(gaps) if 0 < gap < rows))

    def _parsed(self, block: _Block, columns: list[int], as_text: frozenset[int]) -> Any:
        """Columns of a block as a frame; a fault in it is refused with its line and column."""
        frame = self._frame(block, columns, as_text)
        if (
            frame is None
            or len(frame) != len(block.numbers)
            or not self._widths_fit(block, frame[self.layout.width - 1])
        ):
            self._locate(block, columns, as_text)
            where, expected = Location(self.path, block.numbers[0]), f"{self.layout.width} cells in each line"
            raise refusal("the file cannot be read as a table", where, expected, "lines that do not fit")
        return frame

    def _frame(self, block: _Block, columns: Sequence[int], as_text: frozenset[int]) -> Any:
        """Columns of a block, and the last one, as pandas reads them; None where it cannot."""
        import pandas as pd

        layout = self.layout
        last = layout.width - 1
        asked = sorted({*columns, last})
        text = as_text | ({last} - set(columns))
        # Since 3.1 pandas reads every digit, and warns of being told to.
        release = tuple(int(part) for part in pd.__version__.split(".")[:2])
        exact: dict[str, Any] = {} if release >= (3, 1) else {"float_precision": "round_trip"}
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", pd.errors.ParserWarning)
                return pd.read_csv(
                    io.BytesIO(block.data),
                    header=None,
                    names=range(layout.width),
                    index_col=False,
                    usecols=asked,
                    sep=r"\s+" if layout.delimiter == " " else layout.delimiter,
                    decimal=layout.decimal,
                    dtype={column: object if column in text else float for column in asked},
                    skipinitialspace=True,
                    keep_default_na=False,
                    na_values=_NOT_GIVEN,
                    skip_blank_lines=False,
                    encoding_errors="replace",
                    low_memory=False,
                    **exact,
                )
        except (ValueError, OverflowError, pd.errors.ParserWarning):
            return None

    def _widths_fit(self, block: _Block, last: Any) -> bool:
        """Whether every line has as many cells as there are names; delimiters tell, quotes aside."""
        sign, width = self.layout.delimiter, self.layout.width
        if sign == " ":
            return all(len(line.split()) == width for line in block.data.splitlines())
        if b'"' in block.data:
            return all(len(split_cells(line, sign, Location(self.path))) == width for line in block.lines)
        if block.data.count(sign.encode()) != (width - 1) * len(block.numbers):
            return False
        lines = block.data.split(b"\n") if last.isna().any() else []
        return all(line.count(sign.encode()) == width - 1 for line in lines if line)

    def _locate(self, block: _Block, columns: Sequence[int], as_text: frozenset[int]) -> None:
        """Raise for the first wrong cell of a block; slow, but knows where it is."""
        layout = self.layout
        for number, line in zip(block.numbers, block.lines, strict=True):
            cells = split_cells(line, layout.delimiter, Location(self.path, number))
            if len(cells) != layout.width:
                raise wrong_width(len(cells), layout, self.path, number)
            for column in set(columns) - as_text:  # stamps may be of any size, and text is not read here
                cell = cells[column].strip()
                if cell.lower() not in EMPTY:
                    require_number(
                        layout.plain(cell), self.label(column), Location(self.path, number, column + 1)
                    )

    def _stamps(self, cells: Any, column: int) -> Stamps:
        """Instants from their digits, so that nothing is lost of an epoch in nanoseconds."""
        texts = [self.layout.plain(cell.strip()) if isinstance(cell, str) else "nan" for cell in cells]
        values = np.empty(len(texts))
        for row, text in enumerate(texts):
            number = float("nan") if text == "nan" else number_in(text)
            if number is None or abs(number) == float("inf"):
                require_number(text, self.label(column), self.where(row, column))
            values[row] = number
        known = values[np.isfinite(values)]
        if not known.size or np.abs(known).max() < _EXACT_ENOUGH or np.abs(known).max() > 2.0**62:
            return Stamps(0, values)
        try:
            base = int(known[0])
            rest = [np.nan if text == "nan" else float(Decimal(text) - base) for text in texts]
        except InvalidOperation:
            return Stamps.of(values)
        return Stamps(base, np.array(rest))

    def _blocks(self, progress: Progress) -> Iterator[_Block]:
        """The rows, some megabytes at a time, cut between lines."""
        size = len(self.data) if self.data is not None else Path(self.path).stat().st_size
        number, done, rest = 1, 0, b""
        with self._opened() as file:
            while True:
                piece = file.read(_BLOCK)
                done += len(piece)
                progress(done, max(size, done))
                data = rest + piece
                cut = data.rfind(b"\n") + 1 if piece else len(data)
                rest = data[cut:]
                lines = data[:cut].replace(b"\r\n", b"\n").replace(b"\r", b"\n")
                if lines:
                    self._refuse_binary(lines)
                    block, number = _block_of(lines, number, self.layout.first)
                    yield block
                if not piece:
                    return

    def _opened(self) -> BinaryIO:
        try:
            return io.BytesIO(self.data) if self.data is not None else Path(self.path).open("rb")
        except OSError as error:
            raise TrajectoryError(
                "cannot read the file",
                where=Location(self.path),
                found=error.strerror or str(error),
                next_step="give the path of a file you may read",
            ) from None

    def _refuse_binary(self, data: bytes) -> None:
        if b"\0" in data:
            raise refusal(
                "the file is not a text table",
                Location(self.path),
                "text in UTF-8, or a file that ends in .db3, .mcap, .bag, .parquet or .yaml",
                "UTF-16" if data.startswith((b"\xff\xfe", b"\xfe\xff")) else "a binary file (zero bytes)",
                "save it as CSV in UTF-8",
            )


def _block_of(data: bytes, number: int, begin: int) -> tuple[_Block, int]:
    """The rows among some lines, the first of which is line `number`; rows begin on line `begin`."""
    if not data.endswith(b"\n"):
        data += b"\n"
    following = number + data.count(b"\n")
    if number >= begin and not _NEEDS_LOOK.search(data[:-1]):
        return _Block(data, range(number, following)), following
    kept: list[bytes] = []
    numbers: list[int] = []
    gaps: list[int] = []
    for k, line in enumerate(data[:-1].split(b"\n"), number):
        if k >= begin and line.strip() and not line.lstrip().startswith(b"#"):
            kept.append(line + b"\n")
            numbers.append(k)
        elif k >= begin and line.rstrip() == GAP.encode():
            gaps.append(len(numbers))
    return _Block(b"".join(kept), numbers, gaps), following
