"""Outlines of links: the box around the shapes that a URDF file draws, and what contradicts it.

No point of a body lies outside its shapes, so its centre of mass does not either, and its radius of gyration
is at most half the diagonal of a box around them. Files draw some bodies too small: the limits leave room.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
import pinocchio as pin

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError
from gd_analyze.robots.bodies import NO_MASS
from gd_analyze.robots.text_file import Node
from gd_analyze.text import number

# Shapes of collisions may be cut to their core: a quarter of the diagonal and 2 cm are room for that.
_ROOM_SHARE_OF_DIAGONAL = 0.25
_ROOM_METRES = 0.02
# A box with a smaller diagonal marks a frame.
_FRAME_MARK_METRES = 0.05
# Osmium, the densest solid, has 22 600 kg/m^3; a box is larger than the shapes in it.
_DENSEST_SOLID = 22_600.0
# Bytes of a binary STL file: header and count, and a triangle's normal, corners and attribute.
_STL_HEAD_BYTES = 84
_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
# The largest mesh that is read, in bytes.
_LARGEST_STL_BYTES = 50_000_000


@dataclass(frozen=True)
class Outline:
    """The box around a link's shapes, along the axes of the link's frame.

    Attributes
    ----------
    lower, upper
        Its corners, m, each (3,).
    """

    lower: FloatArray
    upper: FloatArray

    @property
    def diagonal(self) -> float:
        """Length of its diagonal, m."""
        return float(np.linalg.norm(self.upper - self.lower))

    @property
    def volume(self) -> float:
        """Its volume, m^3."""
        return float(np.prod(self.upper - self.lower))

    @property
    def text(self) -> str:
        """Its edges in words."""
        return " x ".join(number(float(edge)) for edge in self.upper - self.lower) + " m"

    def distance(self, point: FloatArray) -> float:
        """Distance of a point (3,) from the box, 0 inside, m."""
        return float(np.linalg.norm(point - np.clip(point, self.lower, self.upper)))

    def contradictions(self, mass: float, com: FloatArray, moments: float) -> Iterator[str]:
        """What of a body cannot lie in the box, a sentence each.

        Parameters
        ----------
        mass
            Mass, kg.
        com
            Centre of mass in the link's frame, m, (3,).
        moments
            Sum of the moments of inertia about the centre of mass, kg m^2.
        """
        if mass < NO_MASS or self.diagonal < _FRAME_MARK_METRES:
            return
        room = _ROOM_SHARE_OF_DIAGONAL * self.diagonal + _ROOM_METRES
        if (outside := self.distance(com)) > room:
            position = f"{number(outside)} m outside the box around its shapes ({self.text})"
            yield f"the centre of mass is {position}; check its frame, signs and unit"
        gyration = math.sqrt(max(0.0, moments) / 2 / mass)
        if gyration > self.diagonal / 2 + room:
            limit = f"{number(self.diagonal / 2)} m is the most in the box around its shapes ({self.text})"
            yield f"the radius of gyration is {number(gyration)} m; {limit}: check the unit of its inertia"
        if self.volume > 0.0 and mass / self.volume > _DENSEST_SOLID:
            box = f"the box around its shapes ({self.text})"
            yield f"no material is dense enough for {number(mass)} kg in {box}; in grams?"


def outline(link: Node, path: Path) -> Outline | None:
    """Outline of a <link>; None if it draws no shape, or one whose size cannot be told."""
    try:
        return _outline(link, path)
    except (ArmError, OSError):  # a faulty drawing is no fault of the arm
        return None


def _outline(link: Node, path: Path) -> Outline | None:
    points: list[FloatArray] = []
    for drawn in link.all("visual", "collision"):
        corners = _corners(drawn.first("geometry"), path)
        if corners is None:
            return None
        place = drawn.first("origin") or Node("origin", {}, drawn.where)
        roll, pitch, yaw = place.numbers("rpy", 3, "0 0 0")
        points.append(corners @ pin.rpy.rpyToMatrix(roll, pitch, yaw).T + place.numbers("xyz", 3, "0 0 0"))
    if not points:
        return None
    corners = np.vstack(points)
    return Outline(corners.min(axis=0), corners.max(axis=0))


def _corners(geometry: Node | None, path: Path) -> FloatArray | None:
    """Corners of the box around a <geometry> in its own frame, (8, 3); None if it is not known."""
    shape = geometry.children[0] if geometry is not None and geometry.children else None
    if shape is None:
        return None
    if shape.tag == "box":
        half = np.array(shape.numbers("size", 3)) / 2
    elif shape.tag in ("cylinder", "capsule"):
        (radius,), (length,) = shape.numbers("radius", 1), shape.numbers("length", 1)
        half = np.array([radius, radius, length / 2 + (radius if shape.tag == "capsule" else 0.0)])
    elif shape.tag == "sphere":
        half = np.full(3, shape.numbers("radius", 1)[0])
    else:
        return _mesh_corners(shape, path) if shape.tag == "mesh" else None
    return _box(-half, half)


def _box(lower: FloatArray, upper: FloatArray) -> FloatArray:
    return np.array(list(product(*zip(lower, upper, strict=True))))


def _mesh_corners(mesh: Node, path: Path) -> FloatArray | None:
    """Corners of the box around a mesh, (8, 3), if it is a binary STL file beside the robot's file."""
    scale = np.array(mesh.numbers("scale", 3, "1 1 1"))
    file = _mesh_file(mesh.attributes.get("filename", ""), path)
    if file is None or file.stat().st_size > _LARGEST_STL_BYTES:
        return None
    data = file.read_bytes()
    # Of a text STL these bytes are letters.
    triangles = int.from_bytes(data[80:_STL_HEAD_BYTES], "little")
    if triangles == 0 or len(data) != _STL_HEAD_BYTES + triangles * _STL_TRIANGLE.itemsize:
        return None
    records = np.frombuffer(data, _STL_TRIANGLE, offset=_STL_HEAD_BYTES)
    corners = records["corners"].reshape(-1, 3).astype(float)
    return _box(corners.min(axis=0), corners.max(axis=0)) * scale if np.isfinite(corners).all() else None


def _mesh_file(name: str, path: Path) -> Path | None:
    """The STL file that a mesh names, relative to the robot's file or within its package."""
    package, _, inside = name.removeprefix("package://").partition("/")
    is_in_package = name.startswith("package://")
    for folder in (path.resolve().parent, *path.resolve().parents):
        candidate = folder / name if not is_in_package else folder / package / inside
        if is_in_package and folder.name == package:
            candidate = folder / inside
        if candidate.suffix.lower() == ".stl" and candidate.is_file():
            return candidate
        if not is_in_package:
            break
    return None
