"""Frames, masses and inertias of MJCF's bodies, as MuJoCo's compiler has them."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pinocchio as pin

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, Location
from gd_analyze.robots.frames import RightAngles, straight
from gd_analyze.robots.mjcf_elements import TURNS
from gd_analyze.robots.parts import symmetric_tensor
from gd_analyze.robots.text_file import Node

# Shapes with a known volume, and the number of their sizes: radii and half lengths.
_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}
# Shapes without mass, and those whose mass is not known here.
_WITHOUT_MASS, _OF_FILES = ("plane", "hfield"), ("mesh", "sdf")
_DENSITY = "1000"
# MuJoCo passes over shapes of less mass, and balances moments that fall short by more.
_NEGLIGIBLE = 1e-14


class Compiler:
    """The <compiler> settings of a file, with which frames, masses and inertias are made.

    Parameters
    ----------
    nodes
        All <compiler> elements, of which later ones take the place of earlier ones.
    right
        Right angles made exact.
    """

    def __init__(self, nodes: Iterable[Node], right: RightAngles) -> None:
        self.right = right
        self.stated = merged(nodes)
        for key, words in (
            ("coordinate", ("local",)),
            ("angle", ("degree", "radian")),
            ("inertiafromgeom", ("auto", "true", "false")),
            ("autolimits", ("true", "false")),
            ("balanceinertia", ("false", "true")),
        ):
            word = self.stated.attributes.get(key, words[0])
            if word not in words:
                message, expected = f"<compiler {key}={word!r}> is not what MuJoCo reads", " or ".join(words)
                hint = "convert the file with MuJoCo"
                where = self.stated.places[key]
                raise ArmError(message, where=where, expected=expected, next_step=hint)
        self.turn = 360.0 if self.word("angle", "degree") == "degree" else 2 * math.pi  # in the file's unit
        self.euler = self.word("eulerseq", "xyz")
        if len(self.euler) != 3 or not set(self.euler) <= set("xyzXYZ"):
            expected, where = "three of x, y, z, X, Y, Z", self.stated.places["eulerseq"]
            raise ArmError("eulerseq names no axes", where=where, expected=expected, found=repr(self.euler))
        groups = self.stated.numbers("inertiagrouprange", 2, "0 5")
        self.groups = range(int(groups[0]), int(groups[1]) + 1)

    def word(self, key: str, default: str) -> str:
        """A setting as written."""
        return self.stated.attributes.get(key, default)

    def setting(self, key: str) -> float:
        """A number, 0 unless stated."""
        return self.stated.numbers(key, 1, "0")[0]

    def pose(self, node: Node, link: str) -> pin.SE3:
        """Place and rotation of an element, right angles exact."""
        node.numbers("pos", 3, "0 0 0")
        position = [float(self.right.length(word, link)) for word in node.words("pos", "0 0 0")]
        turns = [key for key in TURNS if key in node.attributes]
        if len(turns) > 1:
            message, hint = f"<{node.tag}> is turned twice", "keep one of them"
            raise ArmError(message, where=node.where, found=" and ".join(turns), next_step=hint)
        return pin.SE3(self._rotation(node, turns[0], link) if turns else np.eye(3), np.array(position))

    def _rotation(self, node: Node, key: str, link: str) -> FloatArray:
        numbers, words, where = np.array(node.numbers(key, TURNS[key])), node.words(key), node.where
        if key == "euler":
            turned = np.eye(3)
            for letter, word in zip(self.euler, words, strict=True):
                turn = self._turn(np.eye(3)["xyz".index(letter.lower())], word, link, node)
                turned = turned @ turn if letter.islower() else turn @ turned
            return straight(turned)
        if key == "axisangle" and numbers[:3].any():
            return straight(
                self._turn(self.right.direction(numbers[:3].tolist(), link), words[3], link, node)
            )
        rotation = _rotation_of(key, numbers)
        if rotation is None:
            raise ArmError(f"the {key} of {link} is 0", where=where, expected="a rotation")
        return self.right.rotation(rotation, words, link, where)

    def _turn(self, axis: FloatArray, word: str, link: str, node: Node) -> FloatArray:
        angle = float(self.right.angle(word, link, node.where, self.turn)) * (2 * math.pi / self.turn)
        return np.array(pin.exp3(angle * axis))

    def inertia(self, node: Node, link: str, place: pin.SE3) -> tuple[pin.Inertia, str]:
        """Mass and inertia of a <body> at a place, in its frame, and where they come from.

        That is "stated", "shapes", or "meshes" if some of its shapes have an unknown mass.
        """
        source, inertial = self.word("inertiafromgeom", "auto"), node.first("inertial")
        shapes = [
            geom
            for geom in node.all("geom")
            if int(geom.numbers("group", 1, "0")[0]) in self.groups and _may_weigh(geom)
        ]
        if source == "false" or (inertial is not None and (source == "auto" or not shapes)):
            shapes = []
        inertia, known = pin.Inertia.Zero(), [geom for geom in shapes if not _is_mesh(geom)]
        if shapes and (inertial is None or len(known) == len(shapes)):
            for geom in known:
                inertia += self._of_shape(geom, link)
        elif inertial is not None:
            inertia = _of_inertial(inertial, self.pose(inertial, link))
        made_from = "meshes" if len(known) < len(shapes) else "shapes" if shapes else "stated"
        # A body that states nothing has its inertia as far from its frame as this is from the outer one.
        is_empty = inertial is None and not shapes
        return self._bounded(inertia, place.translation if is_empty else None), made_from

    def _of_shape(self, geom: Node, link: str) -> pin.Inertia:
        """Mass and inertia of a shape, in the frame of its body."""
        kind, along = geom.attributes.get("type", "sphere"), "fromto" in geom.attributes
        sizes = 1 if along else _SIZES[kind]
        size = geom.numbers("size", max(sizes, len(geom.words("size"))), "")[:sizes]
        pose = self._along(geom, size) if along else self.pose(geom, link)
        if along and kind in ("ellipsoid", "box"):
            size.insert(1, size[0])
        if min(size) <= 0.0:
            message, found = f"a size of a {kind} is not above 0", geom.attributes.get("size")
            raise ArmError(message, where=geom.places.get("size", geom.where), found=found)
        is_shell = geom.attributes.get("shellinertia", "false") == "true"
        if is_shell and kind == "ellipsoid":
            message, hint = "the inertia of an ellipsoid's shell has no formula", "state <inertial>"
            raise ArmError(message, where=geom.where, next_step=hint)
        measures, squares = map(np.array, zip(*_pieces(kind, np.array(size), is_shell), strict=True))
        (mass,) = geom.numbers("mass", 1, str(_density(geom) * float(measures.sum())), least=0)
        x2, y2, z2 = measures @ squares / measures.sum()
        moments = mass * np.diag([y2 + z2, z2 + x2, x2 + y2])
        return pose.act(pin.Inertia(mass, np.zeros(3), moments))

    def _along(self, geom: Node, size: list[float]) -> pin.SE3:
        """Frame of a shape between two points, whose half length becomes its last size."""
        kind, places = (
            geom.attributes.get("type", "sphere"),
            [key for key in ("pos", *TURNS) if key in geom.attributes],
        )
        if places or kind == "sphere":
            found = f"a {kind}" + "".join(f" with {key}" for key in places)
            hint = "state either fromto, of a capsule, cylinder, ellipsoid or box, or pos"
            raise ArmError("a shape is placed twice", where=geom.where, found=found, next_step=hint)
        start, end = np.array(geom.numbers("fromto", 6)).reshape(2, 3)
        half = float(np.linalg.norm(start - end)) / 2
        rotation = _rotation_of("zaxis", start - end)
        size.append(half)
        return pin.SE3(np.eye(3) if rotation is None else rotation, (start + end) / 2)

    def _bounded(self, inertia: pin.Inertia, place: FloatArray | None) -> pin.Inertia:
        """The inertia with the least mass and moments, and with balanced ones, where that is asked for."""
        mass, least = self.setting("boundmass"), self.setting("boundinertia")
        balances = self.word("balanceinertia", "false") == "true"
        if not (mass or least or balances):
            return inertia
        moments, axes = np.linalg.eigh(inertia.inertia)
        moments = np.maximum(moments, least)
        if balances and moments[0] + moments[1] < moments[2] - _NEGLIGIBLE:
            moments[:] = moments.mean()
        com = np.array(inertia.lever) if place is None else place
        return pin.Inertia(max(mass, inertia.mass), com, axes @ np.diag(moments) @ axes.T)


def merged(nodes: Iterable[Node]) -> Node:
    """The attributes of elements, of which later ones take the place of earlier ones."""
    out = Node("", {}, Location(""))
    for node in nodes:
        out.tag, out.where = node.tag, node.where
        out.attributes |= node.attributes
        out.places |= dict.fromkeys(node.attributes, node.where)
    return out


def _may_weigh(geom: Node) -> bool:
    """Whether a shape has mass, as far as is known."""
    kind = geom.attributes.get("type", "sphere")
    if kind not in (*_SIZES, *_WITHOUT_MASS, *_OF_FILES):
        message, expected = f"there is no shape {kind!r}", ", ".join((*_SIZES, *_WITHOUT_MASS, *_OF_FILES))
        raise ArmError(message, where=geom.places.get("type", geom.where), expected=expected)
    (mass,) = geom.numbers("mass", 1, "1", least=0)
    return (
        kind not in _WITHOUT_MASS and mass > _NEGLIGIBLE and ("mass" in geom.attributes or _density(geom) > 0)
    )


def _density(geom: Node) -> float:
    return geom.numbers("density", 1, _DENSITY, least=0)[0]


def _is_mesh(geom: Node) -> bool:
    return "mesh" in geom.attributes or geom.attributes.get("type") in _OF_FILES


def _of_inertial(inertial: Node, pose: pin.SE3) -> pin.Inertia:
    """Mass and inertia that a body states, in its frame; `pose` is that of the <inertial>."""
    (mass,) = inertial.numbers("mass", 1, least=0)
    stated = [key for key in ("diaginertia", "fullinertia", *TURNS) if key in inertial.attributes]
    if len(stated) > 1 and "fullinertia" in stated:
        hint = "state diaginertia along turned axes, or fullinertia along the body's"
        found = " and ".join(stated)
        raise ArmError("the inertia is stated twice", where=inertial.where, found=found, next_step=hint)
    moments = np.zeros((3, 3))
    if "diaginertia" in stated:
        moments = np.diag(inertial.numbers("diaginertia", 3))
    elif "fullinertia" in stated:
        moments = symmetric_tensor(*inertial.numbers("fullinertia", 6))
    return pose.act(pin.Inertia(mass, np.zeros(3), moments))


def _pieces(kind: str, size: FloatArray, is_shell: bool) -> list[tuple[float, tuple[float, float, float]]]:
    """Volumes (of a shell areas) that make a shape, and the means of x^2, y^2, z^2 over each."""
    if kind == "box":
        if not is_shell:
            return [(8 * float(size.prod()), tuple(size**2 / 3))]
        faces = []
        for axis in range(3):
            squares = size**2 / 3
            squares[axis] = size[axis] ** 2
            faces.append((8 * float(size.prod() / size[axis]), tuple(squares)))
        return faces
    if kind in ("sphere", "ellipsoid"):
        radii = np.broadcast_to(size, 3)
        if is_shell:
            return [(4 * math.pi * size[0] ** 2, tuple(radii**2 / 3))]
        return [(4 / 3 * math.pi * float(radii.prod()), tuple(radii**2 / 5))]
    r, height = float(size[0]), 2 * float(size[1])
    side = (math.pi * r**2 * height, (r**2 / 4, r**2 / 4, height**2 / 12))
    if is_shell:
        side = (2 * math.pi * r * height, (r**2 / 2, r**2 / 2, height**2 / 12))
    if kind == "cylinder":
        disks = (2 * math.pi * r**2, (r**2 / 4, r**2 / 4, height**2 / 4))
        return [side, disks] if is_shell else [side]
    # Two half spheres, at heights u above the ends of the side; means of u and of u^2.
    measure, u, u2 = 4 / 3 * math.pi * r**3, 3 * r / 8, r**2 / 5
    if is_shell:
        measure, u, u2 = 4 * math.pi * r**2, r / 2, r**2 / 3
    return [side, (measure, (u2, u2, height**2 / 4 + height * u + u2))]


def _rotation_of(key: str, numbers: FloatArray) -> FloatArray | None:
    """Rotation of a quaternion (w, x, y, z), x and y axes, or the least that turns z; None of zeros."""
    largest = float(np.abs(numbers).max())
    if largest == 0.0 or key == "axisangle":
        return None
    numbers = numbers / largest  # whose square might overflow
    if key == "quat":
        w, x, y, z = numbers / np.linalg.norm(numbers)
        return np.array(pin.Quaternion(w, x, y, z).toRotationMatrix())
    if key == "zaxis":
        numbers = numbers / np.linalg.norm(numbers)
        sine, axis = math.hypot(numbers[0], numbers[1]), np.array([-numbers[1], numbers[0], 0.0])
        axis = axis / sine if sine > 0 else np.array([1.0, 0.0, 0.0])
        return np.array(pin.exp3(math.atan2(sine, numbers[2]) * axis))
    x, y = numbers[:3], numbers[3:]
    if not x.any():
        return None
    x = x / np.linalg.norm(x)
    y = y - (y @ x) * x
    if np.linalg.norm(y) <= _NEGLIGIBLE:
        return None
    y = y / np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])
