"""Trial of diagnosis: synthetic logs of arms with one fault each, and logs without any.

Writes diagnosis_trial.md beside it: `python analysis/diagnosis_trial.py`; some 20 minutes, on two cores half of that.

A log is that of a robot whose links differ from the file's, with drives, Stribeck and load-dependent friction that
the file does not state, and noise. A fault is visible if the score of file and friction is worse than with the true
correction by more than `VISIBLE` (of loads: than that of the log without the load); a motion does not show the zero of
a vertical joint.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

import gd_analyze as gd
from gd_analyze.arrays import FloatArray
from gd_analyze.diagnosis.correction import Correction
from gd_analyze.diagnosis.diagnose import Diagnosis, diagnose
from gd_analyze.diagnosis.hypothesis import Candidate, inverse, signs, swapped
from gd_analyze.dynamics.base_parameters import parameters_of
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.files import write_text
from gd_analyze.motions.logged import Log
from gd_analyze.motions.states import States
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import arm_in
from gd_analyze.robots.parts import Link
from gd_analyze.robots.payload import with_payload
from logs_of_arms import fourier
from psdm_measure import arm_of

HERE = Path(__file__).with_suffix(".md")
# Fall of the score, against the log without the fault, that makes it visible: twice what a claim needs.
VISIBLE = 60.0
# Numbers that score as well as the true ones to within this are right as far as the log tells.
ALIKE = 5.0
# Tolerances of numbers told: torque factors, angles (rad), lag (s), pace.
NEAR_FACTOR, NEAR_ANGLE, NEAR_LAG, NEAR_PACE = 0.35, np.radians(12.0), 0.01, 0.15
HEAD = """# Diagnosis tried

{good} logs without a fault and {bad} with one, of {arms}. The robots differ from their files (masses by 5 to 25 %,
centres of mass and inertias alike), have drives and friction that the files do not state (Coulomb, viscous, Stribeck, a
share of load), and noise. Each motion is a random Fourier series. The script is `analysis/diagnosis_trial.py`.

"""

# Modified after the maker's table: d, a in mm, alpha in degrees; mass, kg; centre of mass, mm.
_UR = (
    (162.5, 0.0, 90.0, 3.76, (0, -25, 2)), (0.0, -425.0, 0.0, 8.06, (212, 0, 113)),
    (0.0, -392.2, 0.0, 2.85, (150, 0, 26)), (133.3, 0.0, 90.0, 1.37, (0, -2, 16)),
    (99.7, 0.0, -90.0, 1.30, (0, 2, 16)), (99.6, 0.0, 0.0, 0.36, (0, 0, -1)),
)  # fmt: skip


def ur_like() -> RobotArm:
    """An arm with the dimensions of a UR5e."""
    joints, links = [], []
    for d, a, alpha, mass, com in _UR:
        joints.append(
            {"d_mm": d, "a_mm": a, "alpha_deg": alpha, "range_deg": [-180.0, 180.0], "velocity_limit": 3.14,
             "acceleration_limit": 12.0}
        )  # fmt: skip
        length = max(abs(a), 100.0) / 1000.0
        across = mass * length**2 / 12.0
        links.append(
            {"mass": mass, "com_mm": list(map(float, com)),
             "inertia": {"xx": 0.3 * across, "yy": across, "zz": across}}
        )  # fmt: skip
    document = {
        "format": "gd-analyze arm 1", "name": "ur_like", "convention": "standard", "joints": joints, "links": links,
        "gravity": [0.0, 0.0, -9.81],
    }  # fmt: skip
    return arm_in(document, "ur_like")


def rail() -> RobotArm:
    """The same arm's first three joints on a horizontal rail."""
    whole = ur_like()
    slide = {"kind": "prismatic", "a_mm": 0.0, "alpha_deg": -90.0, "range": [0.0, 2.0], "velocity_limit": 1.5,
             "acceleration_limit": 4.0}  # fmt: skip
    document = {
        "format": "gd-analyze arm 1", "name": "rail", "convention": "standard", "gravity": [0.0, -9.81, 0.0],
        "joints": [slide], "links": [{"mass": 40.0, "com_mm": [0.0, 0.0, 0.0],
                                      "inertia": {"xx": 1.0, "yy": 1.0, "zz": 1.0}}],
    }  # fmt: skip
    one = arm_in(document, "rail")
    return replace(
        one, joints=(*one.joints, *whole.joints[:3]), links=(*one.links, *whole.links[:3]), dh_table=()
    )


def arms() -> dict[str, RobotArm]:
    """The arms by name."""
    return {
        "UR-like": ur_like(), "PUMA 560": gd.load_arm("puma560"), "Stanford arm": gd.load_arm("stanford"),
        "SCARA": gd.load_arm("scara"), "KR6": arm_of("KR6"), "LBR7": arm_of("LBR7"), "rail with arm": rail(),
    }  # fmt: skip


@dataclass
class Robot:
    """A robot beside its file, and a log of it before anything is wrong."""

    arm: RobotArm  # the robot's links
    file: RobotArm
    time: FloatArray
    states: States
    friction: FloatArray  # (n, 5): Coulomb, viscous, Stribeck, load, offset
    drives: FloatArray
    rng: np.random.Generator
    noise: tuple[float, float] = (1e-4, 0.02)

    @classmethod
    def of(
        cls, file: RobotArm, seed: int, seconds: float = 16.0, rate: float = 125.0, share: float = 0.9
    ) -> Robot:
        """Draw one."""
        rng, n = np.random.default_rng(seed), file.n_joints
        off = rng.uniform(0.05, 0.25)
        links = []
        for link in file.links:
            heavier, wider = 1.0 + off * rng.uniform(-1.0, 1.0, 2)
            com = link.com * (1.0 + off * rng.uniform(-1.0, 1.0, 3)) + 0.008 * rng.normal(size=3)
            links.append(replace(link, mass=heavier * link.mass, com=com,
                                 inertia_com=heavier * wider * link.inertia_com))  # fmt: skip
        arm = replace(file, links=tuple(links), drives=())
        instants, states = fourier(file, seconds, rate, seed)
        middle = states.q.mean(axis=0)
        states = States(middle + share * (states.q - middle), share * states.qd, share * states.qdd)
        rigid = torque_of(arm, states, drives=False)
        size = np.sqrt((rigid**2).mean(axis=0)) + 0.05 * np.sqrt((rigid**2).mean())
        fast = np.abs(states.qd).max(axis=0)
        pull = np.sqrt((states.qdd**2).mean(axis=0)) + 1e-9
        friction = np.column_stack([
            rng.uniform(0.05, 0.3, n) * size, rng.uniform(0.05, 0.3, n) * size / fast,
            rng.uniform(0.0, 0.08, n) * size, rng.uniform(0.0, 0.05, n), 0.05 * rng.normal(size=n) * size,
        ])  # fmt: skip
        return cls(arm, file, instants, states, friction, rng.uniform(0.0, 0.4, n) * size / pull, rng)

    def torque(self, arm: RobotArm | None = None) -> FloatArray:
        """What the joints need."""
        states = self.states
        rigid = torque_of(arm or self.arm, states, drives=False)
        coulomb, viscous, stribeck, load, offset = self.friction.T
        slow = np.exp(-np.square(states.qd / (0.1 * np.abs(states.qd).max(axis=0))))
        sign = np.tanh(states.qd / (0.005 * np.abs(states.qd).max(axis=0)))
        dry = (coulomb + stribeck * slow + load * np.abs(rigid)) * sign
        return np.asarray(rigid + self.drives * states.qdd + dry + viscous * states.qd + offset)

    def noisy(self, torque: FloatArray) -> FloatArray:
        """Torques with noise of their RMS."""
        return torque + self.noise[1] * np.sqrt((torque**2).mean(axis=0)) * self.rng.normal(size=torque.shape)

    def log(
        self, time_: FloatArray, q: FloatArray, torque: FloatArray, qd: FloatArray | None = None
    ) -> Trajectory:
        """The readings as a motion, velocities among them or not."""
        q = q + self.noise[0] * self.rng.normal(size=q.shape)
        return Trajectory.from_log(Log(time_, q, qd, None, torque, measured=True))

    @property
    def as_it_is(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Time, joint variables and torques without a fault."""
        return self.time, self.states.q, self.noisy(self.torque())


# A fault: how it changes a log, the name of the cause, and whether an answer tells it.
Told = Callable[[Candidate], bool]
# With the correction that is the truth, None where a correction does not say it.
Made = tuple[Trajectory, RobotArm, str, Told, Correction | None]
Fault = Callable[[Robot], Made | None]


def _same(truth: Correction) -> Told:
    def told(found: Candidate) -> bool:
        own = found.correction
        if not (np.allclose(own.position, truth.position)):
            return False
        turned = np.abs((own.offset - truth.offset + np.pi) % (2.0 * np.pi) - np.pi)
        zero = own.torque != 0.0
        if (zero != (truth.torque != 0.0)).any() or (np.sign(own.torque) != np.sign(truth.torque)).any():
            return False
        ratio = np.abs(np.log(own.torque[zero] / truth.torque[zero]))
        near = abs(own.lag - truth.lag) < NEAR_LAG and abs(np.log(own.pace / truth.pace)) < NEAR_PACE
        return bool(turned.max() < NEAR_ANGLE and np.median(ratio) < NEAR_FACTOR and near)

    return told


def _of_log(robot: Robot, name: str, truth: Correction) -> Made:
    """A log that a correction would mend."""
    time_, q, torque = robot.as_it_is
    q = (q - truth.offset) @ np.linalg.inv(truth.position).T
    torque = torque @ np.linalg.inv(truth.torque).T
    return robot.log(time_ / truth.pace, q, torque), robot.file, name, _same(truth), truth


def _none(robot: Robot) -> Correction:
    return Correction.none(robot.file.n_joints)


def _joint(robot: Robot) -> int:
    return int(robot.rng.integers(robot.file.n_joints))


def _turning(robot: Robot) -> int:
    return int(robot.rng.choice(np.flatnonzero(robot.file.is_revolute)))


def all_reversed(robot: Robot) -> Made:
    """All torques reversed."""
    n = robot.file.n_joints
    return _of_log(robot, "torque sign", _none(robot).with_torque(-np.eye(n)))


def one_reversed(robot: Robot) -> Made:
    """The torque of one joint reversed."""
    n = robot.file.n_joints
    return _of_log(robot, "torque sign", _none(robot).with_torque(signs(n, [_joint(robot)])))


def other_way(robot: Robot) -> Made:
    """A joint that counts the other way."""
    turned = signs(robot.file.n_joints, [_joint(robot)])
    return _of_log(robot, "direction of a joint", _none(robot).with_position(turned).with_torque(turned))


def another_unit(robot: Robot) -> Made:
    """Torques in another unit."""
    factor = robot.rng.choice([1e-3, 9.80665, 1e-2, 1.0 / 9.80665])
    return _of_log(robot, "torque scale", _none(robot).with_torque(factor * np.eye(robot.file.n_joints)))


def any_factor(robot: Robot) -> Made:
    """Torques times a factor that is no unit."""
    factor = robot.rng.choice([2.2, 3.5, 0.3, 25.0])
    return _of_log(robot, "torque scale", _none(robot).with_torque(factor * np.eye(robot.file.n_joints)))


def currents(robot: Robot) -> Made:
    """Currents in place of torques."""
    factors = np.exp(robot.rng.normal(np.log(20.0), 0.5, robot.file.n_joints))
    return _of_log(robot, "torque scale by joint", _none(robot).with_torque(np.diag(factors)))


def torques_exchanged(robot: Robot) -> Made:
    """Two torque columns exchanged."""
    n = robot.file.n_joints
    i, j = robot.rng.choice(n, 2, replace=False)
    return _of_log(robot, "order of torques", _none(robot).with_torque(swapped(n, int(i), int(j))))


def joints_exchanged(robot: Robot) -> Made | None:
    """Two joints exchanged."""
    n, turns = robot.file.n_joints, np.flatnonzero(robot.file.is_revolute)
    i, j = robot.rng.choice(turns, 2, replace=False)
    order = swapped(n, int(i), int(j))
    return _of_log(robot, "order of joints", _none(robot).with_position(order).with_torque(order))


def zero_of_quarter(robot: Robot) -> Made:
    """A zero off by 90 or 180 degrees."""
    angle = robot.rng.choice([0.5 * np.pi, -0.5 * np.pi, np.pi])
    return _of_log(robot, "zero of a joint", _none(robot).with_offset(_turning(robot), float(angle)))


def zero_of_any(robot: Robot) -> Made:
    """A zero off by 20 to 160 degrees."""
    angle = np.radians(robot.rng.uniform(20.0, 160.0)) * robot.rng.choice([-1.0, 1.0])
    return _of_log(robot, "zero of a joint", _none(robot).with_offset(_turning(robot), float(angle)))


def _mounted(robot: Robot, gravity: FloatArray) -> Made:
    torque = robot.noisy(robot.torque(replace(robot.arm, gravity=gravity)))
    log = robot.log(robot.time, robot.states.q, torque)

    def told(found: Candidate) -> bool:
        own = found.correction.gravity
        if own is None:
            return False
        if not gravity.any() or not own.any():
            return bool(gravity.any() == own.any())
        cosine = own @ gravity / np.linalg.norm(own) / np.linalg.norm(gravity)
        return bool(np.arccos(np.clip(cosine, -1.0, 1.0)) < NEAR_ANGLE)

    return log, robot.file, "gravity", told, replace(_none(robot), gravity=gravity)


def ceiling(robot: Robot) -> Made:
    """An arm that hangs."""
    return _mounted(robot, -robot.file.gravity)


def tilted(robot: Robot) -> Made:
    """An arm tilted by 25 to 90 degrees."""
    down = robot.file.gravity / np.linalg.norm(robot.file.gravity)
    across = np.cross(down, robot.rng.normal(size=3))
    angle = np.radians(robot.rng.uniform(25.0, 90.0))
    leaning = np.cos(angle) * down + np.sin(angle) * across / np.linalg.norm(across)
    return _mounted(robot, 9.81 * leaning)


def compensated(robot: Robot) -> Made:
    """Torques without gravity."""
    return _mounted(robot, np.zeros(3))


def _loaded(robot: Robot, share: float) -> RobotArm:
    mass = share * float(robot.arm.mass.sum())
    place = 0.08 * robot.file.reach * robot.rng.uniform(-1.0, 1.0, 3)
    return with_payload(robot.arm, mass, place)


def payload_missing(robot: Robot) -> Made:
    """A payload that the file lacks."""
    torque = robot.noisy(robot.torque(_loaded(robot, robot.rng.uniform(0.08, 0.2))))
    return robot.log(robot.time, robot.states.q, torque), robot.file, "payload", lambda found: True, None


def load_put_on(robot: Robot) -> Made:
    """A payload taken up during the log."""
    loaded = robot.torque(_loaded(robot, robot.rng.uniform(0.1, 0.2)))
    after = robot.time > robot.rng.uniform(0.3, 0.7) * robot.time[-1]
    torque = robot.noisy(np.where(after[:, None], loaded, robot.torque()))
    return (
        robot.log(robot.time, robot.states.q, torque),
        robot.file,
        "change in time",
        lambda found: True,
        None,
    )


def coupled(robot: Robot) -> Made | None:
    """A joint measured against the base; None where no axes are parallel."""
    from gd_analyze.diagnosis.of_positions import parallel_to_next

    pairs = np.flatnonzero(parallel_to_next(robot.file))
    if not len(pairs):
        return None
    i, matrix = int(robot.rng.choice(pairs)), np.eye(robot.file.n_joints)
    matrix[i + 1, i] = robot.rng.choice([-1.0, 1.0])
    return _of_log(robot, "coupled joints", _none(robot).with_position(matrix).with_torque(inverse(matrix).T))


def late(robot: Robot) -> Made:
    """Torques that are late or early."""
    lag = float(robot.rng.choice([0.03, 0.06, -0.05]))
    time_, q, torque = robot.as_it_is
    moved = np.column_stack([np.interp(time_ - lag, time_, column) for column in torque.T])
    inside = (time_ > 0.1) & (time_ < time_[-1] - 0.1)
    log = robot.log(time_[inside], q[inside], moved[inside])
    truth = replace(_none(robot), lag=lag)
    return log, robot.file, "lag of torque", _same(truth), truth


def slow_time(robot: Robot) -> Made:
    """Time in another unit."""
    pace = float(robot.rng.choice([0.5, 2.0, 0.1]))
    return _of_log(robot, "unit of time", replace(_none(robot), pace=pace))


def time_with_velocities(robot: Robot) -> Made:
    """Time in another unit in a log with velocities."""
    pace = float(robot.rng.choice([0.4, 3.0, 0.02]))
    time_, q, torque = robot.as_it_is
    truth = replace(_none(robot), pace=pace)
    log = robot.log(time_ / pace, q, torque, robot.states.qd)
    return log, robot.file, "unit of time", _same(truth), truth


def wrist_coupled(robot: Robot) -> Made | None:
    """A joint logged with its neighbour's motion, whose axis is not parallel; None without such a pair."""
    from gd_analyze.diagnosis.of_positions import parallel_to_next

    turns, parallel = robot.file.is_revolute, parallel_to_next(robot.file)
    pairs = [k for k in range(len(parallel)) if turns[k] and turns[k + 1] and not parallel[k]]
    if not pairs:
        return None
    i, matrix = int(robot.rng.choice(pairs)), np.eye(robot.file.n_joints)
    matrix[i + 1, i] = robot.rng.choice([-1.0, 1.0])
    return _of_log(robot, "coupled joints", _none(robot).with_position(matrix).with_torque(inverse(matrix).T))


def zero_of_slide(robot: Robot) -> Made | None:
    """The zero of a prismatic joint; None for an arm without one."""
    slides = np.flatnonzero(~np.array(robot.file.is_revolute))
    if not len(slides):
        return None
    length = float(robot.rng.uniform(0.15, 0.5) * robot.rng.choice([-1.0, 1.0]))
    return _of_log(robot, "zero of a joint", _none(robot).with_offset(int(robot.rng.choice(slides)), length))


def hand_left_out(robot: Robot) -> Made:
    """A hand that the file names and the robot does not carry."""
    mass = robot.rng.uniform(0.15, 0.3) * float(robot.arm.mass.sum())
    place = 0.08 * robot.file.reach * robot.rng.uniform(-1.0, 1.0, 3)
    hand = Link("hand", mass, place, 0.4 * mass * 0.05**2 * np.eye(3))
    file = replace(with_payload(robot.file, mass, place, hand.inertia_com), ends=(hand,))
    file = replace(file, links=(*file.links[:-1], replace(file.links[-1], bare=None)))
    numbers = parameters_of(file)[-1] - parameters_of(robot.file)[-1]
    truth = replace(_none(robot), taken_off=numbers)
    return robot.log(*robot.as_it_is), file, "payload", lambda found: "hand" in found.remedy, truth


FAULTS: dict[str, Fault] = {
    "all torques reversed": all_reversed, "a torque reversed": one_reversed, "a joint the other way": other_way,
    "torques in another unit": another_unit, "torques times a factor": any_factor, "currents": currents,
    "torques exchanged": torques_exchanged, "joints exchanged": joints_exchanged,
    "zero off by 90, 180": zero_of_quarter, "zero off": zero_of_any, "ceiling": ceiling, "tilt": tilted,
    "gravity compensated": compensated, "payload": payload_missing, "load put on": load_put_on,
    "joint coupled": coupled, "torques late": late, "time": slow_time,
    "time, with velocities": time_with_velocities, "joint coupled across": wrist_coupled,
    "zero of a slide": zero_of_slide, "hand left out": hand_left_out,
}  # fmt: skip


# Kinds of logs without a fault, most of them hard in one way: readings at 15 Hz, four seconds, joints at rest, a
# quarter of the range, torque noise of 15 %, three times the friction, velocity columns, torques in steps of 3 %.
_GOOD = (
    "plain", "plain", "15 Hz", "short", "resting joints", "slow", "noisy", "much friction", "velocities", "coarse",
)  # fmt: skip


def _good(file: RobotArm, seed: int) -> tuple[str, Trajectory]:
    """A log without a fault: plain, or hard in one way."""
    kind = _GOOD[seed % len(_GOOD)]
    rate, seconds = {"15 Hz": (15.0, 25.0), "short": (125.0, 4.0)}.get(kind, (125.0, 16.0))
    robot = Robot.of(file, 1000 + seed, seconds, rate, 0.25 if kind == "slow" else 0.9)
    if kind == "noisy":
        robot.noise = (1e-3, 0.15)
    if kind == "much friction":
        robot.friction[:, :2] *= 3.0
    if kind == "velocities":
        speed = 0.02 * np.abs(robot.states.qd).max(axis=0) * robot.rng.normal(size=robot.states.qd.shape)
        return kind, robot.log(*robot.as_it_is, robot.states.qd + speed)
    if kind == "coarse":
        time_, q, torque = robot.as_it_is
        step = 0.03 * np.abs(torque).max(axis=0)
        return kind, robot.log(time_, q, step * np.round(torque / step))
    if kind == "resting joints":
        rests = robot.rng.permutation(file.n_joints)[: file.n_joints // 2]
        q, qd, qdd = (x.copy() for x in robot.states.arrays)
        q[:, rests], qd[:, rests], qdd[:, rests] = q[0, rests], 0.0, 0.0
        robot.drives[rests] = 0.0
        robot.states = States(q, qd + 0.0, qdd)
        with np.errstate(invalid="ignore"):
            torque = np.nan_to_num(robot.torque())
        torque[:, rests] = torque_of(robot.arm, robot.states, drives=False)[:, rests]
        return kind, robot.log(robot.time, q, robot.noisy(torque))
    return kind, robot.log(*robot.as_it_is)


def tried(log: Trajectory, file: RobotArm) -> tuple[Diagnosis | None, float]:
    """Diagnose, and the processor's seconds."""
    start = time.process_time()
    try:
        found = diagnose(file, log)
    except gd.GdAnalyzeError:
        found = None
    return found, time.process_time() - start


@dataclass(frozen=True)
class Row:
    """What was said of one log."""

    arm: str
    kind: str
    answers: list[str]  # in order; "right" is true, and "invisible" comes first where a fault is
    seconds: float
    best: list[str]  # the causes ranked first, for a closer look

    @property
    def is_good(self) -> bool:
        """Whether the log has no fault."""
        return self.kind.startswith("good")


def _best(found: Diagnosis | None) -> list[str]:
    return [] if found is None else [f"{one.what} ({one.fall:.0f})" for one in found.ranking[:3]]


def trial_good(name: str, file: RobotArm, seed: int) -> Row | None:
    """A log without a fault."""
    kind, log = _good(file, seed)
    found, seconds = tried(log, file)
    claims = [] if found is None else [cause.name for cause in found.causes]
    return Row(name, f"good: {kind}", claims, seconds, _best(found))


def trial_bad(name: str, file: RobotArm, kind: str, seed: int) -> Row | None:
    """A log with a fault; None if the arm cannot have it, or the log cannot be read."""
    robot = Robot.of(file, seed)
    made = FAULTS[kind](robot)
    if made is None:
        return None
    log, arm, right, told, truth = made
    found, seconds = tried(log, arm)
    if found is None:
        return None
    answers = [*found.causes[:1], *found.rivals, *found.causes[1:]]
    score = None if truth is None else found.problem.score(truth)

    def is_right(one: Candidate) -> bool:
        # Numbers that score like the true ones are right as far as the log tells.
        alike = score is not None and found.problem.score(one.correction) < score + ALIKE
        return one.name == right and (told(one) or alike)

    names = ["right" if is_right(one) else one.name for one in answers]
    seen = found.before.score - score_without_fault(robot) if score is None else -score
    hidden = seen < VISIBLE
    return Row(name, kind, ["invisible", *names] if hidden else names, seconds, _best(found))


def trials(seeds: int, good: int, only: str, workers: int) -> Iterator[Row]:
    """All rows, in an order in which the first are like all."""
    tasks: list[Task] = []
    for at, name in enumerate(arms()):
        tasks += [("", name, seed + 7 * at) for seed in range(good if not only else 0)]
        for k, kind in enumerate(FAULTS):
            if only in kind:
                tasks += [(kind, name, 10_000 * at + 100 * k + seed) for seed in range(seeds)]
    order = [tasks[k] for k in np.random.default_rng(0).permutation(len(tasks)).tolist()]
    with ProcessPoolExecutor(workers) as executor:
        yield from (row for row in executor.map(_run, order) if row is not None)


Task = tuple[str, str, int]  # the fault, "" for none, the arm's name, and the seed


@cache
def _arms() -> dict[str, RobotArm]:
    return arms()


def _run(task: Task) -> Row | None:
    warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
    kind, name, seed = task
    file = _arms()[name]
    return trial_bad(name, file, kind, seed) if kind else trial_good(name, file, seed)


def score_without_fault(robot: Robot) -> float:
    """Score of file and friction on the log without the fault."""
    from gd_analyze.diagnosis.hypothesis import Problem
    from gd_analyze.diagnosis.samples import samples_of
    from gd_analyze.diagnosis.settings import SETTINGS

    log = robot.log(*robot.as_it_is)
    usable = np.ones(log.q.shape, dtype=bool)
    problem = Problem(
        samples_of(robot.file, [log], [usable], SETTINGS), Correction.none(log.n_joints), SETTINGS
    )
    return problem.null.score


def page(rows: list[Row]) -> str:
    """Figures and the confusion matrix."""
    good = [row for row in rows if row.is_good]
    bad = [row for row in rows if not row.is_good]
    seen = [row for row in bad if row.answers[:1] != ["invisible"]]
    first = sum(row.answers[:1] == ["right"] for row in seen)
    two = sum("right" in row.answers[:2] for row in seen)
    hidden = [row for row in bad if row.answers[:1] == ["invisible"]]
    wrong_hidden = sum(len(row.answers) > 1 and row.answers[1] != "right" for row in hidden)
    false = [row for row in good if row.answers]
    names = ", ".join(dict.fromkeys(row.arm for row in rows))
    text = HEAD.format(good=len(good), bad=len(bad), arms=names)
    text += f"- True cause first: {first} of {len(seen)} visible ({100 * first / max(len(seen), 1):.1f} %).\n"
    text += f"- True cause among the first two: {two} ({100 * two / max(len(seen), 1):.1f} %).\n"
    text += f"- False alarms: {len(false)} of {len(good)} logs without a fault ({100 * len(false) / max(len(good), 1):.1f} %)"
    text += "".join(f"; {row.arm}, {row.kind[6:]}: {row.answers[0]}" for row in false) + ".\n"
    text += f"- Of {len(hidden)} logs with an invisible fault {wrong_hidden} got another cause.\n"
    seconds = np.array([row.seconds for row in rows])
    text += (
        f"- Processor time: median {np.median(seconds):.1f} s a log; in all {seconds.sum() / 60:.0f} min.\n\n"
    )
    table: dict[str, Counter[str]] = defaultdict(Counter)
    for kind in [*FAULTS, *(f"good: {kind}" for kind in dict.fromkeys(_GOOD))]:
        for row in (row for row in [*seen, *good] if row.kind == kind):
            table[kind][row.answers[0] if row.answers else "none"] += 1
    columns = ["right", "none", *sorted({name for row in table.values() for name in row} - {"right", "none"})]
    lines = [
        ["log", *columns],
        *([kind, *(str(row[name] or "") for name in columns)] for kind, row in table.items()),
    ]
    widths = [max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    shown = [
        "| " + " | ".join(cell.ljust(w) for cell, w in zip(line, widths, strict=True)) + " |"
        for line in lines
    ]
    shown.insert(1, "|" + "|".join("-" * (w + 2) for w in widths) + "|")
    return f"{text}First answer by kind of log; visible faults only.\n\n" + "\n".join(shown) + "\n"


def main() -> None:
    """Run the trial and write the page."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--good", type=int, default=43)
    parser.add_argument("--only", default="")
    parser.add_argument("--most", type=int, default=10**9, help="logs after which to stop")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--dry", action="store_true", help="write no page")
    given = parser.parse_args()
    rows = []
    for row in trials(given.seeds, given.good, given.only, given.workers):
        rows.append(row)
        if row.answers if row.is_good else row.answers[:1] not in (["right"], ["invisible"]):
            print(row, file=sys.stderr, flush=True)
        if len(rows) >= given.most:
            break
    text = page(rows)
    if not given.dry:
        write_text(HERE, text)
    print(text)


if __name__ == "__main__":
    main()
