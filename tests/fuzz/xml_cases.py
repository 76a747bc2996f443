"""Robots in URDF and MJCF: valid ones, what is done to them, and what must hold of an arm that is read."""

from __future__ import annotations

import re
from functools import partial
from random import Random

import toml_cases
from changes import Stage, text_format
from hostile_values import number, text

from gd_analyze import load_arm
from robot_files import joint, link, two_joints, urdf

CHAIN = urdf(
    link("base", None),
    link("upper"),
    link("flange", 0.1),
    link("lower"),
    joint("turn", "base", "upper", "continuous", rest='<dynamics damping="0.1" friction="0.2"/>'),
    joint("fixed", "upper", "flange", "fixed", rpy="1.5708 0 -1.57"),
    joint("slide", "flange", "lower", "prismatic"),
    link("feeler", None),
    joint("follows", "lower", "feeler", rest='<mimic joint="turn" multiplier="2" offset="1"/>'),
)
INERTIAL = '<inertial pos="0.02 0.1 0.03" quat="1 0.2 0.3 0.1" mass="2" diaginertia="0.03 0.04 0.05"/>'
FULL = '<inertial pos="0 0 0" mass="1" fullinertia="0.03 0.04 0.05 0 0.001 0"/>'
MJCF = f"""<mujoco model="bench">
<compiler angle="degree" eulerseq="xyz"/>
<option gravity="0 0 -9.8"/>
<default><joint damping="0.1" armature="0.01"/>
<default class="wrist"><joint axis="0 1 0"/></default></default>
<worldbody>
<body name="base" pos="0 0 1"><geom type="mesh" mesh="m"/>
<body name="upper" euler="10 90 0">{INERTIAL}
<joint name="shoulder" axis="0 1 1" range="-90 90" ref="10" stiffness="0"/>
<joint name="lift" type="slide" pos="0.1 0 0" frictionloss="0.1"/>
<body name="lower" pos="0.3 0 0" axisangle="0 1 0 45" gravcomp="0">{FULL}
<joint name="elbow" class="wrist" actuatorfrcrange="-5 5"/><site name="tip"/>
<body name="hand" quat="0.707107 0.707107 0 0"><joint name="spin" axis="0 0 1"/>
<geom type="box" size="0.1 0.2 0.3" mass="3"/></body>
</body></body></body>
</worldbody>
<actuator><motor joint="shoulder" gear="50" ctrlrange="-1 1"/></actuator>
<equality><joint joint1="spin" joint2="elbow" polycoef="0 1 0 0 0" active="false"/></equality>
</mujoco>"""
SHAPES = """<mujoco model="shapes">
<compiler angle="radian" inertiagrouprange="0 3" settotalmass="4" boundmass="0.1" boundinertia="0.01"
 balanceinertia="true" inertiafromgeom="true" autolimits="true"/>
<option density="0"><flag equality="enable"/></option>
<default><geom type="box" size="0.1 0.2 0.3" density="500"/><motor gear="3"/>
<default class="light"><geom mass="0.2" zaxis="1 0 1"/><equality active="false"/></default></default>
<worldbody><body name="a" childclass="light" xyaxes="1 0 0 0 1 0">
<joint name="j" range="-1 1" limited="auto"/>
<geom type="capsule" size="0.1" fromto="0 0 0 0 0 1" class="main" shellinertia="true" group="1"/>
<geom/><site name="s"/>
<body name="b" pos="0.1 0 0"><joint name="k" axis="0 1 0" springdamper="0 0"/>
<geom type="cylinder" mass="1"/></body>
</body></worldbody>
<tendon><fixed name="t" stiffness="0"><joint joint="j" coef="1"/></fixed></tendon>
<equality><tendon tendon1="t" class="light"/><weld site1="s" site2="s" class="light"/></equality>
<actuator><position joint="k" armature="0.1" damping="0.1" forcerange="-9 9"/></actuator>
</mujoco>"""
BASES = [CHAIN, MJCF, SHAPES, two_joints()]
_ATTRIBUTE = re.compile(r'(\s)([\w:]+)="([^"]*)"')


def _change(random: Random, old: str, change: str) -> str:
    """One attribute of the file changed."""
    attributes = list(_ATTRIBUTE.finditer(old))
    if not attributes:
        return old
    attribute, donor = random.choice(attributes), random.choice(attributes)
    space, key, value = attribute.groups()
    words = value.split() or [""]
    new = random.choice([repr(number(random)), text(random), donor[3], "nan", "1e400", "-0.0", "1e-320", "0"])
    if change == "word":
        words[random.randrange(len(words))] = new
        value = " ".join(words)
    elif change == "value":
        value = new
    elif change == "key":
        key = donor[2]
    elif change == "count":
        value = " ".join(words[:-1] if random.randrange(2) else [*words, words[0]])
    written = "" if change == "gone" else f'{space}{key}="{value}"'
    return old[: attribute.start()] + written + old[attribute.end() :]


def _tag(random: Random, old: str) -> str:
    """One element called as another."""
    tags = sorted(set(re.findall(r"<(\w+)", old)))
    if not tags:
        return old
    tag, new_tag = random.choice(tags), random.choice([*tags, "include", "xacro:arm", "freejoint", "frame"])
    return re.sub(rf"(</?){tag}\b", rf"\g<1>{new_tag}", old, count=random.choice([0, 2]))


CHANGES = {
    f"attribute's {name}": partial(_change, change=name) for name in ("word", "value", "key", "count", "gone")
}
STAGES = (Stage({**CHANGES, "tag": _tag}, str, weight=3),)


FORMAT = text_format(BASES, STAGES, load_arm, toml_cases.use)
