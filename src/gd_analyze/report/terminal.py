"""A document as terminal text: one renderer for every verb."""

from __future__ import annotations

import re
import textwrap
import unicodedata
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from gd_analyze.text import short_name, visible

if TYPE_CHECKING:
    from gd_analyze.report.document import Document

WIDTH = 80
# Length of a shortened name.
_LEAST_NAME = 12
_NARROWEST_HEADING = 9
_Json = Mapping[str, Any]
# Heading lines and cells of a column.
_Block = tuple[list[str], list[str]]
_UNIT = re.compile(r"(?<=\d) (?:%|[nµmkM]?N m\b|[nµmkM]?N\b|s\b|rad\b|m\b|kg\b|×)")


def text_of(document: Document, width: int = WIDTH, bold: Callable[[str], str] = str) -> str:
    """Write a document as lines of `width` columns; tables whose numbers need more are wider.

    `bold` marks up headings.
    """
    content = document.content
    lines = [bold(line) for line in wrapped(f"{content['title']} {content['subtitle']}".strip(), width)]
    lines += wrapped(content["headline"], width)
    facts, parts = content["facts"], content["parts"]
    # Facts that begin the parts continue the first ones.
    if parts and parts[0]["kind"] == "facts":
        facts, parts = [*facts, *parts[0]["facts"]], parts[1:]
    lines += [*_facts(facts, width), *_parts(parts, width, bold)]
    for notice in content["notices"]:
        lines += ["", *wrapped(notice, width)]
    if notes := content["notes"]:
        lines += [f"{len(notes)} {'notes' if len(notes) > 1 else 'note'} in the report."]
    return "\n".join(lines) + "\n"


def wrapped(text: str, width: int, indent: str = "") -> list[str]:
    """Wrap a text between words, each number together with its unit; `indent` begins further lines."""
    unbroken = _UNIT.sub(lambda match: match[0].replace(" ", "\u00a0"), visible(text))
    lines = textwrap.wrap(
        unbroken, width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )
    return [line.replace("\u00a0", " ") for line in lines]


def _parts(parts: Sequence[_Json], width: int, bold: Callable[[str], str]) -> Iterator[str]:
    """Lines of parts, a blank one before each."""
    for part in parts:
        kind = part["kind"]
        if kind == "facts":
            yield from _facts(part["facts"], width)
            continue
        title, lines, note = part["title"], [], _lines(part["note"], width)
        if kind == "table":
            lines = _table(part, width)
            if unit := _unit_of_all(part):
                title = f"{title}, {unit}"
            if part["rows"] < part["of"]:
                title += f" ({part['rows']} of {part['of']})"
            lines = [*lines, *note] if lines else []
        elif kind == "equations" and part["lines"]:
            lines = _formulas([*part["lines"], *part["legend"]["lines"]], width)
            if part["most_lines"] is not None and len(lines) > part["most_lines"]:
                lines = [
                    f"The equations take {len(lines)} lines: --json and the main job's report have them."
                ]
            lines = [*note, *lines]
        elif kind == "section":
            lines = [*note, *_parts(part["parts"], width, bold)]
            if not title and not note:
                yield from lines
                continue
        if lines:
            yield from ("", *map(bold, wrapped(title, width)), *lines)


def _lines(paragraphs: Sequence[str], width: int) -> list[str]:
    return [line for paragraph in paragraphs for line in wrapped(paragraph, width)]


def _facts(facts: Sequence[_Json], width: int) -> Iterator[str]:
    if facts:
        yield ""
    room = min(max((_length(fact["label"]) for fact in facts), default=0), 3 * width // 5)
    for fact in facts:
        *above, label = wrapped(fact["label"], room)
        yield from above
        start = label + " " * (room - _length(label)) + "  "
        first, *further = wrapped(fact["text"], max(width - _length(start), 16)) or [""]
        yield (start + first).rstrip()
        yield from (" " * (room + 2) + line for line in further)


def _table(table: _Json, width: int) -> list[str]:
    """Headings, which wrap, a rule, and the rows; nothing for a table of columns for pages only."""
    columns = _columns(table)
    if not columns:
        return []
    blocks: list[_Block] = []
    is_in_title = bool(_unit_of_all(table))
    for column in columns:
        cells = list(map(visible, column["cells"]))
        words = visible(column["label"]).split(" ")
        room = max(_NARROWEST_HEADING, *map(_length, cells), *map(_length, words))
        unit = [column["unit"]] if column["unit"] and not is_in_title else []
        blocks.append(([*wrapped(column["label"], room), *unit], cells))
    sides = [column["is_text"] for column in columns]
    excess = sum(_width(*block) + 2 for block in blocks) - 2 - width
    for k, column in enumerate(columns):
        if column["shown"] == "name" and excess > 0:
            heading, cells = blocks[k]
            room = max(_LEAST_NAME, _width(heading, cells) - excess)
            excess -= max(_width(heading, cells) - room, 0)
            blocks[k] = heading, [short_name(cell, room) for cell in cells]
    if excess > 0:
        blocks = _wrapped_cells(blocks, sides, excess)
    deepest = max(len(heading) for heading, _ in blocks)
    whole = [[""] * (deepest - len(heading)) + heading + cells for heading, cells in blocks]
    padded = [
        [_padded(cell, max(map(_length, cells)), is_left) for cell in cells]
        for cells, is_left in zip(whole, sides, strict=True)
    ]
    lines = ["  ".join(row).rstrip() for row in zip(*padded, strict=True)]
    rule = "  ".join("─" * _length(cells[0]) for cells in padded)
    return [*lines[:deepest], rule, *lines[deepest:]]


def _columns(table: _Json) -> list[_Json]:
    """Columns for which a terminal has room."""
    return [column for column in table["columns"] if not column["pages_only"]]


def _unit_of_all(table: _Json) -> str:
    """The unit of all numbers of a table, which its title states; "" if they differ, or there is no title."""
    units = {column["unit"] for column in _columns(table) if column["is_number"]}
    return units.pop() if len(units) == 1 and table["title"] else ""


def _wrapped_cells(blocks: list[_Block], are_text: Sequence[bool], excess: int) -> list[_Block]:
    """Wrap text columns, the widest first, each down to a least width, until the excess is gone."""
    widths = [
        is_text * max(map(_length, cells)) for is_text, (_, cells) in zip(are_text, blocks, strict=True)
    ]
    pieces = [[[cell] for cell in cells] for _, cells in blocks]
    for k in sorted(range(len(blocks)), key=lambda k: -widths[k]):
        heading, cells = blocks[k]
        room = max(_LEAST_NAME, _width(heading, []), widths[k] - excess)
        if excess > 0 and room < widths[k]:
            pieces[k] = [_broken(cell, room) for cell in cells]
            excess -= widths[k] - room
    deep = [max(map(len, row)) for row in zip(*pieces, strict=True)]
    return [
        (
            heading,
            [
                line
                for cell, most in zip(column, deep, strict=True)
                for line in cell + [""] * (most - len(cell))
            ],
        )
        for (heading, _), column in zip(blocks, pieces, strict=True)
    ]


def _broken(cell: str, room: int) -> list[str]:
    """Wrap a cell between words, and a longer word behind its signs such as / and _."""
    lines = []
    for line in wrapped(cell, room) or [""]:
        while len(line) > room:
            ends = (line.rfind(sign, 1, room) + 1 for sign in "/._-")
            end = next((end for end in ends if end), room)
            lines.append(line[:end])
            line = line[end:]
        lines.append(line)
    return lines


def _formulas(formulas: Sequence[str], width: int) -> list[str]:
    """Formulas line by line; short ones that follow each other share a line, in two or four columns."""
    lines, room = [""], 0
    for formula in formulas:
        cell = next((width // count for count in (4, 2) if len(formula) + 2 <= width // count), width)
        if cell < width and cell <= room:
            lines[-1] = f"{lines[-1]:<{width - room}}{formula}"
            room -= cell
        else:
            lines += [formula] if cell < width else _formula(formula, width)
            room = width - cell
    return lines[1:]


def _formula(line: str, width: int) -> list[str]:
    """Wrap a formula between its summands, with a hanging indent behind the sign of equality."""
    left, equals, right = line.partition(" = ")
    if not equals:
        return [line]
    indent = len(left) + 3
    lines = [f"{left} ="]
    for summand in re.split(r" (?=[+-] )(?![^(]*\))", right):
        if len(lines[-1]) + 1 + len(summand) <= width:
            lines[-1] += f" {summand}"
            continue
        # A sum in brackets that takes more than a line is wrapped, too, a little further in.
        is_long = indent + len(summand) > width
        first, *inner = re.split(r" (?=[+-] )", summand) if is_long else [summand]
        if lines[-1].endswith("="):
            lines[-1] += f" {first}"
        else:
            lines.append(" " * indent + first)
        for piece in inner:
            if len(lines[-1]) + 1 + len(piece) <= width:
                lines[-1] += f" {piece}"
            else:
                lines.append(" " * (indent + 4) + piece)
    return lines


def _width(heading: Sequence[str], cells: Sequence[str]) -> int:
    return max(map(_length, (*heading, *cells)))


def _padded(cell: str, room: int, is_left: bool) -> str:
    gap = " " * (room - _length(cell))
    return cell + gap if is_left else gap + cell


def _length(text: str) -> int:
    """Terminal columns of a text: East Asian characters take two, accents none."""
    if text.isascii():
        return len(text)
    return sum(
        0 if unicodedata.combining(sign) else 2 if unicodedata.east_asian_width(sign) in "WF" else 1
        for sign in text
    )
