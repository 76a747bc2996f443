"""What a URDF must be before its numbers are read: expanded, of names that show, a tree of links."""

from __future__ import annotations

from gd_analyze.errors import ArmError
from gd_analyze.robots.xml_nodes import Node
from gd_analyze.text import visible


def name_of(node: Node) -> str:
    """Name of a link or joint; refused where there is none that shows."""
    name = node.attributes.get("name", "")
    if not name.strip() or visible(name) != name:
        raise ArmError(
            f"a {node.tag} has no name that shows",
            where=node.where,
            expected=f'<{node.tag} name="...">',
            found=visible(repr(name)),
            next_step="name it",
        )
    return name


def refuse_xacro(root: Node) -> None:
    """Refuse macros and open values."""
    for node in root.walk():
        macro = node.tag.startswith("xacro:")
        open_values = [v for v in node.attributes.values() if "${" in v or "$(arg" in v]
        if macro or (open_values and node.tag not in ("mesh", "texture")):
            raise ArmError(
                "the file is xacro that was not expanded",
                where=node.where,
                expected="URDF",
                found=f"<{node.tag}>" if macro else open_values[0],
                next_step="expand it first: `xacro robot.urdf.xacro > robot.urdf`",
            )


def require_tree(root: Node, links: list[Node], joints: list[Node]) -> None:
    """Refuse joints between unknown links, links with two parents, and any number of roots but one."""
    if not links:
        raise ArmError(
            "the robot has no links",
            where=root.where,
            expected="<link> and <joint> elements",
            next_step="check that it is URDF, with its macros expanded",
        )
    known = {name_of(link) for link in links}
    parents: dict[str, tuple[Node, str]] = {}
    for joint in joints:
        ends = [end_of(joint, end) for end in ("parent", "child")]
        for link in ends:
            if link not in known:
                raise ArmError(
                    f"joint {name_of(joint)} is at link {link!r}, which there is not",
                    where=joint.where,
                    expected="a <link> of that name",
                    next_step="add the link, or mend its name",
                )
        parent, child = ends
        if child in parents:
            raise ArmError(
                f"link {child} closes a loop: it is the child of two joints",
                where=joint.where,
                expected="one joint that leads to each link",
                found=f"joints {name_of(parents[child][0])} and {name_of(joint)}",
                next_step="remove one of the joints, or the branch that closes the loop",
            )
        parents[child] = (joint, parent)
    roots = [name_of(link) for link in links if name_of(link) not in parents]
    if len(roots) != 1:
        raise ArmError(
            "the links are not one tree",
            where=root.where,
            expected="one link that is no joint's child",
            found=", ".join(roots[:8]) or "none: the joints go round in a circle",
            next_step="connect the links by joints, or remove those that belong to nothing",
        )
    _refuse_circle(parents)


def _refuse_circle(parents: dict[str, tuple[Node, str]]) -> None:
    """Refuse links that hang on each other and on no root."""
    grounded: set[str] = set()
    for link in parents:
        way: dict[str, Node] = {}
        while link in parents and link not in grounded:
            if link in way:
                raise ArmError(
                    f"link {link} closes a loop: it carries itself",
                    where=way[link].where,
                    expected="a tree of links",
                    next_step="mend the parents of the joints",
                )
            way[link], link = parents[link]
        grounded.update(way)


def end_of(joint: Node, which: str) -> str:
    """Link that a joint is at: its parent or child."""
    node = joint.first(which)
    name = None if node is None else node.attributes.get("link")
    if name is None:
        raise ArmError(
            f"joint {name_of(joint)} has no {which} link",
            where=joint.where,
            expected=f'<{which} link="...">',
            next_step="add it",
        )
    return name
