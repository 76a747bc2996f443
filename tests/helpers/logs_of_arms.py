"""Logs of arms whose numbers are known: exciting motions, torques with friction and drives, and noise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.base_parameters import parameters_of
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.identification.identified_arm import base_matrix
from gd_analyze.motions.states import States
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.limits import box_limits
from gd_analyze.types import Log, Recording

HARMONICS = 5


def fourier(arm: RobotArm, seconds: float, rate: float, seed: int) -> tuple[FloatArray, States]:
    """Instants and states of a random Fourier series, as large as the arm's limits allow."""
    limits, rng, n = box_limits(arm), np.random.default_rng(seed), arm.n_joints
    time = np.arange(int(seconds * rate)) / rate
    omega = 2.0 * np.pi / seconds * np.arange(1, HARMONICS + 1)
    a, b = rng.normal(size=(2, n, HARMONICS))
    cos, sin = np.cos(np.outer(omega, time)), np.sin(np.outer(omega, time))
    q = a @ cos + b @ sin
    qd = (b * omega) @ cos - (a * omega) @ sin
    qdd = -(a * omega**2) @ cos - (b * omega**2) @ sin
    fast, pull = np.abs(qd).max(axis=1), np.abs(qdd).max(axis=1)
    room = (limits.upper - limits.lower) / np.ptp(q, axis=1)
    scale = 0.9 * np.minimum.reduce([room, limits.velocity / fast, limits.acceleration / pull])
    middle = (limits.upper + limits.lower) / 2.0 - scale * (q.max(axis=1) + q.min(axis=1)) / 2.0
    return time, States(
        (scale[:, None] * q + middle[:, None]).T, *((scale[:, None] * x).T for x in (qd, qdd))
    )


@dataclass(frozen=True)
class TrueArm:
    """An arm, and what a file does not say of it."""

    arm: RobotArm
    drives: FloatArray  # inertia at the joints, (n,)
    friction: FloatArray  # Coulomb, viscous, offset, (n, 3)

    @classmethod
    def near(cls, arm: RobotArm, seed: int) -> TrueArm:
        """Draw one whose links differ from a file's by some 20 % and 20 mm."""
        rng, n = np.random.default_rng(seed), arm.n_joints
        links = []
        for link in arm.links:
            heavier, wider = 1.0 + 0.2 * rng.uniform(-1.0, 1.0, 2)
            com = link.com + 0.02 * rng.normal(size=3)
            links.append(
                replace(
                    link, mass=heavier * link.mass, com=com, inertia_com=heavier * wider * link.inertia_com
                )
            )
        falling = np.linspace(2.0, 0.3, n)
        friction = np.column_stack([rng.uniform(*ends, n) for ends in ((0.5, 1.5), (0.5, 2.0), (-0.2, 0.2))])
        return cls(
            replace(arm, links=tuple(links), drives=()),
            falling * rng.uniform(0.1, 1.0, n),
            2.0 * falling[:, None] * friction,
        )

    @property
    def base(self) -> FloatArray:
        """Its base parameters, drives included."""
        return base_matrix(self.arm)[1] @ np.concatenate([parameters_of(self.arm).ravel(), self.drives])

    def torque(self, states: States) -> FloatArray:
        """What its joints need, friction included, (N, n)."""
        rigid = torque_of(self.arm, states, drives=False) + self.drives * states.qdd
        coulomb, viscous, offset = self.friction.T
        return rigid + coulomb * np.sign(states.qd) + viscous * states.qd + offset

    def log(
        self, time: FloatArray, states: States, noise: tuple[float, float] = (1e-4, 0.01), seed: int = 0
    ) -> Trajectory:
        """Its readings: noise of positions, rad (m), and of torques, as a share of each joint's RMS."""
        rng, torque = np.random.default_rng(seed), self.torque(states)
        q = states.q + noise[0] * rng.normal(size=torque.shape)
        torque = torque + noise[1] * np.sqrt((torque**2).mean(axis=0)) * rng.normal(size=torque.shape)
        return Trajectory.from_log(Log(time, q, None, None, torque, measured=True), self.arm)

    def exact_log(self, time: FloatArray, states: States, name: str = "log") -> Trajectory:
        """Its motion and torques as they are: nothing is smoothed."""
        torque, still = self.torque(states), np.zeros(self.arm.n_joints)
        recording = Recording(states.q, torque, torque, None, still, still)
        return Trajectory(time, *states.arrays, name=name, recording=recording)


def with_torque(log: Trajectory, torque: FloatArray) -> Trajectory:
    """The same readings with other torques, (N, n), as measured and as filtered."""
    assert log.recording is not None
    return replace(log, recording=replace(log.recording, torque=torque, torque_filtered=torque))
