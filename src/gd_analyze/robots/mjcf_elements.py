"""The elements of MJCF: which are read, which move no torque, which are told; all others are refused.

Told is a force or inertia beside D, h and c, where it acts on the arm. Whatever else MuJoCo knows may change
the dynamics. Attributes of its former versions are known, too.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from gd_analyze.errors import ArmError
from gd_analyze.robots.text_file import Node

# Ways to turn a frame, with their numbers of values; an element states one of them at most.
TURNS = {"quat": 4, "euler": 3, "axisangle": 4, "xyaxes": 6, "zaxis": 3}
_EXPANDED_BY_MUJOCO = ("include", "frame", "replicate", "attach", "composite", "flexcomp")
_ACTUATORS = ("general", "motor", "position", "velocity", "intvelocity", "orientation", "pid", "damper",
              "cylinder", "muscle", "adhesion", "dcmotor", "plugin")  # fmt: skip
_POSE = " ".join(("pos", *TURNS))
# Kind of elements with any attributes and children; and an attribute that stands for all.
_IDLE, _ANY = "idle", "*"


class _Kind(NamedTuple):
    """What may stand in an element."""

    read: str  # attributes
    idle: str = ""  # attributes that move no torque, or only together with one that is told
    told: Mapping[str, str] = MappingProxyType({})  # attributes with what they are, where they are not 0
    within: Mapping[str, str] = MappingProxyType({})  # kinds of the children, by their tags


def _idle(*tags: str) -> dict[str, str]:
    return dict.fromkeys(tags, _IDLE)


_KINDS = {
    "mujoco": _Kind(
        "model",
        within={"compiler": "compiler", "option": "option", "default": "default", "worldbody": "worldbody",
                "tendon": "tendons", "equality": "equalities", "actuator": "actuators",
                # Contacts are no part of the arm, and a plugin's instance acts where it is named.
                **_idle("size", "statistic", "visual", "asset", "contact", "sensor", "custom", "keyframe",
                        "skin", "extension", "deformable")},
    ),
    "compiler": _Kind(
        """angle autolimits balanceinertia boundinertia boundmass coordinate eulerseq inertiafromgeom
        inertiagrouprange settotalmass""",
        """alignfree assetdir conflict convexhull discardvisual exactmeshinertia fitaabb fusestatic meshdir
        passthrough savecanonical savecompiled saveinertial strippath texturedir usethread""",
        within=_idle("lengthrange"),
    ),
    "option": _Kind(
        "gravity",
        """actuatorgroupdisable apirate ccd_iterations ccd_tolerance collision cone impratio integrator
        iterations jacobian ls_iterations ls_tolerance magnetic mpr_iterations mpr_tolerance noslip_iterations
        noslip_tolerance o_friction o_margin o_solimp o_solref sdf_initpoints sdf_iterations sleep_tolerance
        solver timestep tolerance wind""",
        dict.fromkeys(("density", "viscosity"), "the drag of a fluid"),
        {"flag": "flag"},
    ),
    "flag": _Kind(
        "gravity equality constraint",
        """actuation autoreset clampctrl contact damper diagexact energy eulerdamp filterparent frictionloss
        fwdinv invdiscrete ipc island limit midphase multiccd nativeccd override passive refsafe sensor
        sensornoise sleep speculative spring warmstart""",
    ),
    "default": _Kind(
        "class",
        within={"default": "default", "joint": "joint", "geom": "geom", "tendon": "tendon",
                "equality": "equality", **dict.fromkeys(_ACTUATORS, "actuator"),
                **_idle("mesh", "material", "texture", "site", "camera", "light", "pair", "skin")},
    ),
    "worldbody": _Kind(
        "childclass", "name", within={"body": "body", **_idle("geom", "site", "camera", "light")}
    ),
    "body": _Kind(
        f"name childclass {_POSE}",
        "fuse mocap simple sleep user",
        {"gravcomp": "compensation of its weight"},
        {"body": "body", "inertial": "inertial", "joint": "joint", "freejoint": "freejoint", "geom": "geom",
         **_idle("site", "camera", "light", "plugin")},
    ),
    "inertial": _Kind(f"mass diaginertia fullinertia {_POSE}"),
    "joint": _Kind(
        """name class type pos axis ref range limited armature damping frictionloss actuatorfrcrange
        actuatorfrclimited""",
        """actuatorgravcomp group margin solimpfriction solimplimit solreffriction solreflimit springref
        springyield user""",
        dict.fromkeys(("stiffness", "springdamper"), "a spring"),
    ),
    "freejoint": _Kind("name", "align group"),
    "geom": _Kind(
        f"name class type size mass density fromto shellinertia group mesh {_POSE}",
        """adhesion castshadow conaffinity condim contype fitscale fluidcoef fluidshape friction gap hfield
        margin material priority rgba solimp solmix solref surfacevel user""",
        within=_idle("plugin"),
    ),
    "tendons": _Kind("", within={"fixed": "tendon", "spatial": "tendon"}),
    "tendon": _Kind(
        "class name",
        """actuatorfrclimited actuatorfrcrange group limited margin material range rgba solimpfriction
        solimplimit solreffriction solreflimit springlength springyield user width""",
        {"stiffness": "a spring", "damping": "friction", "frictionloss": "friction", "armature": "inertia"},
        {"joint": "tendon's joint", "site": "tendon's site", "geom": "tendon's geom", **_idle("pulley")},
    ),
    "tendon's joint": _Kind("joint", "coef"),
    "tendon's site": _Kind("site"),
    "tendon's geom": _Kind("geom", "sidesite"),
    "equalities": _Kind("", within=dict.fromkeys(("connect", "weld", "joint", "tendon"), "equality")),
    "equality": _Kind(
        "name class active body1 body2 site1 site2 joint1 joint2 tendon1 tendon2 polycoef",
        "anchor relpose solimp solref torquescale",
    ),
    "actuators": _Kind("", within=dict.fromkeys(_ACTUATORS, "actuator")),
    # All others shape the actuator's force, which is part of tau.
    "actuator": _Kind(
        "class joint jointinparent gear forcerange forcelimited ctrlrange ctrllimited",
        _ANY,
        {"armature": "inertia", "damping": "friction"},  # read of those that drive joints
    ),
}  # fmt: skip
# Kinds of elements that take the attributes of a default.
_WITH_DEFAULTS = ("joint", "geom", "tendon", "equality", "actuator")


def told(node: Node, kind: str) -> dict[str, str]:
    """What an element states beside D, h and c, by attribute."""
    return {key: text for key, text in _KINDS[kind].told.items() if node.is_not_zero(key)}


def refuse_unknown(node: Node, kind: str = "mujoco") -> None:
    """Raise an ArmError at the first element or attribute of which is not known what it does."""
    known = _KINDS[kind]
    words = {*known.read.split(), *known.idle.split(), *known.told}
    hint = "remove it if it moves no torque, or load the file with MuJoCo and save the model anew"
    for key in node.attributes:
        if key not in words and _ANY not in words:
            message = f"what {key} of <{node.tag}> does to the dynamics is not known here"
            raise ArmError(message, where=node.where, found=repr(node.attributes[key]), next_step=hint)
    for child in node.children:
        if child.tag in _EXPANDED_BY_MUJOCO:
            hint = "load the file with MuJoCo and call mujoco.mj_saveLastXML('robot.xml', model)"
            hint = f'set <compiler saveinertial="true"/>, {hint}'
            raise ArmError(f"only MuJoCo can expand <{child.tag}>", where=child.where, next_step=hint)
        inner = known.within.get(child.tag)
        if inner is None:
            message = f"what <{child.tag}> within <{node.tag}> does to the dynamics is not known here"
            raise ArmError(message, where=child.where, next_step=hint)
        if inner != _IDLE:
            refuse_unknown(child, inner)


def with_defaults(root: Node) -> Node:
    """The file with its defaults written at every element; ArmError if a class is unknown."""
    classes: dict[str, dict[str, Node]] = {"main": {}}
    for node in root.all("default"):
        name = node.attributes.get("class", "main")
        if name != "main":
            message, hint = f"the outermost class of defaults is {name!r}", "write it within <default>"
            raise ArmError(message, where=node.where, expected="class main, or none", next_step=hint)
        _note_classes(node, "main", {}, classes)
    return _with_defaults(root, "mujoco", "main", classes)


def _note_classes(
    default: Node, name: str, above: dict[str, Node], classes: dict[str, dict[str, Node]]
) -> None:
    """Collect the defaults of a class, by kind, with those that it inherits from the outer class."""
    stated = {**above, **classes.get(name, {})}
    for node in default.children:
        kind = _KINDS["default"].within[node.tag]
        if kind in _WITH_DEFAULTS:
            stated[kind] = _merged(node, stated.get(kind))
    classes[name] = stated
    for inner in default.all("default"):
        if "class" not in inner.attributes:
            raise ArmError("a class of defaults has no name", where=inner.where, next_step="add class")
        if inner.attributes["class"] in classes:
            message = f"two <default> elements have the class {inner.attributes['class']!r}"
            raise ArmError(message, where=inner.where, next_step="rename one")
        _note_classes(inner, inner.attributes["class"], stated, classes)


def _with_defaults(node: Node, kind: str, childclass: str, classes: dict[str, dict[str, Node]]) -> Node:
    childclass = node.attributes.get("childclass", childclass)
    name = node.attributes.get("class", childclass)
    for key, value in (("childclass", childclass), ("class", name)):
        if value not in classes and kind in ("body", *_WITH_DEFAULTS):
            message, expected = f"{key} {value!r} is no class of defaults", ", ".join(classes)
            raise ArmError(message, where=node.where, expected=expected, next_step="name one of the file's")
    out = _merged(node, classes[name].get(kind)) if kind in _WITH_DEFAULTS else node
    within = _KINDS[kind].within
    children = [
        _with_defaults(child, within[child.tag], childclass, classes) if within[child.tag] != _IDLE else child
        for child in node.children
        if child.tag != "default"
    ]
    return Node(out.tag, out.attributes, out.where, children, places=out.places)


def _merged(node: Node, default: Node | None) -> Node:
    """An element with a default's attributes, of which its own take the place."""
    if default is None:
        return node
    turned = any(key in node.attributes for key in TURNS)
    inherited = {key: value for key, value in default.attributes.items() if not (turned and key in TURNS)}
    stated = inherited | node.attributes
    own, ahead = node.words("size"), default.words("size")
    if own and len(own) < len(ahead):  # the first of several sizes may be stated alone
        stated["size"] = " ".join((*own, *ahead[len(own) :]))
    places = {key: default.places.get(key, default.where) for key in stated if key not in node.attributes}
    return Node(node.tag, stated, node.where, node.children, places={**places, **node.places})
