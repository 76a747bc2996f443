"""Logs of robots that differ from their files, with a fault whose truth is known, and without one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

import gd_analyze as gd
from gd_analyze.arrays import FloatArray
from gd_analyze.diagnosis.hypothesis import Candidate, signs, swapped
from gd_analyze.diagnosis.trial import Trial
from gd_analyze.dynamics.base_parameters import parameters_of
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.motions.states import States
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import arm_in
from gd_analyze.tables import with_payload
from gd_analyze.types import Link, Log
from logs_of_arms import fourier
from published_arms import arm_of

# Tolerances of numbers told: torque factors, angles (rad), lag (s), pace.
NEAR_FACTOR, NEAR_ANGLE, NEAR_LAG, NEAR_PACE = 0.35, np.radians(12.0), 0.01, 0.15

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
        "format": "gd-analyze arm 1", "name": "ur_like", "convention": "standard",
        "joints": joints, "links": links, "gravity": [0.0, 0.0, -9.81],
    }  # fmt: skip
    return arm_in(document)


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
    one = arm_in(document)
    return replace(
        one, joints=(*one.joints, *whole.joints[:3]), links=(*one.links, *whole.links[:3]), dh_table=()
    )


def arms() -> dict[str, RobotArm]:
    """The arms by name."""
    return {
        "UR-like": ur_like(), "PUMA 560": gd.load_arm("puma560"), "Stanford arm": gd.load_arm("stanford"),
        "SCARA": gd.load_arm("scara"), "KR6": arm_of("KR6"), "LBR7": arm_of("LBR7"), "rail with arm": rail(),
    }  # fmt: skip


def motion_of(
    file: RobotArm, seconds: float, rate: float, seed: int, share: float
) -> tuple[FloatArray, States]:
    """Instants and states of a random Fourier series, of a share of what the limits allow."""
    instants, states = fourier(file, seconds, rate, seed)
    middle = states.q.mean(axis=0)
    return instants, States(middle + share * (states.q - middle), share * states.qd, share * states.qdd)


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
        instants, states = motion_of(file, seconds, rate, seed, share)
        rigid = torque_of(arm, states, drives=False)
        size = np.sqrt((rigid**2).mean(axis=0)) + 0.05 * np.sqrt((rigid**2).mean())
        fast = np.abs(states.qd).max(axis=0)
        pull = np.sqrt((states.qdd**2).mean(axis=0)) + 1e-9
        friction = np.column_stack([
            rng.uniform(0.05, 0.3, n) * size, rng.uniform(0.05, 0.3, n) * size / fast,
            rng.uniform(0.0, 0.08, n) * size, rng.uniform(0.0, 0.05, n), 0.05 * rng.normal(size=n) * size,
        ])  # fmt: skip
        return cls(arm, file, instants, states, friction, rng.uniform(0.0, 0.4, n) * size / pull, rng)

    def along(self, seed: int, seconds: float = 16.0, rate: float = 125.0, share: float = 0.9) -> Robot:
        """The same robot along another motion."""
        instants, states = motion_of(self.file, seconds, rate, seed, share)
        return replace(self, time=instants, states=states, friction=self.friction.copy())

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
Made = tuple[Trajectory, RobotArm, str, Told, Trial | None]
Fault = Callable[[Robot], Made | None]


def _same(truth: Trial) -> Told:
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


def log_of(robot: Robot, name: str, truth: Trial) -> Made:
    """A log that a correction would mend."""
    time_, q, torque = robot.as_it_is
    q = (q - truth.offset) @ np.linalg.inv(truth.position).T
    torque = torque @ np.linalg.inv(truth.torque).T
    return robot.log(time_ / truth.pace, q, torque), robot.file, name, _same(truth), truth


def no_correction(robot: Robot) -> Trial:
    return Trial.none(robot.file.n_joints)


def _joint(robot: Robot) -> int:
    return int(robot.rng.integers(robot.file.n_joints))


def _turning(robot: Robot) -> int:
    return int(robot.rng.choice(np.flatnonzero(robot.file.is_revolute)))


def all_reversed(robot: Robot) -> Made:
    """All torques reversed."""
    n = robot.file.n_joints
    return log_of(robot, "torque sign", no_correction(robot).with_torque(-np.eye(n)))


def one_reversed(robot: Robot) -> Made:
    """The torque of one joint reversed."""
    n = robot.file.n_joints
    return log_of(robot, "torque sign", no_correction(robot).with_torque(signs(n, [_joint(robot)])))


def other_way(robot: Robot) -> Made:
    """A joint that counts the other way."""
    turned = signs(robot.file.n_joints, [_joint(robot)])
    return log_of(robot, "direction of a joint", no_correction(robot).with_joints(turned))


def another_unit(robot: Robot) -> Made:
    """Torques in another unit."""
    factor = robot.rng.choice([1e-3, 9.80665, 1e-2, 1.0 / 9.80665])
    return log_of(
        robot, "torque scale", no_correction(robot).with_torque(factor * np.eye(robot.file.n_joints))
    )


def any_factor(robot: Robot) -> Made:
    """Torques times a factor that is no unit."""
    factor = robot.rng.choice([2.2, 3.5, 0.3, 25.0])
    return log_of(
        robot, "torque scale", no_correction(robot).with_torque(factor * np.eye(robot.file.n_joints))
    )


def currents(robot: Robot) -> Made:
    """Currents in place of torques."""
    factors = np.exp(robot.rng.normal(np.log(20.0), 0.5, robot.file.n_joints))
    return log_of(robot, "torque scale by joint", no_correction(robot).with_torque(np.diag(factors)))


def torques_exchanged(robot: Robot) -> Made:
    """Two torque columns exchanged."""
    n = robot.file.n_joints
    i, j = robot.rng.choice(n, 2, replace=False)
    return log_of(robot, "order of torques", no_correction(robot).with_torque(swapped(n, int(i), int(j))))


def joints_exchanged(robot: Robot) -> Made | None:
    """Two joints exchanged."""
    n, turns = robot.file.n_joints, np.flatnonzero(robot.file.is_revolute)
    i, j = robot.rng.choice(turns, 2, replace=False)
    order = swapped(n, int(i), int(j))
    return log_of(robot, "order of joints", no_correction(robot).with_joints(order))


def zero_of_quarter(robot: Robot) -> Made:
    """A zero off by 90 or 180 degrees."""
    angle = robot.rng.choice([0.5 * np.pi, -0.5 * np.pi, np.pi])
    return log_of(robot, "zero of a joint", no_correction(robot).with_offset(_turning(robot), float(angle)))


def zero_of_any(robot: Robot) -> Made:
    """A zero off by 20 to 160 degrees."""
    angle = np.radians(robot.rng.uniform(20.0, 160.0)) * robot.rng.choice([-1.0, 1.0])
    return log_of(robot, "zero of a joint", no_correction(robot).with_offset(_turning(robot), float(angle)))


def _mounted(robot: Robot, gravity: FloatArray) -> Made:
    torque = robot.noisy(robot.torque(replace(robot.arm, gravity_vector=gravity)))
    log = robot.log(robot.time, robot.states.q, torque)

    def told(found: Candidate) -> bool:
        own = found.correction.gravity
        if own is None:
            return False
        if not gravity.any() or not own.any():
            return bool(gravity.any() == own.any())
        cosine = own @ gravity / np.linalg.norm(own) / np.linalg.norm(gravity)
        return bool(np.arccos(np.clip(cosine, -1.0, 1.0)) < NEAR_ANGLE)

    return log, robot.file, "gravity", told, replace(no_correction(robot), gravity=gravity)


def ceiling(robot: Robot) -> Made:
    """An arm that hangs."""
    return _mounted(robot, -robot.file.gravity_vector)


def tilted(robot: Robot) -> Made:
    """An arm tilted by 25 to 90 degrees."""
    down = robot.file.gravity_vector / np.linalg.norm(robot.file.gravity_vector)
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
    return log_of(robot, "coupled joints", no_correction(robot).with_joints(matrix))


def late(robot: Robot) -> Made:
    """Torques that are late or early."""
    lag = float(robot.rng.choice([0.03, 0.06, -0.05]))
    time_, q, torque = robot.as_it_is
    moved = np.column_stack([np.interp(time_ - lag, time_, column) for column in torque.T])
    inside = (time_ > 0.1) & (time_ < time_[-1] - 0.1)
    log = robot.log(time_[inside], q[inside], moved[inside])
    truth = replace(no_correction(robot), lag=lag)
    return log, robot.file, "lag of torque", _same(truth), truth


def slow_time(robot: Robot) -> Made:
    """Time in another unit."""
    pace = float(robot.rng.choice([0.5, 2.0, 0.1]))
    return log_of(robot, "unit of time", replace(no_correction(robot), pace=pace))


def time_with_velocities(robot: Robot) -> Made:
    """Time in another unit in a log with velocities."""
    pace = float(robot.rng.choice([0.4, 3.0, 0.02]))
    time_, q, torque = robot.as_it_is
    truth = replace(no_correction(robot), pace=pace)
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
    return log_of(robot, "coupled joints", no_correction(robot).with_joints(matrix))


def zero_of_slide(robot: Robot) -> Made | None:
    """The zero of a prismatic joint; None for an arm without one."""
    slides = np.flatnonzero(~np.array(robot.file.is_revolute))
    if not len(slides):
        return None
    length = float(robot.rng.uniform(0.15, 0.5) * robot.rng.choice([-1.0, 1.0]))
    return log_of(
        robot, "zero of a joint", no_correction(robot).with_offset(int(robot.rng.choice(slides)), length)
    )


def hand_left_out(robot: Robot) -> Made:
    """A hand that the file names and the robot does not carry."""
    mass = robot.rng.uniform(0.15, 0.3) * float(robot.arm.mass.sum())
    place = 0.08 * robot.file.reach * robot.rng.uniform(-1.0, 1.0, 3)
    hand = Link("hand", mass, place, 0.4 * mass * 0.05**2 * np.eye(3))
    file = replace(with_payload(robot.file, mass, place, hand.inertia_com), ends=(hand,))
    file = replace(file, links=(*file.links[:-1], replace(file.links[-1], bare=None)))
    numbers = parameters_of(file)[-1] - parameters_of(robot.file)[-1]
    truth = replace(no_correction(robot), taken_off=numbers)
    return robot.log(*robot.as_it_is), file, "payload", lambda found: "hand" in str(found.remedy), truth


FAULTS: dict[str, Fault] = {
    "all torques reversed": all_reversed, "a torque reversed": one_reversed,
    "a joint the other way": other_way,
    "torques in another unit": another_unit, "torques times a factor": any_factor, "currents": currents,
    "torques exchanged": torques_exchanged, "joints exchanged": joints_exchanged,
    "zero off by 90, 180": zero_of_quarter, "zero off": zero_of_any, "ceiling": ceiling, "tilt": tilted,
    "gravity compensated": compensated, "payload": payload_missing, "load put on": load_put_on,
    "joint coupled": coupled, "torques late": late, "time": slow_time,
    "time, with velocities": time_with_velocities, "joint coupled across": wrist_coupled,
    "zero of a slide": zero_of_slide, "hand left out": hand_left_out,
}  # fmt: skip


# Kinds of logs without a fault, most of them hard in one way: readings at 15 Hz, four seconds, joints at
# rest, a quarter of the range, torque noise of 15 %, three times the friction, velocity columns, torques in
# steps of 3 %.
GOOD_KINDS = (
    "plain", "plain", "15 Hz", "short", "resting joints", "slow", "noisy", "much friction", "velocities",
    "coarse",
)  # fmt: skip


def good_log(file: RobotArm, seed: int) -> tuple[str, Trajectory]:
    """A log without a fault: plain, or hard in one way."""
    kind = GOOD_KINDS[seed % len(GOOD_KINDS)]
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


def loads(robot: Robot, masses: Sequence[float], seed: int = 0) -> list[Trajectory]:
    """Logs of one robot along motions of their own, which carries a mass in each."""
    out = []
    for k, mass in enumerate(masses):
        moved = robot.along(100 * seed + k, seconds=10.0)
        arm = with_payload(robot.arm, mass, np.array([0.02, 0.03, 0.05])) if mass else robot.arm
        log = moved.log(moved.time, moved.states.q, moved.noisy(moved.torque(arm)))
        out.append(replace(log, name=f"log-{k + 1}"))
    return out
