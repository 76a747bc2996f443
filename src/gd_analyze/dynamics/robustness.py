"""Probability of verdicts, given the uncertainty of the arm's inertial parameters.

D and h are linear in every link's mass, first moment and inertia about its frame's origin. The point mass m
at r, with inertia m (r.r 1 - r r^T), gives the translational parts; the rest of the inertia, that about the
centre of mass, gives the rotational parts. Sampled arms are thus one product of matrices.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import Array, FloatArray, evenly
from gd_analyze.dynamics.base_parameters import link_regressor
from gd_analyze.dynamics.dominance import DOMINANCE_THRESHOLD, Element, elements
from gd_analyze.dynamics.uncertainty import Drawn
from gd_analyze.dynamics.verdicts import least_changes, representing, representing_at
from gd_analyze.errors import require_whole
from gd_analyze.motions.limits import require_trajectory_joints
from gd_analyze.motions.pool import GivenMotions, trajectory_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.robots.uncertainty import exactly_known, with_uncertainty
from gd_analyze.schema import table
from gd_analyze.threads import one_thread

if TYPE_CHECKING:
    import xarray as xr

VERDICTS = ["translation", "rotation", "both", "zero"]
# Longer motions are thinned evenly: the time grows with samples times set points.
_MOST_SET_POINTS = 500
# Samples at a time: at most 255, whose counts fit into bytes; arrays of more take memory and no less time.
_SAMPLES_AT_ONCE = 64


@one_thread()
def robustness(
    arm: RobotArm | str | Path,
    trajectory: GivenMotions,
    uncertainty: str | None = None,
    *,
    threshold: float = DOMINANCE_THRESHOLD,
    samples: int = 10_000,
    seed: int = 0,
) -> xr.Dataset:
    """Find the probability that translation, rotation or both dominate each element of D and h.

    The uncertain parameters are drawn independently from normal distributions. A sampled link that is
    physically inconsistent is drawn again, unless the given link is inconsistent or a limiting case, as a
    point mass.

    Parameters
    ----------
    arm, trajectory
        The arm and its motion; or a shipped name, or the path of a file.
    uncertainty
        Standard uncertainties of all links instead of those the arm states: "mass=5%,com=2mm,inertia=10%".
    threshold
        As for `rank`.
    samples
        Number of arms drawn.
    seed
        Seed of the draws.

    Returns
    -------
    xarray.Dataset
        `probability` (element, time, verdict) and `over_motion` (element, verdict), each summing to one along
        `verdict` ("translation", "rotation", "both", "zero", as `dominant` of `rank`), and `redrawn` (link),
        the number of inconsistent samples. The attribute `exactly_known` names the parameters without
        uncertainty. Beyond 500 set points, 500 evenly spaced ones are used.

    Raises
    ------
    ArmError
        If no uncertainty is stated, or one so large that hardly any sample is physically consistent.
    UsageError
        If the text for the uncertainty cannot be read.
    TrajectoryError
        If the trajectory has another number of joints.
    """
    arm = arm_of(arm)
    require_whole(samples, "samples", 1)
    require_whole(seed, "seed", 0)
    trajectory = trajectory_of(trajectory, arm)
    require_trajectory_joints(trajectory, arm)
    arm = arm if uncertainty is None else with_uncertainty(arm, uncertainty)
    drawn = Drawn.from_arm(arm, samples, np.random.default_rng(seed))
    set_points = evenly(trajectory.n_set_points, _MOST_SET_POINTS)
    q, qd = (array[set_points].T for array in (trajectory.q, trajectory.qd))
    at_set_points, over_motion = _counts(elements_per_unit(arm, q, qd), drawn, threshold)
    coords = {
        "element": [element.label for element in _judged(arm)],
        "time": ("time", trajectory.time[set_points], {"units": "s"}),
        "verdict": VERDICTS,
        "link": np.arange(1, arm.n_joints + 1),
    }
    attrs = {"threshold": float(threshold), "samples": samples, "seed": seed, "arm": arm.name}
    return table(
        "robustness",
        {
            "probability": at_set_points / samples,
            "over_motion": over_motion / samples,
            "redrawn": drawn.redrawn,
        },
        arm.is_revolute,
        coords,
        attrs | {"trajectory": trajectory.name, "exactly_known": exactly_known(arm)},
    )


def _judged(arm: RobotArm) -> list[Element]:
    """Elements of D and h; gravity loading has one part only."""
    return [element for element in elements(arm.n_joints) if element.quantity != "gravity_loading"]


def elements_per_unit(arm: RobotArm, q: Array, qd: Array) -> FloatArray:
    """Elements of D and h per unit of every link's `PARAMETERS`, shape (elements, N, n links, 10).

    Joint i's torque is D_ij if only joint j accelerates, and h_i if none does.
    """
    n, count = q.shape
    weightless = replace(arm, gravity_vector=np.zeros(3))
    velocities = np.concatenate([np.zeros((n, n * count)), qd], axis=1)
    accelerations = np.concatenate([np.repeat(np.eye(n), count, axis=1), np.zeros((n, count))], axis=1)
    torques = link_regressor(weightless, np.tile(q, n + 1), velocities, accelerations)
    torques = torques.reshape(n, n, -1, n + 1, count)
    rows = [torques[e.i, :, :, n if e.j is None else e.j] for e in _judged(arm)]
    return np.moveaxis(np.array(rows), -1, 1)


def _counts(per_unit: FloatArray, drawn: Drawn, threshold: float) -> tuple[FloatArray, FloatArray]:
    """Samples by `VERDICTS` at every set point (elements, N, 4), and over the motion (elements, 4)."""
    n_elements, count, n, _ = per_unit.shape
    flat, samples = per_unit.reshape(n_elements * count, -1), len(drawn.points)
    factors = []
    for parameters in (drawn.points, drawn.matter):
        sampled = parameters.reshape(samples, -1)
        varies = np.ptp(sampled, axis=0) > 0.0
        # Single precision errs far less than sampling, in half the time.
        varying, fixed = flat[:, varies], flat[:, ~varies] @ sampled[0, ~varies]
        factors.append([x.astype(np.float32) for x in (varying, sampled[:, varies].T, fixed)])
    at_set_points, over_motion = np.zeros((n_elements, count, 3)), np.zeros((n_elements, 3))
    for start in range(0, samples, _SAMPLES_AT_ONCE):
        block = slice(start, start + _SAMPLES_AT_ONCE)
        parts = [
            (varying @ sampled[:, block] + fixed[:, None]).reshape(n_elements, count, -1)
            for varying, sampled, fixed in factors
        ]
        whole = np.abs(parts[0] + parts[1]).max(axis=1)
        sizes = np.abs(np.array(parts))
        part_peaks = sizes.max(axis=2)
        # Elements of h are last.
        of_quantities = [part_peaks[:, rows].max(axis=(0, 1)) for rows in (slice(-n), slice(-n, None))]
        largest = np.repeat(of_quantities, [n_elements - n, n], axis=0)
        least = least_changes(part_peaks, whole, largest, threshold)
        overall = representing(part_peaks, least)
        needed = representing_at(sizes > least[:, :, None], overall[:, :, None])
        for out, flags in ((at_set_points, needed), (over_motion, overall)):
            for k, flag in enumerate((*flags, flags[0] & flags[1])):
                out[..., k] += np.add.reduce(flag.view(np.uint8), axis=-1, dtype=np.uint8)
    return _by_verdict(at_set_points, samples), _by_verdict(over_motion, samples)


def _by_verdict(needed: FloatArray, samples: int) -> FloatArray:
    """Counts by verdict from counts of translation, rotation and both needed."""
    translation, rotation, both_needed = np.moveaxis(needed, -1, 0)
    return np.stack(
        [
            translation - both_needed,
            rotation - both_needed,
            both_needed,
            samples - translation - rotation + both_needed,
        ],
        -1,
    )
