"""Many closed loops at once: every controller, rate and speed is a column, and all take their steps together.

Torque is held over a loop period, which is cut into steps of classical Runge-Kutta (fourth order) no longer
than `LONGEST_STEP`; a loop without a period asks its controller at every stage. The work of the torque and
the energy that friction dissipates are integrated along with the motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import UsageError
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.studies.control_law import CONTINUOUS, Bank, Controller, Gains, Knowledge
from gd_analyze.studies.control_plant import Plant, Reference

LONGEST_STEP = 2e-3
"""Of an integration, s: some hundredth of what a loop of a bandwidth of 5 Hz takes to settle."""

# Steps one after the other, some minutes; what a history keeps; for how many steps wanted states are made.
_MOST_STEPS, _KEPT, _AHEAD = 300_000, 6_000, 128
# Tracking error at which a loop counts as lost: a turn, or so many metres.
_LOST = 2.0 * math.pi


class Loop(NamedTuple):
    """One closed loop: a controller, its rate, Hz, and how many times as fast as planned the motion is."""

    controller: Controller
    rate: float
    speed: float


@dataclass(frozen=True, eq=False)
class Course:
    """How loops went, m of them; n joints.

    Parameters
    ----------
    peak_error, squared_error
        Largest tracking error, rad (m), and mean of its square, shape (n, m).
    peak_torque, squared_torque, saturated
        The same of torque, N m (N), and the share of time for which it was at its limit, shape (n, m).
    start, end
        q and qd at both ends, shape (2, n, m).
    work, dissipated
        By the torque and by friction, J, shape (m,).
    lost_at
        When a loop lost the motion, s; infinite where it did not, shape (m,).
    histories
        Of each loop times, s, shape (K,), and signed errors, shape (K, n).
    """

    peak_error: FloatArray
    squared_error: FloatArray
    peak_torque: FloatArray
    squared_torque: FloatArray
    saturated: FloatArray
    start: FloatArray
    end: FloatArray
    work: FloatArray
    dissipated: FloatArray
    lost_at: FloatArray
    histories: tuple[tuple[FloatArray, FloatArray], ...]


@dataclass(frozen=True, eq=False)
class World:
    """What all loops share: the arm, what controllers know of it, gains, motion and torque limits (n,)."""

    plant: ExactForm
    knowledge: Knowledge
    gains: Gains
    reference: Reference
    limits: FloatArray
    friction: bool = False


def steps_of(loops: Sequence[Loop], duration: float) -> tuple[NDArray[np.intp], FloatArray, NDArray[np.intp]]:
    """Steps per period, their lengths, s, and how many there are, of every loop, shape (m,).

    The last period ends with the motion or, where the rate does not fit it, less than a period before.

    Raises
    ------
    UsageError
        If that is too many.
    """
    per, length, count = [], [], []
    for loop in loops:
        whole = duration / loop.speed
        if loop.rate == CONTINUOUS:
            steps = max(1, math.ceil(whole / LONGEST_STEP - 1e-9))
            per.append(1)
            length.append(whole / steps)
        else:
            per.append(math.ceil(1.0 / (loop.rate * LONGEST_STEP) - 1e-9))
            length.append(1.0 / (loop.rate * per[-1]))
            steps = max(1, math.floor(whole * loop.rate + 1e-9)) * per[-1]
        count.append(steps)
        if steps > _MOST_STEPS:
            raise UsageError(
                "the motion takes too many steps to be simulated",
                where=f"{loop.speed:g} times its speed"
                + ("" if loop.rate == CONTINUOUS else f", {loop.rate:g} Hz"),
                expected=f"{_MOST_STEPS} at most",
                found=f"{steps}: {whole:.4g} s",
                next_step="give a part of the motion, a lower rate or a higher speed",
            )
    return np.array(per), np.array(length), np.array(count)


def follow(
    world: World, loops: Sequence[Loop], progress: Callable[[int], None] = lambda percent: None
) -> Course:
    """Simulate loops that begin on the motion, at its velocity.

    Parameters
    ----------
    world, loops
        What is simulated.
    progress
        Called with the hundredths of all steps that are done since it was called last.
    """
    _, _, count = steps_of(loops, world.reference.duration)
    order = np.argsort(-count, kind="stable")
    run = _Run(world, [loops[k] for k in order])
    begin, reported, most = 0, 0, int(count.max())
    for end in sorted(set(count.tolist())):
        for first in range(begin, end, _AHEAD):
            last = min(first + _AHEAD, end)
            run.advance(first, last, int((count >= end).sum()))
            progress(100 * last // most - reported)
            reported = 100 * last // most
        begin = end
    return run.course(np.argsort(order))


class _Run:
    """All loops on their way, those with most steps first: those that still go on come before the others."""

    def __init__(self, world: World, loops: Sequence[Loop]) -> None:
        self.world, self.loops = world, loops
        self.per, self.length, self.count = steps_of(loops, world.reference.duration)
        self.speed = np.array([loop.speed for loop in loops])
        self.continuous = np.array([loop.rate == CONTINUOUS for loop in loops])
        n, m = world.plant.arm.n_joints, len(loops)
        # q, qd, and behind them work and dissipated energy: (2 n + 2, m).
        self.state = np.zeros((2 * n + 2, m))
        q, qd, _ = world.reference.at(np.zeros(m), self.speed)
        self.state[:n], self.state[n : 2 * n] = q, qd
        self.start = self.state[: 2 * n].copy()
        self.held, self.at_limit = np.zeros((n, m)), np.zeros((n, m))
        self.peak, self.square, self.torque_peak, self.torque_square, self.share = np.zeros((5, n, m))
        self.lost_at = np.full(m, np.inf)
        self._step: _Step | None = None
        self.stride = -(-int(self.count.max()) // _KEPT)
        self.history = np.zeros((int(self.count.max()) // self.stride + 1, n, m), dtype=np.float32)

    def advance(self, begin: int, end: int, m: int) -> None:
        """Take the first m loops from one step to another."""
        world = self.world
        if self._step is None or len(self._step.length) != m:
            bank = Bank([loop.controller for loop in self.loops[:m]], world.knowledge, world.gains)
            self._step = _Step(world, bank, self.continuous[:m], self.length[:m])
        # Wanted states at the steps' ends and in their middles.
        times = np.arange(2 * begin, 2 * end + 1)[:, None] * (0.5 * self.length[:m])
        ahead = world.reference.at(times, self.speed[:m])
        with np.errstate(all="ignore"):  # a loop that is lost may overflow
            for k in range(begin, end):
                at = 2 * (k - begin)
                wanted = [tuple(x[:, at + half] for x in ahead) for half in range(3)]
                self._one(self._step, k, wanted, m)

    def _one(self, step: _Step, k: int, wanted: Sequence[tuple[FloatArray, ...]], m: int) -> None:
        """Take step k."""
        n = self.world.plant.arm.n_joints
        state, held = self.state[:, :m], self.held[:, :m]
        asks = k % self.per[:m] == 0
        if asks.any():
            torque, at_limit = step.ask(state, wanted[0])
            np.copyto(held, torque, where=asks)
            np.copyto(self.at_limit[:, :m], at_limit, where=asks)
        going = self.lost_at[:m] == np.inf
        after = step.taken(state, held, wanted)
        error = wanted[2][0] - after[:n]
        lost = going & ~((np.abs(error) < _LOST).all(axis=0) & np.isfinite(after).all(axis=0))
        self.lost_at[:m][lost] = (k + 1) * self.length[:m][lost]
        going &= ~lost
        np.copyto(state, after, where=going)
        size = np.where(going, np.abs(error), 0.0)
        np.maximum(self.peak[:, :m], size, out=self.peak[:, :m])
        self.square[:, :m] += size**2
        used = np.where(going, held, 0.0)
        np.maximum(self.torque_peak[:, :m], np.abs(used), out=self.torque_peak[:, :m])
        self.torque_square[:, :m] += used**2
        self.share[:, :m] += self.at_limit[:, :m]
        if (k + 1) % self.stride == 0:
            self.history[(k + 1) // self.stride, :, :m] = np.where(going, error, np.nan)

    def course(self, order: NDArray[np.intp]) -> Course:
        """What came of it, in another order of the loops."""
        n = self.world.plant.arm.n_joints
        histories = []
        for j in order:
            kept = int(self.count[j]) // self.stride + 1
            times = np.arange(kept) * (self.stride * self.length[j])
            histories.append((times, self.history[:kept, :, j].astype(float)))
        return Course(
            self.peak[:, order],
            (self.square / self.count)[:, order],
            self.torque_peak[:, order],
            (self.torque_square / self.count)[:, order],
            (self.share / self.count)[:, order],
            self.start.reshape(2, n, -1)[..., order],
            self.state[: 2 * n].reshape(2, n, -1)[..., order],
            self.state[2 * n][order],
            self.state[2 * n + 1][order],
            self.lost_at[order],
            tuple(histories),
        )


class _Step:
    """One step of all loops that go on."""

    def __init__(self, world: World, bank: Bank, continuous: NDArray[np.bool_], length: FloatArray) -> None:
        self.n, self.bank, self.continuous, self.length = (
            world.plant.arm.n_joints,
            bank,
            continuous,
            length,
        )
        self.any_continuous = bool(continuous.any())
        self.limits = world.limits[:, None]
        self.plant = Plant(world.plant, world.friction, len(length))

    def ask(self, state: FloatArray, wanted: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Torque of the controllers within its limits, and where it is at them."""
        n = self.n
        torque = self.bank.torque(state[:n], state[n : 2 * n], wanted)
        return np.clip(torque, -self.limits, self.limits), (np.abs(torque) > self.limits).astype(float)

    def taken(
        self, state: FloatArray, held: FloatArray, wanted: Sequence[Sequence[FloatArray]]
    ) -> FloatArray:
        """State after a step; `wanted` at its begin, middle and end."""
        h = self.length
        first = self._slope(state, held)
        second = self._slope(middle := state + 0.5 * h * first, self._now(held, middle, wanted[1]))
        third = self._slope(middle := state + 0.5 * h * second, self._now(held, middle, wanted[1]))
        fourth = self._slope(end := state + h * third, self._now(held, end, wanted[2]))
        return np.asarray(state + h / 6.0 * (first + 2.0 * (second + third) + fourth))

    def _now(self, held: FloatArray, state: FloatArray, wanted: Sequence[FloatArray]) -> FloatArray:
        if not self.any_continuous:
            return held
        return np.where(self.continuous, self.ask(state, wanted)[0], held)

    def _slope(self, state: FloatArray, torque: FloatArray) -> FloatArray:
        n = self.n
        q, qd = state[:n], state[n : 2 * n]
        resistance = self.plant.resistance(qd)
        out = np.empty_like(state)
        out[:n] = qd
        out[n : 2 * n] = self.plant.accelerations(q, qd, torque - resistance)
        out[2 * n] = (torque * qd).sum(axis=0)
        out[2 * n + 1] = (resistance * qd).sum(axis=0)
        return out
