"""What a link's own shapes contradict: a centre of mass outside, an inertia too wide, a mass too dense."""

from __future__ import annotations

import struct
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.errors import GdAnalyzeWarning
from robot_files import joint, link, urdf

BOX = '<box size="0.3 0.1 0.1"/>'
UPRIGHT = '<cylinder radius="0.05" length="0.4"/>'


def body(mass: float = 2.0, com: str = "0.15 0 0", moment: float = 0.01) -> str:
    moments = {"ixx": moment, "iyy": moment, "izz": moment, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
    return link("tool", mass, com, "0 0 0", **moments)


def drawn(inertial: str, *shapes: str, origin: str = 'xyz="0.15 0 0"') -> str:
    """The link with shapes to look at."""
    visuals = "".join(f"<visual><origin {origin}/><geometry>{shape}</geometry></visual>" for shape in shapes)
    return inertial.replace("</link>", f"{visuals}</link>")


@pytest.fixture
def doubts(tmp_path) -> Callable[[str], str]:
    """All that an arm is doubted for whose last link is given."""

    def read(tool: str) -> str:
        arm = link("arm", 4.0, "0.2 0 0", "0 0 0", ixy=0.0, ixz=0.0, iyz=0.0)
        joints = joint("j1", "base", "arm"), joint("j2", "arm", "tool", xyz="0.5 0 0")
        folder = tmp_path / "my_robot" / "urdf"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "robot.urdf").write_text(urdf(link("base", None), arm, tool, *joints))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", GdAnalyzeWarning)
            gd.load_arm(folder / "robot.urdf")
        return "\n".join(str(item.message) for item in caught)

    return read


@pytest.mark.parametrize(
    ("tool", "doubt"),
    [
        (drawn(body(com="-0.25 0 0"), BOX), "link tool: the centre of mass is 0.25 m outside the box"),
        (drawn(body(com="0.15 0 0.3"), BOX), "(0.3 x 0.1 x 0.1 m)"),
        (drawn(body(moment=0.3), BOX), "the radius of gyration is 0.474 m; 0.166 m is the most"),
        (drawn(body(mass=90.0, moment=0.2), BOX), "no material is dense enough for 90 kg"),
        (drawn(body(com="0.15 0.3 0"), UPRIGHT, origin='xyz="0.15 0 0" rpy="0 0.3 0"'), "outside the box"),
    ],
)
def test_a_body_that_its_shapes_contradict_is_doubted(doubts, tool, doubt):
    assert doubt in doubts(tool)


@pytest.mark.parametrize(
    "tool",
    [
        drawn(body(), BOX),
        drawn(body(com="0.15 0.15 0"), UPRIGHT, origin='xyz="0.15 0 0" rpy="1.5707963 0 0"'),
        drawn(body(com="-0.25 0 0"), BOX, '<mesh filename="gone.stl"/>'),
        drawn(body(com="-0.25 0 0"), '<box size="0.3 many"/>'),
        drawn(body(com="-0.25 0 0"), '<box size="0.02 0.02 0.02"/>'),
        drawn(body(com="-0.25 0 0"), ""),
    ],
)
def test_a_body_within_its_shapes_or_without_known_ones_is_not_doubted(doubts, tool):
    assert doubts(tool) == ""


def stl(path: Path, size: float) -> None:
    """One triangle from the origin to (size, size, size), as a binary file."""
    corners = [0.0, 0.0, 0.0, size, size, size, size, 0.0, 0.0]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(bytes(80) + struct.pack("<I12fH", 1, 0.0, 0.0, 1.0, *corners, 0))


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("package://my_robot/meshes/tool.stl", "my_robot/meshes/tool.stl"),
        ("package://tools/tool.stl", "tools/tool.stl"),
        ("tool.stl", "my_robot/urdf/tool.stl"),
    ],
)
def test_a_mesh_beside_the_file_is_an_outline(doubts, tmp_path, name, file):
    stl(tmp_path / file, 300.0)
    mesh = f'<mesh filename="{name}" scale="0.001 0.001 0.001"/>'
    assert doubts(drawn(body(), mesh)) == ""
    assert "0.25 m outside the box" in doubts(drawn(body(com="-0.1 0.15 0.15"), mesh))
    stl(tmp_path / file, 0.3)
    assert "no material" not in doubts(drawn(body(), mesh))
    # A text file, too short and long: its letters are no number of triangles, nor do they overflow one.
    for text in (b"solid tool", b"solid tool\nfacet normal 0 0 1\n" * 40):
        (tmp_path / file).write_bytes(text)
        assert doubts(drawn(body(com="-0.25 0 0"), mesh)) == ""


@given(
    st.lists(st.tuples(*[st.floats(0.05, 1.0)] * 3), min_size=1, max_size=3),
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.integers(0, 1000),
)
def test_no_body_made_of_points_in_its_shapes_is_contradicted(tmp_path_factory, sizes, angles, seed):
    """Points of a turned box weigh: whatever they are, nothing of their body lies outside."""
    import pinocchio as pin

    from gd_analyze.robots.outlines import outline
    from gd_analyze.robots.text_file import read_xml

    rng, turn = np.random.default_rng(seed), pin.rpy.rpyToMatrix(*angles)
    points = np.vstack([(rng.uniform(-0.5, 0.5, (20, 3)) * size) @ turn.T for size in sizes])
    masses = rng.exponential(0.01, len(points))
    com = masses @ points / masses.sum()
    trace = 2 * masses @ ((points - com) ** 2).sum(axis=1)
    shapes = [f'<box size="{" ".join(map(repr, size))}"/>' for size in sizes]
    rpy = " ".join(map(repr, angles))
    path = tmp_path_factory.mktemp("robot") / "link.urdf"
    path.write_text(drawn(link("tool"), *shapes, origin=f'rpy="{rpy}"'))
    box = outline(read_xml(path), path)
    assert box is not None
    assert list(box.contradictions(float(masses.sum()), com, float(trace))) == []
