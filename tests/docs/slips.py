"""Slips, and what verbs say of them; docs/diagnose.md lists the silent ones.

A slip leaves a file readable and its numbers wrong. Each is made from a shipped arm: a log of its motion, or
a file of the robot, wrong in one way. A verb reads it; it refuses it, warns, names a cause, or is silent.
"""

from __future__ import annotations

import io
import json
import re
import tempfile
from collections.abc import Callable, Iterator
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import gd_analyze as gd
from gd_analyze.arrays import FloatArray
from gd_analyze.cli.entry import main
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.tables import with_payload
from gd_analyze.types import Link, Placement, RobotArm, States

ROOT = Path(__file__).parents[2]
ARM = "puma560"
N = 6
# The file without a slip, on which every verb is silent.
RIGHT = "nothing is wrong"


@dataclass(frozen=True)
class Slip:
    """A mistake, the file with it, and the verb that reads it."""

    mistake: str
    outcome: str  # "refused", "warned", "named" (the cause, by `diagnose`) or "silent"
    make: Callable[[], dict[str, str]]  # files by name
    words: str  # after `gd-analyze`
    cause: str = ""  # right ones, "a or b", of which `diagnose` should name one
    slow: bool = False  # takes longer than a second

    def happens(self) -> str:
        """Make the files in a folder of their own, run the verb there, and say what it did."""
        with tempfile.TemporaryDirectory() as folder, chdir(folder):
            for name, text in self.make().items():
                Path(name).write_text(text, encoding="utf-8")
            code, out = ran(self.words)
        if code:
            return "refused"
        document = json.loads(out)
        if self.words.startswith("diagnose"):
            return self.diagnosed(document)
        return "warned" if document["warnings"] or document.get("suspicious") else "silent"

    def diagnosed(self, document: dict[str, object]) -> str:
        """What `diagnose` says: the right cause, another one, a doubt, or that log and file agree."""
        cause = document["cause"]
        if cause is not None:
            return "named" if cause in self.cause.split(" or ") else "another cause named"
        agrees = str(document["headline"]).endswith("of the torque or less is left.")
        return "silent" if agrees else "warned"


def ran(words: str) -> tuple[int, str]:
    """Exit code and standard output of a verb, run in this process."""
    out, code = io.StringIO(), 0
    with redirect_stdout(out), redirect_stderr(io.StringIO()):
        try:
            main(words.split())
        except SystemExit as leaving:
            code = int(leaving.code or 0)
    return code, out.getvalue()


# ------------------------------------------------------------------------------------------------- logs


@dataclass
class Recording:
    """Readings of a motion of the arm: a hundred a second, and what its drives give."""

    time: FloatArray
    q: FloatArray
    qd: FloatArray
    torque: FloatArray


@cache
def arm() -> RobotArm:
    return gd.load_arm(ARM)


@cache
def whole_arm() -> RobotArm:
    """The arm as a maker's file has it: with a mass of the first link, and moments that a body can have."""
    of = arm()
    first = replace(
        of.links[0],
        mass=13.0,
        com=np.array([0.0, 0.1, 0.0]),
        inertia_com=np.diag([0.4, 0.2, 0.4]),
        axial_only=False,
    )
    return replace(of, links=tuple(map(possible, (first, *of.links[1:]))))


def possible(link: Link) -> Link:
    """The link with a smallest moment as large as the others ask for, where a measured one is too small."""
    moments, axes = np.linalg.eigh(link.inertia_com)
    moments[0] = max(moments[0], 1.001 * (moments[2] - moments[1]))
    return replace(link, inertia_com=axes @ np.diag(moments) @ axes.T, as_measured=False)


@cache
def motion() -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Instants, joint variables, velocities and torques of a motion that the drives can follow."""
    time, rng = np.arange(600) / 100.0, np.random.default_rng(3)
    sizes, phases = rng.uniform(0.1, 0.2, (3, N)), rng.uniform(0.0, 2.0 * np.pi, (3, N))
    rates = 2.0 * np.pi / 6.0 * np.arange(1.0, 4.0)
    angles = np.multiply.outer(time, rates)[:, :, None] + phases
    middle = np.array([0.5 * (joint.lower + joint.upper) for joint in arm().joints])
    q = middle + (sizes * np.sin(angles)).sum(axis=1)
    qd = (sizes * rates[:, None] * np.cos(angles)).sum(axis=1)
    qdd = -(sizes * rates[:, None] ** 2 * np.sin(angles)).sum(axis=1)
    return time, q, qd, torque_of(arm(), States(q, qd, qdd), drives=True)


def recording() -> Recording:
    """Without a slip; encoders resolve 1e-5 rad, and torques half a per cent."""
    time, q, qd, torque = motion()
    rng = np.random.default_rng(0)
    noisy = torque + 0.005 * np.sqrt((torque**2).mean(axis=0)) * rng.normal(size=torque.shape)
    return Recording(time.copy(), q + 1e-5 * rng.normal(size=q.shape), qd.copy(), noisy)


def table(header: str, *columns: FloatArray, separator: str = ",") -> str:
    """Columns as CSV; an empty header is left out."""
    rows = np.column_stack(columns)
    lines = [separator.join(f"{value:.9g}" for value in row) for row in rows.tolist()]
    return "\n".join([header] * bool(header) + lines) + "\n"


def names(role: str, numbers: range | list[int] = range(1, N + 1)) -> str:
    return ",".join(f"{role}{k}" for k in numbers)


def log(change: Callable[[Recording], None] = lambda made: None, torques: bool = False) -> dict[str, str]:
    """A log with a slip: time, positions and, for `diagnose`, torques."""
    made = recording()
    change(made)
    if torques:
        return {"log.csv": table(f"time,{names('q')},{names('tau')}", made.time, made.q, made.torque)}
    return {"log.csv": table(f"time,{names('q')}", made.time, made.q)}


def scaled(factor: float) -> Callable[[], dict[str, str]]:
    def change(made: Recording) -> None:
        made.q = factor * made.q

    return lambda: log(change)


def paced(factor: float) -> Callable[[], dict[str, str]]:
    def change(made: Recording) -> None:
        made.time = factor * made.time

    return lambda: log(change)


def torques_changed(change: Callable[[Recording], None]) -> Callable[[], dict[str, str]]:
    return lambda: log(change, torques=True)


def multiplied(factor: float) -> Callable[[Recording], None]:
    def change(made: Recording) -> None:
        made.torque = factor * made.torque

    return change


def reversed_joint(made: Recording) -> None:
    made.q[:, 1] *= -1.0


def zero_off(made: Recording) -> None:
    made.q[:, 2] += np.pi / 2


def exchanged(made: Recording) -> None:
    made.q[:, [1, 2]] = made.q[:, [2, 1]]


def clipped(made: Recording) -> None:
    most = np.percentile(np.abs(made.torque), 70, axis=0)
    made.torque = np.clip(made.torque, -most, most)


def late(made: Recording) -> None:
    made.torque = np.roll(made.torque, 5, axis=0)


def loaded(made: Recording) -> None:
    time, q, qd, _ = motion()
    carried = with_payload(arm(), 2.5, [0.0, 0.0, 0.1])
    states = States(q, qd, np.gradient(qd, time, axis=0))
    made.torque = torque_of(carried, states, drives=True)


def hanging(made: Recording) -> None:
    time, q, qd, _ = motion()
    turned = replace(arm(), gravity_vector=-arm().gravity_vector)
    made.torque = torque_of(turned, States(q, qd, np.gradient(qd, time, axis=0)), drives=True)


def in_minutes(made: Recording) -> None:
    made.time = made.time / 60.0


def frozen(made: Recording) -> None:
    made.q[200:260, 1] = made.q[200, 1]


def still(made: Recording) -> None:
    made.time = made.time[:150]
    made.q = made.q[:1] + 1e-5 * np.random.default_rng(1).normal(size=(150, N))


def backwards(made: Recording) -> None:
    made.time[[300, 301]] = made.time[[301, 300]]


def doubled(made: Recording) -> None:
    rows = np.sort(np.append(np.arange(len(made.time)), np.arange(100, 200)))
    made.time, made.q, made.qd, made.torque = (x[rows] for x in (made.time, made.q, made.qd, made.torque))


def spikes(made: Recording) -> None:
    made.q[[120, 340], 3] += 1.0


def too_fast(made: Recording) -> None:
    made.time = made.time / 3.0


def short(rows: int, noise: float) -> Callable[[], dict[str, str]]:
    def change(made: Recording) -> None:
        rng = np.random.default_rng(2)
        chosen = slice(0, rows * 10, 10)
        made.time, made.q = made.time[chosen], made.q[chosen] + noise * rng.normal(size=(rows, N))

    return lambda: log(change)


def with_velocities(factor: float | FloatArray, header: str = "qd") -> Callable[[], dict[str, str]]:
    def make() -> dict[str, str]:
        made = recording()
        text = table(f"time,{names('q')},{names(header)}", made.time, made.q, factor * made.qd)
        return {"log.csv": text}

    return make


def plan_with(change: Callable[[list[str]], None]) -> Callable[[], dict[str, str]]:
    """Lines of the planned motion, set points every 60 ms, with a slip."""

    def make() -> dict[str, str]:
        time, q, qd, _ = motion()
        qdd = np.gradient(qd, time, axis=0)
        header = f"time,{names('q')},{names('qd')},{names('qdd')}"
        lines = table(header, *(x[::6] for x in (time, q, qd, qdd))).splitlines()
        change(lines)
        return {"log.csv": "\n".join(lines) + "\n"}

    return make


def edited(row: int, column: int, value: str) -> Callable[[list[str]], None]:
    def change(lines: list[str]) -> None:
        cells = lines[row].split(",")
        cells[column] = value
        lines[row] = ",".join(cells)

    return change


def plain(header: str, *, gap: float = 1.0, time: bool = True) -> Callable[[], dict[str, str]]:
    def make() -> dict[str, str]:
        made = recording()
        columns = (gap * made.time, made.q) if time else (made.q,)
        return {"log.csv": table(header, *columns)}

    return make


def currents(header: str) -> Callable[[], dict[str, str]]:
    def make() -> dict[str, str]:
        made = recording()
        return {"log.csv": table(f"time,{names('q')},{names(header)}", made.time, made.q, made.torque / 20.0)}

    return make


def cut_short(lines: list[str]) -> None:
    lines[-1] = lines[-1].rpartition(",")[0]


def stretched(lines: list[str]) -> None:
    for row, line in enumerate(lines[1:], start=1):
        time, comma, rest = line.partition(",")
        lines[row] = f"{20.0 * float(time):.9g}{comma}{rest}"


def of_two_joints() -> dict[str, str]:
    time, q, *_ = motion()
    return {"log.csv": table("time,q1,q2", time, q[:, :2])}


COLUMNS = f"columns {ARM} log.csv --json"
DIAGNOSE = f"diagnose {ARM} log.csv --json"
LOGS = [
    Slip(RIGHT, "silent", log, COLUMNS),
    Slip("degrees read as radians", "warned", scaled(180.0 / np.pi), COLUMNS),
    Slip("encoder counts read as radians, 4096 a turn", "warned", scaled(4096 / (2.0 * np.pi)), COLUMNS),
    Slip("motor angles read as joint angles, a gear ratio of 100", "warned", scaled(100.0), COLUMNS),
    Slip("turns read as radians", "silent", scaled(1.0 / (2.0 * np.pi)), COLUMNS),
    Slip("time in ms read as seconds", "warned", paced(1e3), COLUMNS),
    Slip("time in us read as seconds", "warned", paced(1e6), COLUMNS),
    Slip("time in ns read as seconds", "warned", paced(1e9), COLUMNS),
    Slip("time in minutes read as seconds", "warned", paced(1.0 / 60.0), COLUMNS),
    Slip("a motion three times as fast as the drives can follow", "warned", lambda: log(too_fast), COLUMNS),
    Slip("an arm that stands still", "warned", lambda: log(still), COLUMNS),
    Slip("readings that freeze for 0.6 s", "warned", lambda: log(frozen), COLUMNS),
    Slip("readings with two spikes of 1 rad", "warned", lambda: log(spikes), COLUMNS),
    Slip("a hundred rows twice", "refused", lambda: log(doubled), COLUMNS),
    Slip("two rows in the wrong order", "refused", lambda: log(backwards), COLUMNS),
    Slip("no header, seven columns", "refused", plain(""), COLUMNS),
    Slip("no header, no time, as many columns as joints", "refused", plain("", time=False), COLUMNS),
    Slip("velocities in deg/s beside positions in rad", "warned", with_velocities(180.0 / np.pi), COLUMNS),
    Slip("velocities in 1/min beside positions in rad", "warned", with_velocities(30.0 / np.pi), COLUMNS),
    Slip("velocities of the opposite sign", "warned", with_velocities(-1.0), COLUMNS),
    Slip(
        "currents that are not named as torque, with a torque constant",
        "refused",
        currents("MACur.A"),
        f"{COLUMNS} --torque-constant 20,20,20,20,20,20",
    ),
    Slip("one column mapped to two joints", "refused", log, f"{COLUMNS} --map q:1=q1 --map q:2=q1"),
    Slip("nan in a plan", "refused", plan_with(edited(20, 3, "nan")), COLUMNS),
    Slip("an empty cell in a plan", "refused", plan_with(edited(20, 3, "")), COLUMNS),
    Slip("a row without its last column", "refused", plan_with(cut_short), COLUMNS),
    Slip("set points 1.2 s apart that were 60 ms apart", "warned", plan_with(stretched), COLUMNS),
    Slip("steps of 1 s in a log of positions that were 10 ms", "silent", paced(100.0), COLUMNS),
    Slip("a log of another arm, of two joints", "refused", of_two_joints, COLUMNS),
    Slip("noise of 1 mrad in a recording of 30 rows", "warned", short(30, 1e-3), COLUMNS),
    Slip("a joint of the opposite direction", "warned", lambda: log(reversed_joint), COLUMNS),
    Slip("an encoder's zero off by 90°", "silent", lambda: log(zero_off), COLUMNS),
    Slip("two joints exchanged", "warned", lambda: log(exchanged), COLUMNS),
]


TORQUES = [
    Slip(RIGHT, "silent", torques_changed(lambda made: None), DIAGNOSE, slow=True),
    Slip("torques in mN m", "named", torques_changed(multiplied(1e3)), DIAGNOSE, "torque scale", slow=True),
    Slip("torques in kN m", "named", torques_changed(multiplied(1e-3)), DIAGNOSE, "torque scale", slow=True),
    Slip(
        "torques of the opposite sign",
        "named",
        torques_changed(multiplied(-1.0)),
        DIAGNOSE,
        "torque sign",
        slow=True,
    ),
    Slip("torques clipped", "warned", torques_changed(clipped), DIAGNOSE, slow=True),
    Slip("torques 50 ms late", "named", torques_changed(late), DIAGNOSE, "lag of torque", slow=True),
    Slip(
        "a load of 2.5 kg that nobody states",
        "named",
        torques_changed(loaded),
        DIAGNOSE,
        "payload",
        slow=True,
    ),
    Slip(
        "an arm that hangs from the ceiling",
        "named",
        torques_changed(hanging),
        DIAGNOSE,
        "gravity",
        slow=True,
    ),
    Slip(
        "a joint of the opposite direction",
        "named",
        torques_changed(reversed_joint),
        DIAGNOSE,
        "direction of a joint",
        slow=True,
    ),
    Slip(
        "an encoder's zero off by 90°",
        "named",
        torques_changed(zero_off),
        DIAGNOSE,
        "zero of a joint",
        slow=True,
    ),
    Slip(
        "two joints exchanged",
        "named",
        torques_changed(exchanged),
        DIAGNOSE,
        "order of joints or order of torques",
        slow=True,
    ),
    Slip(
        "time in minutes read as seconds",
        "named",
        torques_changed(in_minutes),
        DIAGNOSE,
        "unit of time",
        slow=True,
    ),
]


# ----------------------------------------------------------------------------------------------- robots


def rpy(rotation: FloatArray) -> str:
    """Fixed-axis angles; an angle that is a multiple of a right angle has all its digits."""
    angles = Rotation.from_matrix(rotation).as_euler("xyz")
    return " ".join(f"{angle:.15g}" for angle in angles)


def numbers(values: FloatArray) -> str:
    return " ".join(f"{value:.9g}" for value in values)


def origin(placement: Placement) -> str:
    return f'<origin xyz="{numbers(placement.translation)}" rpy="{rpy(placement.rotation)}"/>'


def joint_frames(of: RobotArm) -> Iterator[tuple[Placement, Link]]:
    """Place of every joint in the frame of the one before, and its link with numbers in the joint's frame."""
    before = Placement()
    for joint, link in zip(of.joints, of.links, strict=True):
        at, frame = joint.placement, link.frame
        turned = before.rotation @ at.rotation
        moved = before.translation + before.rotation @ at.translation
        com = frame.translation + frame.rotation @ link.com
        inertia = frame.rotation @ link.inertia_com @ frame.rotation.T
        yield Placement(turned, moved), replace(link, com=com, inertia_com=inertia)
        before = frame


def urdf(of: RobotArm, *, shapes: bool = False) -> str:
    """The arm as a maker would write it, one element a line; drives' inertia has no place there."""
    rows = ['<robot name="arm">', '<link name="base"/>']
    parent, frames = "base", [*joint_frames(of)]
    for k, ((place, link), joint) in enumerate(zip(frames, of.joints, strict=True), start=1):
        i = link.inertia_com
        names_of = ("ixx", 0, 0), ("iyy", 1, 1), ("izz", 2, 2), ("ixy", 0, 1), ("ixz", 0, 2), ("iyz", 1, 2)
        moments = " ".join(f'{name}="{i[a, b]:.9g}"' for name, a, b in names_of)
        shape = ""
        if shapes:
            end = frames[k][0].translation if k < len(frames) else link.frame.translation
            size = np.abs(end) + 0.16
            box = f'<geometry><box size="{numbers(size)}"/></geometry>'
            shape = f'<visual><origin xyz="{numbers(end / 2)}"/>{box}</visual>'
        rows.append(
            f'<link name="link{k}"><inertial><origin xyz="{numbers(link.com)}"/>'
            f'<mass value="{link.mass:.9g}"/><inertia {moments}/></inertial>{shape}</link>'
        )
        limits = f'lower="{joint.lower or -3.1:.6g}" upper="{joint.upper or 3.1:.6g}"'
        effort, velocity = of.drives[k - 1].torque_limit or 0.0, joint.velocity_limit or 3.0
        rows.append(
            f'<joint name="joint{k}" type="revolute">{origin(place)}<parent link="{parent}"/>'
            f'<child link="link{k}"/><axis xyz="{numbers(joint.axis)}"/>'
            f'<limit {limits} effort="{effort:.6g}" velocity="{velocity:.6g}"/></joint>'
        )
        parent = f"link{k}"
    return "\n".join([*rows, "</robot>", ""])


def robot(change: Callable[[list[Link]], None], *, shapes: bool = False) -> Callable[[], dict[str, str]]:
    """The arm's URDF with links that are wrong; their numbers are in the frames of the joints."""

    def make() -> dict[str, str]:
        of = whole_arm()
        links = [replace(link, frame=Placement()) for _, link in joint_frames(of)]
        frames = [place for place, _ in joint_frames(of)]
        change(links)
        joints = [replace(joint, placement=place) for joint, place in zip(of.joints, frames, strict=True)]
        return {
            "arm.urdf": urdf(
                replace(of, joints=tuple(joints), links=tuple(links), dh_table=()), shapes=shapes
            )
        }

    return make


Words = str | Callable[[re.Match[str]], str]


def text(pattern: str, words: Words, count: int = 1) -> Callable[[], dict[str, str]]:
    """The arm's URDF with other words."""

    def make() -> dict[str, str]:
        written, found = re.subn(pattern, words, urdf(whole_arm()), count=count)
        assert found, pattern
        return {"arm.urdf": written}

    return make


def larger(factor: float) -> Words:
    """A number behind the group before it, multiplied."""
    return lambda match: f"{match[1]}{factor * float(match[2]):.4g}"


def longer(factor: float) -> Words:
    """An offset, multiplied."""
    return lambda match: f'{match[1]}xyz="{numbers(factor * np.array(match[2].split(), dtype=float))}"'


LINK3 = r'(<link name="link3">.*?)<mass value="[^"]*"/><inertia [^/]*/>'
DEFAULTS = r'\1<mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
XYZ = r'xyz="([^"]*)"'
AXIS2 = r'(<joint name="joint2".*?<axis xyz=")[^"]*'


def every(**factors: float) -> Callable[[list[Link]], None]:
    def change(links: list[Link]) -> None:
        for k, link in enumerate(links):
            links[k] = other(link, **factors)

    return change


def one(which: int, **factors: float) -> Callable[[list[Link]], None]:
    def change(links: list[Link]) -> None:
        links[which - 1] = other(links[which - 1], **factors)

    return change


def other(link: Link, mass: float = 1.0, com: float = 1.0, inertia: float = 1.0) -> Link:
    return replace(link, mass=mass * link.mass, com=com * link.com, inertia_com=inertia * link.inertia_com)


def about_frames(which: list[int]) -> Callable[[list[Link]], None]:
    def change(links: list[Link]) -> None:
        for k in which:
            link = links[k - 1]
            across = link.com @ link.com * np.eye(3) - np.outer(link.com, link.com)
            links[k - 1] = replace(link, inertia_com=link.inertia_com + link.mass * across)

    return change


def products_reversed(links: list[Link]) -> None:
    for k, link in enumerate(links):
        diagonal = np.diag(np.diag(link.inertia_com))
        links[k] = replace(link, inertia_com=2.0 * diagonal - link.inertia_com)


def shifted(links: list[Link]) -> None:
    links[:] = [links[-1], *links[:-1]]


def swapped(links: list[Link]) -> None:
    links[1], links[2] = links[2], links[1]


def in_frames_behind(links: list[Link]) -> None:
    """Centres of mass in the Denavit-Hartenberg frames behind the links, as tables of papers have them."""
    for k, link in enumerate(arm().links):
        links[k] = replace(links[k], com=link.com)


ARMS = "arms arm.urdf --json"
SHAPED = {"shapes": True}
ROBOTS = [
    Slip(RIGHT, "silent", robot(lambda links: None), ARMS),
    Slip("masses in pounds, of all links", "silent", robot(every(mass=2.2046, inertia=2.2046)), ARMS),
    Slip("the mass of one link in pounds", "silent", robot(one(3, mass=2.2046)), ARMS),
    Slip("masses in grams", "warned", robot(every(mass=1e3)), ARMS),
    Slip("the mass of one link ten times as large", "silent", robot(one(5, mass=10.0)), ARMS),
    Slip("centres of mass in mm", "warned", robot(every(com=1e3)), ARMS),
    Slip("centres of mass of the opposite sign", "warned", robot(every(com=-1.0)), ARMS),
    Slip(
        "centres of mass of the opposite sign, in a file with shapes",
        "warned",
        robot(every(com=-1.0), **SHAPED),
        ARMS,
    ),
    Slip("the centre of mass of one link of the opposite sign", "silent", robot(one(3, com=-1.0)), ARMS),
    Slip(
        "the centre of mass of one link of the opposite sign, in a file with shapes",
        "silent",
        robot(one(3, com=-1.0), **SHAPED),
        ARMS,
    ),
    Slip("centres of mass in the frames behind the links", "warned", robot(in_frames_behind), ARMS),
    Slip("the centre of mass of the last link ten times as far", "silent", robot(one(6, com=10.0)), ARMS),
    Slip("inertias in g m²", "warned", robot(every(inertia=1e3)), ARMS),
    Slip("inertias about the joints' frames", "silent", robot(about_frames([1, 2, 3, 4, 5, 6])), ARMS),
    Slip("the inertia of one link about its frame", "silent", robot(about_frames([3])), ARMS),
    Slip("the inertia of one link a thousand times as small", "silent", robot(one(2, inertia=1e-3)), ARMS),
    Slip("products of inertia of the opposite sign", "silent", robot(products_reversed), ARMS),
    Slip("every link's inertial shifted by one link", "warned", robot(shifted), ARMS),
    Slip(
        "every link's inertial shifted by one link, in a file with shapes",
        "warned",
        robot(shifted, **SHAPED),
        ARMS,
    ),
    Slip("two neighbouring links swapped", "silent", robot(swapped), ARMS),
    Slip("exporters' defaults: a mass of 1 and an inertia of 1, 1, 1", "warned", text(LINK3, DEFAULTS), ARMS),
    Slip(
        "a link without an inertial",
        "warned",
        text(r'<link name="link3">.*</link>', '<link name="link3"/>'),
        ARMS,
    ),
    Slip("lengths in mm", "warned", text(rf"(<joint .*?){XYZ}", longer(1e3), count=0), ARMS),
    Slip("one length in cm", "warned", text(rf'(<joint name="joint3".*?){XYZ}', longer(1e2)), ARMS),
    Slip(
        "a rotation in degrees", "warned", text(r'(<joint name="joint2".*?rpy=")[^"]*', r"\g<1>-90 0 0"), ARMS
    ),
    Slip(
        "ranges in degrees",
        "warned",
        text(r'lower="[^"]*" upper="[^"]*"', 'lower="-170" upper="170"', count=0),
        ARMS,
    ),
    Slip(
        "velocity limits in 1/min",
        "silent",
        text(r'(velocity=")([^"]*)', larger(30.0 / np.pi), count=0),
        ARMS,
    ),
    Slip("torque limits in kN m", "warned", text(r'(effort=")([^"]*)', larger(1e-3), count=0), ARMS),
    Slip("an axis of the opposite direction", "silent", text(AXIS2, r"\g<1>0 0 -1"), ARMS),
    Slip("an axis along x in place of z", "silent", text(AXIS2, r"\g<1>1 0 0"), ARMS),
    Slip("gravity of 981", "warned", lambda: {"arm.urdf": urdf(whole_arm())}, f"{ARMS} --gravity 0,0,-981"),
    Slip(
        "gravity that points up",
        "silent",
        lambda: {"arm.urdf": urdf(whole_arm())},
        f"{ARMS} --gravity 0,0,9.81",
    ),
    Slip(
        "a parent link that is declared nowhere",
        "refused",
        text(r'<link name="base"/>', '<link name="bottom"/>'),
        ARMS,
    ),
    Slip(
        "a joint that mimics a missing one",
        "refused",
        text(r'(<joint name="joint4".*?)</joint>', r'\1<mimic joint="gone"/></joint>'),
        ARMS,
    ),
    Slip(
        "`1_0` for a number",
        "refused",
        text(r'(<link name="link3">.*?<mass value=")[^"]*', r"\g<1>1_0"),
        ARMS,
    ),
    Slip(
        "a lever with mass beside the arm that follows a moving joint",
        "refused",
        lambda: {"arm.urdf": lever()},
        f"{ARMS} --tip link6",
    ),
    Slip(
        'in MJCF, `coordinate="global"`',
        "refused",
        lambda: {"arm.xml": mjcf('coordinate="global"')},
        "arms arm.xml --json",
    ),
    Slip(
        'in MJCF, `angle="gradian"`',
        "refused",
        lambda: {"arm.xml": mjcf('angle="gradian"')},
        "arms arm.xml --json",
    ),
    Slip(
        "in a table, modified parameters called standard",
        "warned",
        lambda: {"arm.toml": convention()},
        "arms arm.toml --json",
    ),
]


def lever() -> str:
    """The arm with a lever on its first link that follows the third joint."""
    written = urdf(whole_arm())
    beside = (
        '<link name="lever"><inertial><origin xyz="0.1 0 0"/><mass value="2"/>'
        '<inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>\n'
        '<joint name="follower" type="revolute"><parent link="link1"/><child link="lever"/>'
        '<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/>'
        '<mimic joint="joint3"/></joint>\n'
    )
    return written.replace("</robot>", f"{beside}</robot>")


def mjcf(compiler: str) -> str:
    bodies = (
        '<body name="upper"><joint name="shoulder" axis="0 1 0"/><inertial pos="0.2 0 0" mass="2" '
        'diaginertia="0.01 0.02 0.02"/></body>'
    )
    return f'<mujoco model="arm"><compiler {compiler}/><worldbody>{bodies}</worldbody></mujoco>'


def convention() -> str:
    """The shipped file, under the other convention."""
    path = Path(gd.__file__).parents[2] / "data" / "robots" / f"{ARM}.toml"
    written = path.read_text(encoding="utf-8")
    swapped_words = {"standard": "modified", "modified": "standard"}
    return re.sub(r'convention = "(\w+)"', lambda found: f'convention = "{swapped_words[found[1]]}"', written)


SECTIONS = {"logs": LOGS, "logs with torques": TORQUES, "robot files": ROBOTS}
