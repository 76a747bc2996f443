"""From what a log holds to a motion: stretches between gaps, angles without jumps, readings smoothed."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError
from gd_analyze.motions.cutoffs import Source, chosen
from gd_analyze.motions.derived_rates import FEWEST_SET_POINTS, complete_rates
from gd_analyze.motions.logged import Logged
from gd_analyze.motions.rate_slips import rate_slips
from gd_analyze.motions.recording import Recording
from gd_analyze.motions.smoothing import noise_of, smoothed
from gd_analyze.motions.stamps import FEWEST, Stamps
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.motions.treatment import Treatment
from gd_analyze.motions.unwrapping import unwrapped
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import figures


def motion_of(logged: Logged, arm: RobotArm | None, treatment: Treatment | None = None) -> Trajectory:
    """Make a motion of a log.

    Parameters
    ----------
    logged
        What was understood of it: readings, or a plan.
    arm
        Whose joints; None where that is not known: then no jumps of full turns are undone.
    treatment
        What the user decides; by default rules do.

    Returns
    -------
    Trajectory
        With every reading that can be used as a set point; `recording` holds the readings themselves and what
        was done. A plan is not smoothed: its numbers are as logged, and missing rates are derived.

    Raises
    ------
    TrajectoryError
        If the log is of another number of joints, has too few readings, or a cut-off does not suit it.

    Warns
    -----
    GdAnalyzeWarning
        If measured rates contradict the positions, so that they are not used.
    """
    if arm is not None and logged.q.shape[1] != arm.n_joints:
        raise TrajectoryError(
            f"the log does not fit arm {arm.name}",
            where=logged.origin or logged.name,
            expected=f"{arm.n_joints} joints",
            found=f"{logged.q.shape[1]}",
        )
    how = treatment or Treatment()
    logged = _without_sparse_rates(logged)
    needed = [x for x in (logged.q, logged.qd, logged.qdd) if x is not None]
    readable = np.logical_and.reduce([np.isfinite(x).all(axis=1) for x in needed])
    fewest = FEWEST if logged.measured else FEWEST_SET_POINTS if len(needed) < 3 else 1
    stamps = Stamps.of(logged.time, readable, how.largest_gap, logged.origin or logged.name, fewest)
    q, told = logged.q[stamps.rows], stamps.told
    if arm is not None:
        q, turns = unwrapped(q, arm, stamps.stretches)
        told += turns
    qd, qdd, torque = (None if x is None else x[stamps.rows] for x in (logged.qd, logged.qdd, logged.torque))
    kept = replace(logged, time=stamps.time, q=q, qd=qd, qdd=qdd, torque=torque)
    return _measured(kept, stamps, how, told) if logged.measured else _planned(kept, stamps, told)


def _without_sparse_rates(logged: Logged) -> Logged:
    """Leave rates and accelerations out that stand in fewer than half of the rows that hold positions."""
    held = np.isfinite(logged.q).all(axis=1)
    count = int(held.sum())

    def unless_sparse(values: FloatArray | None, words: str) -> FloatArray | None:
        if values is None:
            return None
        beside = int((held & np.isfinite(values).all(axis=1)).sum())
        if 2 * beside >= count:
            return values
        warnings.warn(
            f"log {logged.name}: {words} stand in {beside} of {count} rows that hold positions, and "
            "are not used",
            GdAnalyzeWarning,
            stacklevel=5,
        )
        return None

    qd, qdd = unless_sparse(logged.qd, "rates"), unless_sparse(logged.qdd, "accelerations")
    return replace(logged, qd=qd, qdd=qdd)


def _planned(kept: Logged, stamps: Stamps, told: tuple[str, ...]) -> Trajectory:
    qd, qdd, rates_from = complete_rates(kept.time, kept.q, kept.qd, kept.qdd, stamps.gaps)
    nothing = np.zeros(kept.q.shape[1])
    recording = Recording(kept.q, kept.torque, kept.torque, None, nothing, nothing, kept.columns, told)
    return Trajectory(kept.time, kept.q, qd, qdd, kept.name, kept.origin, rates_from, stamps.gaps, recording)


def _measured(kept: Logged, stamps: Stamps, how: Treatment, told: tuple[str, ...]) -> Trajectory:
    source, cutoffs, why = chosen(_sources(kept, stamps, how), stamps, how)
    from_rates = source.order == 1
    q, qd, qdd = _smooth(stamps, kept.q, cutoffs, (0, 1, 2))
    if from_rates:
        qd, qdd = _smooth(stamps, source.values, cutoffs, (0, 1))
    noise_qdd = source.left(cutoffs)
    if kept.qdd is not None:
        (qdd,) = _smooth(stamps, kept.qdd, cutoffs, (0,))
        noise_qdd = noise_of(kept.qdd, qdd, stamps.step, cutoffs, left=True)
    torque = None
    if kept.torque is not None:
        # What the motion holds of any joint acts on all.
        every = np.full(len(cutoffs), cutoffs.max())
        (torque,) = _smooth(stamps, kept.torque, every, (0,))
    hertz = " and ".join(dict.fromkeys(f"{figures(float(cutoff))} Hz" for cutoff in cutoffs))
    whence = "the measured rates" if from_rates else "the measured positions"
    done = f"smoothed without delay, cut-off {hertz} ({why})"
    if kept.qdd is not None:
        rates_from = f"given: measured, {done}"
    else:
        rates_from = f"{'qdd' if from_rates else 'qd and qdd'} derived: from {whence}, {done}"
    left = f"noise left in qdd {figures(float(noise_qdd.min()))} to {figures(float(noise_qdd.max()))} per s^2"
    return Trajectory(
        kept.time,
        q,
        qd,
        qdd,
        kept.name,
        kept.origin,
        rates_from,
        stamps.gaps,
        Recording(
            kept.q,
            kept.torque,
            torque,
            cutoffs,
            noise_of(kept.q, q, stamps.step, cutoffs),
            noise_qdd,
            kept.columns,
            (*told, f"accelerations from {whence}, {done}; {left}"),
        ),
    )


def _sources(kept: Logged, stamps: Stamps, how: Treatment) -> list[Source]:
    """Positions, and rates where there are any that do not contradict them."""
    sources = [Source.of(stamps, kept.q, 2)]
    if kept.qd is None or not how.use_rates:
        return sources
    # The longest stretch: rates are compared with changes of positions, of which a gap says nothing.
    longest = max(stamps.stretches, key=lambda stretch: stretch.stop - stretch.start)
    time, q, qd = (x[longest] for x in (kept.time, kept.q, kept.qd))
    slips = rate_slips(Trajectory(time, q, qd, np.zeros_like(qd), rates_from="qdd derived"))
    if slips:
        warnings.warn(
            f"log {kept.name}: {'; '.join(slips)}; the measured rates are not used",
            GdAnalyzeWarning,
            stacklevel=4,
        )
        return sources
    return [*sources, Source.of(stamps, kept.qd, 1)]


def _smooth(
    stamps: Stamps, values: FloatArray, cutoffs: FloatArray, orders: tuple[int, ...]
) -> list[FloatArray]:
    """Derivatives of smoothed readings at the set points, shape (N, n) each; joint by joint, to save memory.

    Where a cell is empty, the others of its stretch tell; a stretch with fewer than three has none.
    """
    out = [np.full_like(values, np.nan) for _ in orders]
    for stretch in stamps.stretches:
        time = stamps.time[stretch]
        for i, cutoff in enumerate(cutoffs.tolist()):
            known = np.isfinite(values[stretch, i])
            if np.count_nonzero(known) < 3:
                continue
            spline = smoothed(time[known], values[stretch, i][known], cutoff)
            for array, order in zip(out, orders, strict=True):
                array[stretch, i] = spline(time, order)
    return out
