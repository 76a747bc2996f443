"""A log in a text file: comma, semicolon, tab or blanks; read in blocks, and only the columns needed."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from functools import cached_property
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.cells import number_of, split_cells, wrong_width
from gd_analyze.motions.table import Columns, Progress, Stamps, no_progress
from gd_analyze.motions.text_blocks import Block, block_of, frame_of
from gd_analyze.motions.text_layout import EMPTY, Layout, layout_of
from gd_analyze.text import LARGEST, number_in

_BLOCK = 8_000_000  # bytes read at once
_HEAD_BYTES = 1_000_000
_HEAD_ROWS = 200
# Doubles hold smaller instants to a few nanoseconds; of larger ones the whole part is taken off first.
_EXACT_ENOUGH = 1e6


@dataclass(frozen=True, eq=False)
class TextTable:
    """A text file, or the bytes of one.

    Parameters
    ----------
    path
        Of the file, or what to call the bytes.
    data
        The bytes, where they were not read from a file.
    given_names
        Names of the columns of a file that has none.
    """

    path: str | Path
    data: bytes | None = None
    given_names: tuple[str, ...] = ()
    planned: bool | None = field(default=None, init=False)

    @cached_property
    def _first_lines(self) -> list[str]:
        with self._opened() as file:
            head = file.read(_HEAD_BYTES)
            whole = len(head) < _HEAD_BYTES
        self._refuse_binary(head)
        try:
            text = head.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = head.decode("latin-1")
        lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        return lines if whole else lines[:-1] or lines

    @cached_property
    def layout(self) -> Layout:
        """How it is laid out."""
        return layout_of(self._first_lines, self.path)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return self.given_names or self.layout.names

    @cached_property
    def _head(self) -> list[list[str]]:
        rows = []
        for number in range(self.layout.first, len(self._first_lines) + 1):
            line = self._first_lines[number - 1]
            if line.strip() and not line.lstrip().startswith("#"):
                cells = split_cells(line, self.layout.delimiter, Location(self.path, number))
                rows.append([cell.strip() for cell in cells])
                if len(rows) == _HEAD_ROWS:
                    break
        return rows

    @property
    def first_cells(self) -> list[str]:
        """Cells of the first row."""
        return self._head[0]

    def require_constant(self, first: Mapping[int, str], *, or_empty: bool = False) -> None:
        """Raise a TrajectoryError where a column of text is not in every row as in the first, or empty."""
        columns = sorted(first)
        for block in self._blocks(no_progress):
            frame = self._parsed(block, columns, frozenset(columns))
            for column in columns:
                cells = frame[column].to_numpy(dtype=object)
                if all(cell == first[column] for cell in cells):
                    continue
                wrong = (k for k, cell in enumerate(cells) if _differs(cell, first[column], or_empty))
                row = next(wrong, None)
                if row is None:
                    continue
                raise TrajectoryError(
                    "the joints' names change",
                    where=Location(self.path, block.numbers[row], column + 1),
                    expected="the same names in every row",
                    found=[str(cells[row]), f"{first[column]} before"],
                    next_step="keep the rows of one arm in a file of their own",
                )

    def head(self, column: int) -> list[str | float]:
        """First cells of a column."""
        cells = [row[column] if column < len(row) else "" for row in self._head]
        read: list[str | float] = []
        for cell in cells:
            number = number_in(cell.replace(",", ".") if self.layout.decimal == "," else cell)
            read.append(float("nan") if cell.lower() in EMPTY else cell if number is None else number)
        return read

    def stands(self, column: int) -> bool:
        """Whether the first cells are all the same."""
        cells = {row[column] for row in self._head if column < len(row)}
        return len(self._head) > 1 and len(cells) == 1 and "" not in cells

    def where(self, row: int | None = None, column: int | None = None) -> Location:
        """Place in the file; to find a row's line takes as long as to read the file."""
        line = self.layout.header or None if row is None else None
        if row is not None:
            for block in self._blocks(no_progress):
                if row < len(block.numbers):
                    line = block.numbers[row]
                    break
                row -= len(block.numbers)
        return Location(self.path, line, None if column is None else column + 1)

    def read(
        self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress = no_progress
    ) -> Columns:
        """Read columns in one pass through the file."""
        parts, texts = [], []
        for block in self._blocks(progress):
            frame = self._parsed(block, sorted({*numbers, *stamps}), frozenset(stamps))
            values = frame[list(numbers)].to_numpy(dtype=float) if numbers else np.empty((len(frame), 0))
            if np.isinf(values).any() or (np.abs(values) > LARGEST).any():
                self._locate(block, numbers, frozenset())
            parts.append(values)
            texts.append([frame[column].to_numpy(dtype=object) for column in stamps])
        table = np.concatenate(parts) if parts else np.empty((0, len(numbers)))
        parts.clear()
        return Columns(
            table, tuple(self._stamps([part[k] for part in texts], column) for k, column in enumerate(stamps))
        )

    def _parsed(self, block: Block, columns: list[int], as_text: frozenset[int]) -> Any:
        """Columns of a block as a frame; any fault of it is told with its line and column."""
        frame = frame_of(block, columns, as_text, self.layout)
        if (
            frame is None
            or len(frame) != len(block.numbers)
            or not self._widths_fit(block, frame[self.layout.width - 1])
        ):
            self._locate(block, columns, as_text)
            raise TrajectoryError(
                "the log cannot be read as a table",
                where=Location(self.path, block.numbers[0]),
                expected=f"{self.layout.width} cells in each line",
                next_step="check the lines from there on",
            )
        return frame

    def _widths_fit(self, block: Block, last: Any) -> bool:
        """Whether every line has as many cells as there are names; delimiters tell, quotes aside."""
        sign = self.layout.delimiter
        if sign == " ":
            return all(len(line.split()) == self.layout.width for line in block.data.splitlines())
        if b'"' in block.data:
            return all(
                len(split_cells(line, sign, Location(self.path))) == self.layout.width for line in block.lines
            )
        between = self.layout.width - 1
        if block.data.count(sign.encode()) != between * len(block.numbers):
            return False
        lines = block.data.split(b"\n") if last.isna().any() else []
        return all(line.count(sign.encode()) == between for line in lines if line)

    def _locate(self, block: Block, columns: Sequence[int], as_text: frozenset[int]) -> None:
        """Raise for the first cell of a block that is wrong; slow, but knows where it is."""
        layout = self.layout
        for number, line in zip(block.numbers, block.lines, strict=True):
            cells = split_cells(line, layout.delimiter, Location(self.path, number))
            if len(cells) != layout.width:
                where = Location(self.path, number, min(len(cells), layout.width) + 1)
                raise wrong_width(
                    len(cells),
                    layout.width,
                    where,
                    "as in the header" if layout.header else "as in the first",
                )
            for column in columns:
                cell = cells[column].strip()
                if cell.lower() not in EMPTY:
                    plain = cell.replace(",", ".") if layout.decimal == "," else cell
                    name = self.names[column] or f"column {column + 1}"
                    if column not in as_text:  # of stamps any size is possible, and text is not read here
                        number_of(plain, name, Location(self.path, number, column + 1))

    def _stamps(self, blocks: Sequence[Any], column: int) -> Stamps:
        """Instants from their digits, so that nothing is lost of an epoch in nanoseconds."""
        cells = np.concatenate(blocks) if blocks else np.empty(0, dtype=object)
        texts = [cell.strip() if isinstance(cell, str) else "nan" for cell in cells]
        if self.layout.decimal == ",":
            texts = [text.replace(",", ".") for text in texts]
        values = np.empty(len(texts))
        for row, text in enumerate(texts):
            number = float("nan") if text == "nan" else number_in(text)
            if number is None or abs(number) == float("inf"):
                name = self.names[column] or f"column {column + 1}"
                number_of(text, name, self.where(row, column))
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

    def _blocks(self, progress: Progress) -> Iterator[Block]:
        """The rows, some megabytes at a time, cut between lines."""
        size = len(self.data) if self.data is not None else Path(self.path).stat().st_size
        number, begin = 1, self.layout.first
        with self._opened() as file:
            rest, done = b"", 0
            while True:
                piece = file.read(_BLOCK)
                done += len(piece)
                progress(done, max(size, done))
                data = rest + piece
                cut = data.rfind(b"\n") + 1 if piece else len(data)
                if piece and not cut:
                    rest = data
                    continue
                rest = data[cut:]
                lines = data[:cut].replace(b"\r\n", b"\n").replace(b"\r", b"\n")
                if lines:
                    self._refuse_binary(lines)
                    block, number = block_of(lines, number, begin)
                    if block.numbers:
                        yield block
                if not piece:
                    return

    def _opened(self) -> BinaryIO:
        try:
            return io.BytesIO(self.data) if self.data is not None else Path(self.path).open("rb")
        except OSError as error:
            raise TrajectoryError(
                "cannot read the log",
                where=Location(self.path),
                found=error.strerror or str(error),
                next_step="give the path of a file you may read",
            ) from None

    def _refuse_binary(self, data: bytes) -> None:
        if b"\0" in data:
            raise TrajectoryError(
                "the log is not a text table",
                where=Location(self.path),
                expected="text in UTF-8, or a file that ends in .db3, .mcap, .bag, .parquet or .yaml",
                found="UTF-16"
                if data.startswith((b"\xff\xfe", b"\xfe\xff"))
                else "a binary file (zero bytes)",
                next_step="save it as CSV in UTF-8",
            )


def _differs(cell: object, first: str, or_empty: bool) -> bool:
    """Whether a cell of text is another one; an empty cell is read as nan."""
    return cell.strip() != first if isinstance(cell, str) else not or_empty


def is_text(column: Sequence[str | float]) -> bool:
    """Whether first cells are text, none of them a number."""
    return any(isinstance(cell, str) for cell in column)
