"""Many closed loops at once: each controller, rate and speed is a column, and all step together.

Torque is held over a loop period, which is cut into steps of classical Runge-Kutta (fourth order) no longer
than `longest_step_seconds`; a continuous loop evaluates its controller at every stage. The work of the
torque and the energy that friction dissipates are integrated along with the motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.kinematics import kinetic_energy, potential_energy
from gd_analyze.errors import UsageError
from gd_analyze.operations.program import Batch, Program
from gd_analyze.studies.control_law import CONTINUOUS, Bank, Controller, World


@dataclass(frozen=True, kw_only=True)
class _LoopSettings:
    """Steps of the simulated loops, and when one is lost."""

    # About a hundredth of the settling time of a loop with a bandwidth of 5 Hz.
    longest_step_seconds: float = 2e-3
    most_steps: int = 300_000  # largest number of steps: some minutes
    history_samples: int = 6_000  # samples of a history, about
    steps_per_block: int = 128  # steps whose desired states are evaluated together
    # Tracking error at which a loop counts as lost: a turn, or this many metres.
    lost_error: float = 2.0 * math.pi


_SETTINGS = _LoopSettings()


class ProgramDynamics:
    """D and h + c of m states from a program of the torque D qdd + h + c of n joints.

    Torque without acceleration is h + c; unit acceleration of a joint adds a column of D.
    """

    def __init__(self, program: Program, n_joints: int, count: int) -> None:
        self._shape = shape = (n_joints + 1, count)
        self._batch = Batch(program, shape[0] * count)
        self._q, self._qd = (self._batch.rows(name, n_joints, *shape) for name in ("q", "qd"))
        for i, row in self._batch.rows("qdd", n_joints, *shape):
            row[:] = 0.0
            row[i + 1] = 1.0

    def at(self, q: FloatArray, qd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return D, shape (m, n, n), and h + c, shape (n, m), at states (n, m)."""
        for rows, values in ((self._q, q), (self._qd, qd)):
            for i, row in rows:
                row[:] = values[i]
        torque = self._batch.run().reshape(len(q), *self._shape)
        bias = torque[:, 0]
        return np.moveaxis(torque[:, 1:] - bias[:, None], -1, 0), bias


class Loop(NamedTuple):
    """One closed loop: a controller, its rate, Hz, and the speed as a multiple of the planned one."""

    controller: Controller
    rate: float
    speed: float


@dataclass(frozen=True, eq=False)
class TrackedLoop:
    """Result of one loop; n joints, SI units."""

    controller: Controller
    rate: float  # Hz
    speed: float  # times as fast as planned
    peak_error: FloatArray  # of tracking, rad (m), infinite where the loop lost the motion, (n,)
    rms_error: FloatArray
    peak_torque: FloatArray  # N m (N), (n,)
    rms_torque: FloatArray
    saturated: FloatArray  # share of the time with the commanded torque beyond its limit, (n,)
    lost_at: float | None  # when the error passed a turn (6.28 m), s
    work: float  # of the torque, J
    dissipated: float  # by friction, J
    energy_residual: float  # energy gained less work plus dissipation, J: zero up to integration errors
    end: FloatArray  # q and qd at the end, (2, n)
    time: FloatArray  # of the history, s, (K,)
    error: FloatArray  # signed, nan where lost, (K, n)

    def within(self, tolerance: FloatArray) -> bool:
        """Whether every joint stays within a tolerance (n,)."""
        return bool((self.peak_error <= tolerance).all())


def follow(
    world: World, loops: Sequence[Loop], progress: Callable[[int], None] = lambda percent: None
) -> tuple[TrackedLoop, ...]:
    """Simulate loops that begin on the motion, at its velocity.

    `progress` is called with the hundredths of all steps done since the last call. A loop of too many steps
    raises a `UsageError`.
    """
    timings = [_timing(loop, world.reference.duration) for loop in loops]
    # Loops that run longer come first.
    order = sorted(range(len(loops)), key=lambda k: -timings[k][2])
    run = _Run(world, [loops[k] for k in order], [timings[k] for k in order])
    begin, reported, largest_count = 0, 0, int(run.count.max())
    for end in np.unique(run.count).tolist():
        run.keep(int((run.count >= end).sum()))
        for first in range(begin, end, _SETTINGS.steps_per_block):
            last = min(first + _SETTINGS.steps_per_block, end)
            run.advance(first, last)
            progress(100 * last // largest_count - reported)
            reported = 100 * last // largest_count
        begin = end
    return tuple(run.tracked(j) for j in np.argsort(order))


def _timing(loop: Loop, duration: float) -> tuple[int, float, int]:
    """Steps per period, length of a step, s, and number of steps.

    The last period ends with the motion or, where the rate does not fit it, less than a period before.
    """
    run_time = duration / loop.speed
    if loop.rate == CONTINUOUS:
        steps_per_period, count = 1, max(1, math.ceil(run_time / _SETTINGS.longest_step_seconds - 1e-9))
        length = run_time / count
    else:
        steps_per_period = math.ceil(1.0 / (loop.rate * _SETTINGS.longest_step_seconds) - 1e-9)
        length = 1.0 / (loop.rate * steps_per_period)
        count = max(1, math.floor(run_time * loop.rate + 1e-9)) * steps_per_period
    if count > _SETTINGS.most_steps:
        rate = "" if loop.rate == CONTINUOUS else f", {loop.rate:g} Hz"
        raise UsageError(
            "the motion takes too many steps to be simulated",
            where=f"{loop.speed:g} times its speed{rate}",
            expected=f"{_SETTINGS.most_steps} at most",
            found=f"{count}: {run_time:.4g} s",
            next_step="give a part of the motion, a lower rate or a higher speed",
        )
    return steps_per_period, length, count


def accelerations(inertia: FloatArray, torque: FloatArray) -> FloatArray:
    """Solve D qdd = torque of m loops, (m, n); nan where D is singular, as where a state overflows."""
    try:
        return np.asarray(np.linalg.solve(inertia, torque[..., None])[..., 0])
    except np.linalg.LinAlgError:
        if len(torque) == 1:
            return np.full_like(torque, np.nan)
        systems = zip(inertia, torque, strict=True)
        return np.concatenate([accelerations(matrix[None], row[None]) for matrix, row in systems])


class _Run:
    """All m running loops, those with most steps first; the first ones continue when others have ended."""

    def __init__(
        self, world: World, loops: Sequence[Loop], timings: Sequence[tuple[int, float, int]]
    ) -> None:
        self.world, self.loops = world, loops
        self.per, self.length, self.count = (np.array(column) for column in zip(*timings, strict=True))
        self.speed = np.array([loop.speed for loop in loops])
        self.continuous = np.array([loop.rate == CONTINUOUS for loop in loops])
        self.limits = world.limits[:, None]
        self.n, m = world.plant.arm.n_joints, len(loops)
        q, qd, _ = world.reference.at(np.zeros(m), self.speed)
        # q, qd, and behind them work and dissipated energy: (2 n + 2, m).
        self.state = np.concatenate([q, qd, np.zeros((2, m))])
        self.start = self.state.copy()
        self.torque_held, self.at_limit = np.zeros((2, self.n, m))
        self.peak, self.square, self.torque_peak, self.torque_square, self.share = np.zeros((5, self.n, m))
        self.lost_at = np.full(m, np.inf)
        self.stride = -(-int(self.count[0]) // _SETTINGS.history_samples)
        samples = int(self.count[0]) // self.stride + 1
        self.history = np.zeros((samples, self.n, m), dtype=np.float32)

    def keep(self, m: int) -> None:
        """Continue with the first m loops only."""
        self.m = m
        self.bank = Bank([loop.controller for loop in self.loops[:m]], self.world)
        self.dynamics = ProgramDynamics(self.world.plant.program, self.n, m)
        self.any_continuous = bool(self.continuous[:m].any())

    def advance(self, begin: int, end: int) -> None:
        """Run from one step to another."""
        # Desired states at the ends and middles of the steps.
        times = np.arange(2 * begin, 2 * end + 1)[:, None] * (0.5 * self.length[: self.m])
        ahead = self.world.reference.at(times, self.speed[: self.m])
        with np.errstate(all="ignore"):  # a loop that is lost may overflow
            for k in range(begin, end):
                at = 2 * (k - begin)
                self._take(k, [tuple(x[:, at + half] for x in ahead) for half in range(3)])

    def _take(self, k: int, desired: Sequence[tuple[FloatArray, ...]]) -> None:
        """Take step k, with the desired states at its beginning, middle and end."""
        m, n, h = self.m, self.n, self.length[: self.m]
        state, torque_held, lost_at = self.state[:, :m], self.torque_held[:, :m], self.lost_at[:m]
        starts_period = k % self.per[:m] == 0
        if starts_period.any():
            torque = self._commanded(state, desired[0])
            np.copyto(torque_held, np.clip(torque, -self.limits, self.limits), where=starts_period)
            np.copyto(self.at_limit[:, :m], np.abs(torque) > self.limits, where=starts_period)
        first = self._slope(state, torque_held)
        middle = state + 0.5 * h * first
        second = self._slope(middle, self._now(torque_held, middle, desired[1]))
        middle = state + 0.5 * h * second
        third = self._slope(middle, self._now(torque_held, middle, desired[1]))
        end = state + h * third
        fourth = self._slope(end, self._now(torque_held, end, desired[2]))
        next_state = state + h / 6.0 * (first + 2.0 * (second + third) + fourth)
        error = desired[2][0] - next_state[:n]
        runs = lost_at == np.inf
        is_near = (np.abs(error) < _SETTINGS.lost_error).all(axis=0)
        lost = runs & ~(is_near & np.isfinite(next_state).all(axis=0))
        lost_at[lost] = (k + 1) * h[lost]
        runs &= ~lost
        np.copyto(state, next_state, where=runs)
        error_size, torque_size = np.where(runs, np.abs(error), 0.0), np.where(runs, np.abs(torque_held), 0.0)
        np.maximum(self.peak[:, :m], error_size, out=self.peak[:, :m])
        np.maximum(self.torque_peak[:, :m], torque_size, out=self.torque_peak[:, :m])
        self.square[:, :m] += error_size**2
        self.torque_square[:, :m] += torque_size**2
        self.share[:, :m] += self.at_limit[:, :m]
        if (k + 1) % self.stride == 0:
            self.history[(k + 1) // self.stride, :, :m] = np.where(runs, error, np.nan)

    def _commanded(self, state: FloatArray, desired: Sequence[FloatArray]) -> FloatArray:
        return self.bank.torque(state[: self.n], state[self.n : 2 * self.n], desired)

    def _now(self, torque_held: FloatArray, state: FloatArray, desired: Sequence[FloatArray]) -> FloatArray:
        """Torque at a stage within a step; in a continuous loop it follows the state."""
        if not self.any_continuous:
            return torque_held
        torque = np.clip(self._commanded(state, desired), -self.limits, self.limits)
        return np.where(self.continuous[: self.m], torque, torque_held)

    def _slope(self, state: FloatArray, torque: FloatArray) -> FloatArray:
        n = self.n
        q, qd = state[:n], state[n : 2 * n]
        resistance = self.world.resistance(qd.T).T
        inertia, bias = self.dynamics.at(q, qd)
        solved = accelerations(inertia, (torque - resistance - bias).T)
        energies = [(torque * qd).sum(axis=0), (resistance * qd).sum(axis=0)]
        return np.concatenate([qd, solved.T, energies])

    def tracked(self, j: int) -> TrackedLoop:
        """Result of one loop."""
        lost, count, end = np.isfinite(self.lost_at[j]), int(self.count[j]), self.state[:, j]
        samples, form = count // self.stride + 1, self.world.plant
        work, dissipated = end[-2:].tolist()
        q, qd = np.stack([self.start[:-2, j], end[:-2]]).reshape(2, 2, -1).swapaxes(0, 1)
        energy = kinetic_energy(form.arm, q, qd, drives=form.drives) + potential_energy(form.arm, q)
        return TrackedLoop(
            *self.loops[j],
            peak_error=np.full(self.n, np.inf) if lost else self.peak[:, j],
            rms_error=np.full(self.n, np.inf) if lost else np.sqrt(self.square[:, j] / count),
            peak_torque=self.torque_peak[:, j],
            rms_torque=np.sqrt(self.torque_square[:, j] / count),
            saturated=self.share[:, j] / count,
            lost_at=float(self.lost_at[j]) if lost else None,
            work=work,
            dissipated=dissipated,
            energy_residual=float(energy[1] - energy[0] - work + dissipated),
            end=end[: 2 * self.n].reshape(2, -1),
            time=np.arange(samples) * (self.stride * self.length[j]),
            error=self.history[:samples, :, j].astype(float),
        )
