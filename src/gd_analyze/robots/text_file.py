"""Text files of an arm: TOML with the line of every key, and XML elements with their lines."""

from __future__ import annotations

import math
import os
import re
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Any
from xml.parsers import expat

import numpy as np

from gd_analyze.errors import ArmError, Location
from gd_analyze.files import megabytes, read_at_most
from gd_analyze.text import number_in
from gd_analyze.units import UNITS

# Factors of the unit suffixes of keys, such as a_mm.
UNIT_SUFFIXES = {"_deg": UNITS["angle"]["deg"], "_mm": UNITS["length"]["mm"]}
# The largest description among 90 public robots has 0.5 MB.
LARGEST_XML = 10_000_000
# Faults of XML that a file has which was copied in part, and that of an end without its beginning.
_ENDS_EARLY, _OTHER_END = (
    {
        expat.errors.codes[error]
        for error in (expat.errors.XML_ERROR_NO_ELEMENTS, expat.errors.XML_ERROR_UNCLOSED_TOKEN)
    },
    expat.errors.codes[expat.errors.XML_ERROR_TAG_MISMATCH],
)
# The texts that are read are numbers.
_LONGEST_TEXT = 100
# A chain of 40 bodies is nested 40 deep in MJCF.
_DEEPEST_NESTING = 200


def read_text(path: Path, kind: str, most: int) -> str:
    """Text of a file; ArmError if it cannot be read, is larger, or is not UTF-8."""
    try:
        data = read_at_most(path, most)
        if data is not None:
            return data.decode("utf-8")
        problem, detail = f"the {kind} is too large", f"more than {megabytes(most)}"
    except OSError as error:
        problem, detail = f"cannot read the {kind}", error.strerror or str(error)
    except UnicodeDecodeError as error:
        problem = f"the {kind} is not text"
        detail = f"byte 0x{error.object[error.start]:02x} at {error.start}"
    expected, hint = "a text file in UTF-8", "give the path of one that you may read"
    raise ArmError(problem, where=Location(path), expected=expected, found=detail, next_step=hint)


def parsed_toml(path: Path, text: str, kind: str) -> dict[str, Any]:
    """Document of a text; ArmError with line and column if it is not TOML."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"line (\d+), column (\d+)", str(error))
        line, column = (int(place[1]), int(place[2])) if place else (text.count("\n") + 1, None)
        where, detail = Location(path, line, column), re.sub(r" \(at .*\)$", "", str(error))
        problem, next_step = f"the {kind} is not valid TOML", "fix the syntax there"
        if path.suffix.lower() != ".toml":  # it may be something else altogether
            next_step = "fix it there; if it is no TOML, `gd-analyze arms puma560 --to toml` is an example"
    except ValueError:  # Python refuses integers of thousands of digits
        lines = enumerate(text.splitlines(), start=1)
        line = next((number for number, row in lines if re.search(r"\d[\d_]{4000}", row)), 1)
        where, detail = Location(path, line), "thousands of digits"
        problem, next_step = f"the {kind} contains a number that is too long", "shorten it"
    except RecursionError:
        where, detail, next_step = Location(path), "hundreds of levels", "write it flat"
        problem = f"the {kind} nests tables or lists too deep"
    raise ArmError(problem, where=where, found=detail, next_step=next_step)


class TableLines:
    """Line numbers of tables and keys, which `tomllib` does not keep."""

    def __init__(self, path: Path, content: str) -> None:
        self.path = path
        self._lines: dict[tuple[str | int, ...], int] = {}
        counts: dict[str, int] = {}
        table: tuple[str | int, ...] = ()
        for number, line in enumerate(content.splitlines(), start=1):
            if header := re.match(r"\s*\[\[\s*([\w.-]+)\s*\]\]", line):
                index = counts[header[1]] = counts.get(header[1], -1) + 1
                table = (header[1], index)
                self._lines[table] = number
                self._lines.setdefault(table[:1], number)
            elif key := re.match(r"\s*([\w-]+)\s*=", line):
                self._lines[(*table, key[1])] = number

    def locate(self, keys: tuple[str | int, ...]) -> Location:
        """Line of the innermost known key of a path such as ("links", 2, "mass")."""
        for end in range(len(keys), 0, -1):
            for suffix in ("", *UNIT_SUFFIXES):
                candidate = (*keys[: end - 1], f"{keys[end - 1]}{suffix}") if suffix else keys[:end]
                if candidate in self._lines:
                    return Location(self.path, self._lines[candidate])
        return Location(self.path)


@dataclass
class Node:
    """An element: tag, attributes, place, children and text."""

    tag: str
    attributes: dict[str, str]
    where: Location
    children: list[Node] = field(default_factory=list)
    content: str = ""
    places: dict[str, Location] = field(default_factory=dict)  # of attributes that stand elsewhere

    def all(self, *tags: str) -> list[Node]:
        """Children with any of these tags."""
        return [child for child in self.children if child.tag in tags]

    def first(self, tag: str) -> Node | None:
        """First child with a tag."""
        return next((child for child in self.children if child.tag == tag), None)

    def walk(self) -> Iterator[Node]:
        """Yield the element and all within, in the order of the file."""
        yield self
        for child in self.children:
            yield from child.walk()

    def words(self, key: str, default: str = "") -> list[str]:
        """Words of an attribute."""
        return self.attributes.get(key, default).split()

    def numbers(
        self, key: str, count: int, default: str | None = None, least: float = -math.inf
    ) -> list[float]:
        """Numbers of an attribute; ArmError unless there are `count`, all finite, none below `least`."""
        values = [number_in(word) for word in self.words(key, default or "")]
        valid = [value for value in values if value is not None and least <= value and abs(value) < math.inf]
        if len(valid) == len(values) == count:
            return valid
        expected = "a finite number" if count == 1 else f"{count} finite numbers"
        problem = f"{key} of <{self.tag}> is not {expected}" + ("" if least < 0 else ", 0 or more")
        stated = repr(self.attributes[key]) if key in self.attributes else "nothing"
        where = self.places.get(key, self.where)
        raise ArmError(problem, where=where, found=stated, next_step="fix the attribute there")

    def is_not_zero(self, key: str) -> bool:
        """Whether an attribute is stated and is not 0."""
        return any(self.numbers(key, len(self.words(key)))) if self.words(key) else False

    def kept(self, keys: tuple[str, ...], added: Mapping[str, Any] | None = None, *within: Node) -> Node:
        """Copy the element with some of its attributes, added attributes, and the given children."""
        stated = {key: value for key, value in self.attributes.items() if key in keys}
        for key, value in (added or {}).items():
            stated[key] = value if isinstance(value, str) else " ".join(map(repr, np.ravel(value).tolist()))
        return Node(self.tag, stated, self.where, list(within))

    def text(self) -> str:
        """The element and all within as XML."""
        inside = "".join(child.text() for child in self.children)
        attributes = "".join(f' {key}="{escape(value)}"' for key, value in self.attributes.items())
        return f"<{self.tag}{attributes}>{inside}</{self.tag}>\n"


def read_xml(path: Path) -> Node:
    """Outermost element of a file; ArmError unless it is plain XML without entities and not too large."""
    try:
        content = read_at_most(path, LARGEST_XML)
    except OSError as error:
        raise ArmError("cannot read the robot's file", where=Location(path), found=error.strerror) from None
    if content is None:
        expected = f"up to {megabytes(LARGEST_XML)}; meshes are separate files, which are not read"
        raise ArmError("the robot's file is too large", where=Location(path), expected=expected)
    open_nodes: list[Node] = []
    roots: list[Node] = []
    parser = expat.ParserCreate()

    def here() -> Location:
        return Location(path, parser.CurrentLineNumber, parser.CurrentColumnNumber + 1)

    def start(tag: str, attributes: dict[str, str]) -> None:
        if len(open_nodes) >= _DEEPEST_NESTING:
            message = "the robot's file nests elements too deep"
            raise ArmError(message, where=here(), expected=f"at most {_DEEPEST_NESTING} levels")
        node = Node(tag, attributes, here())
        (open_nodes[-1].children if open_nodes else roots).append(node)
        open_nodes.append(node)

    def read_text(text: str) -> None:
        if len(open_nodes[-1].content) < _LONGEST_TEXT:
            open_nodes[-1].content += text

    def refuse(*_: Any) -> None:
        message = "the robot's file declares a document type, which may hide text"
        expected = "plain XML without <!DOCTYPE> and entities"
        raise ArmError(message, where=here(), expected=expected, next_step="remove the declaration")

    parser.StartElementHandler, parser.EndElementHandler = start, lambda _: open_nodes.pop()
    parser.CharacterDataHandler = read_text
    parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = refuse
    try:
        parser.Parse(content, True)
    except expat.ExpatError as error:
        where, fault = Location(path, error.lineno, error.offset + 1), expat.ErrorString(error.code)
        message, hint, within = "the robot's file is not valid XML", "fix the syntax there", ""
        if open_nodes:
            within = f"<{open_nodes[-1].tag}> of line {open_nodes[-1].where.line}"
        if error.code in _ENDS_EARLY:
            fault = f"its end within {within}" if within else "its end before any element"
            message, hint = "the robot's file is cut off", "copy or export it again, whole"
        elif error.code == _OTHER_END:
            fault = f"the end of another element within {within}"
        raise ArmError(message, where=where, found=fault, next_step=hint) from None
    except (LookupError, ValueError) as error:  # an encoding that Python does not know
        raise ArmError("the robot's file is not text", where=Location(path), found=str(error)) from None
    return roots[0]


def parsed_model(build: Callable[[], Any], path: Path, lines: Mapping[tuple[str, str], Location]) -> Any:
    """Model built by Pinocchio; its parser's messages are kept off the terminal.

    If the parser fails, the ArmError holds them, with the line of the ("joint" or "link", name) they name.
    """
    with tempfile.TemporaryFile() as messages:
        if sys.stderr is not None:
            sys.stderr.flush()
        stderr = os.dup(2)
        os.dup2(messages.fileno(), 2)
        try:
            return build()
        except Exception as error:
            failure = str(error)
        finally:
            os.dup2(stderr, 2)
            os.close(stderr)
        messages.seek(0)
        text = messages.read(10_000).decode(errors="replace") or failure
    sentences = [line.strip().removeprefix("Error:").strip() for line in text.splitlines() if line.strip()]
    sentences = [line for line in sentences if not line.startswith("at line ")]
    named = re.findall(r"(link|joint) [\['\"](.*?)[\]'\"]", text, re.IGNORECASE)
    where = next((lines[noun.lower(), name] for noun, name in named if (noun.lower(), name) in lines), None)
    message, expected = "Pinocchio cannot read the URDF", "a URDF of one robot"
    detail, where = sentences[:3] or "no reason given", where or Location(path)
    raise ArmError(message, where=where, expected=expected, found=detail, next_step="fix the file there")
