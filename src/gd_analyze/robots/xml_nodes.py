"""An XML file as plain elements that know their line: checked before any other program sees the text."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

from gd_analyze.errors import ArmError, Location
from gd_analyze.files import megabytes, read_at_most

# The largest description among 90 public robots has 0.5 MB.
LARGEST_XML = 10_000_000
# A chain of 40 bodies nests 40 deep in MJCF.
_DEEPEST = 200


@dataclass
class Node:
    """An element: its tag, attributes, children and where it begins."""

    tag: str
    attributes: dict[str, str]
    where: Location
    children: list[Node] = field(default_factory=list)

    def all(self, tag: str) -> list[Node]:
        """Children of a tag."""
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> Node | None:
        """First child of a tag."""
        return next((child for child in self.children if child.tag == tag), None)

    def walk(self) -> Iterator[Node]:
        """Yield this element and all within, in the order of the file."""
        waiting = [self]
        while waiting:
            node = waiting.pop()
            yield node
            waiting.extend(reversed(node.children))

    def numbers(self, key: str, count: int, default: str | None = None) -> list[float]:
        """Read the numbers of an attribute; ArmError where they are not so many, or none."""
        text = self.attributes.get(key, default)
        words = [] if text is None else text.split()
        try:
            values = [float(word) for word in words]
        except ValueError:
            values = []
        if len(values) != count or not all(abs(value) < float("inf") for value in values):
            raise ArmError(
                f"{key} of <{self.tag}> is not " + ("a number" if count == 1 else f"{count} numbers"),
                where=self.where,
                expected="a finite number" if count == 1 else f"{count} finite numbers with spaces between",
                found="nothing" if text is None else repr(text),
                next_step="mend the attribute there",
            )
        return values

    def is_not_zero(self, key: str) -> bool:
        """Whether an attribute is stated and holds a number other than 0."""
        count = len(self.attributes.get(key, "").split())
        return count > 0 and any(self.numbers(key, count))

    def text(self) -> str:
        """Write the element and all within as XML."""
        inside = "".join(child.text() for child in self.children)
        told = "".join(f" {key}={quoteattr(value)}" for key, value in self.attributes.items())
        return f"<{self.tag}{told}>{inside}</{self.tag}>\n"


def text_of_xml(path: Path) -> bytes:
    """Read an XML file of a robot.

    Raises
    ------
    ArmError
        If it cannot be read or is larger than any robot's.
    """
    try:
        content = read_at_most(path, LARGEST_XML)
    except OSError as error:
        raise ArmError("cannot read the robot's file", where=Location(path), found=error.strerror) from None
    if content is None:
        raise ArmError(
            "the robot's file is too large",
            where=Location(path),
            expected=f"up to {megabytes(LARGEST_XML)}; meshes are files of their own, and never read",
            found="more",
            next_step="check that it is a robot's description",
        )
    return content


def read_nodes(path: Path, content: bytes) -> Node:
    """Parse XML without entities and document types.

    Raises
    ------
    ArmError
        If the text is not XML, declares a document type or entities, or nests deeper than any robot.
    """
    open_nodes: list[Node] = []
    roots: list[Node] = []
    parser = expat.ParserCreate()

    def here() -> Location:
        return Location(path, parser.CurrentLineNumber, parser.CurrentColumnNumber + 1)

    def start(tag: str, attributes: dict[str, str]) -> None:
        node = Node(tag, attributes, here())
        if len(open_nodes) >= _DEEPEST:
            raise ArmError(
                "the robot's file nests elements beyond any robot",
                where=node.where,
                expected=f"at most {_DEEPEST} levels",
                next_step="check that it is a robot's description",
            )
        (open_nodes[-1].children if open_nodes else roots).append(node)
        open_nodes.append(node)

    def end(_: str) -> None:
        open_nodes.pop()

    def refuse(*_: Any) -> None:
        raise ArmError(
            "the robot's file declares a document type, which may hide text",
            where=here(),
            expected="plain XML without <!DOCTYPE> and entities",
            next_step="remove the declaration",
        )

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = refuse
    try:
        parser.Parse(content, True)
    except expat.ExpatError as error:
        raise ArmError(
            "the robot's file is not valid XML",
            where=Location(path, error.lineno, error.offset + 1),
            found=expat.ErrorString(error.code),
            next_step="mend the syntax there",
        ) from None
    except (LookupError, ValueError) as error:  # an encoding that Python does not know
        raise ArmError("the robot's file is not text", where=Location(path), found=str(error)) from None
    return roots[0]
