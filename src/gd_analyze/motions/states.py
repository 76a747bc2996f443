"""States of an arm: set points of a trajectory, drawn from the arm's limits, or given and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arrays import Array, FloatArray, array_of, evenly, require_possible, set_points_last
from gd_analyze.errors import GdAnalyzeError, TrajectoryError, UsageError, require_type, require_whole
from gd_analyze.motions import trajectory as motion
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.trajectory import Motion, Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.robots.limits import box_limits
from gd_analyze.text import counted, in_python

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class States:
    """States of an arm: joint variables, velocities and accelerations, with their origin.

    Parameters
    ----------
    q, qd, qdd
        rad (m) and per s, s^2, shape (..., n), usually (N, n).
    described
        Origin as plain values: "trajectory", "trajectory_fingerprint" and "set_points", or "box",
        "states" and "seed". For several motions, "motions" lists their names, comma-separated.
    motions
        Assignment to motions, if these are all states of several.
    weights
        Weight of a torque error at each state and joint, shape of q; None for equal weights.

    Raises
    ------
    TrajectoryError
        If the shapes differ, or a value is not a number, not finite or too large.
    """

    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    described: Mapping[str, str | int] = field(default_factory=dict)
    motions: tuple[Motion, ...] = ()
    weights: FloatArray | None = None

    def __post_init__(self) -> None:
        for name in ("q", "qd", "qdd"):
            array = array_of(getattr(self, name), name, TrajectoryError)
            object.__setattr__(self, name, array)
            if not array.ndim or not array.shape[-1] or array.shape != self.q.shape:
                expected = "shape (..., n)" if name == "q" else f"shape {self.q.shape}, as q has"
                raise refusal(f"{name} of states has the wrong shape", name, expected, f"shape {array.shape}")
            require_possible(array, name, TrajectoryError)

    def __repr__(self) -> str:
        return f"States({in_words(self.described) if self.described else np.shape(self.q)})"

    def __len__(self) -> int:
        return len(self.q)

    @property
    def arrays(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """q, qd and qdd."""
        return self.q, self.qd, self.qdd

    @property
    def last(self) -> tuple[Array, Array, Array]:
        """q, qd and qdd with the states last, shape (n, N), as the formulations take them."""
        q, qd, qdd = (set_points_last(np.asarray(x, dtype=float)) for x in self.arrays)
        return q, qd, qdd

    @property
    def in_a_row(self) -> States:
        """The same states, shape (N, n)."""
        q, qd, qdd = (x.reshape(-1, self.q.shape[-1]) for x in self.arrays)
        return States(q, qd, qdd, self.described)

    @property
    def in_words(self) -> str:
        """Origin in words."""
        return in_words(self.described) if self.described else f"{len(self)} states"

    def at(self, chosen: Any) -> States:
        """Take some states, by a slice, indices or a mask."""
        weights = None if self.weights is None else self.weights[chosen]
        return States(self.q[chosen], self.qd[chosen], self.qdd[chosen], self.described, weights=weights)

    def joined_by(
        self, q: FloatArray, qd: FloatArray, qdd: FloatArray, weights: FloatArray | None = None
    ) -> States:
        """Add states, shape (M, n), with equal weights unless weights are given."""
        if self.weights is not None or weights is not None:
            pairs = (self.weights, self.q), (weights, q)
            weights = np.vstack(
                [np.ones_like(variables) if weight is None else weight for weight, variables in pairs]
            )
        q, qd, qdd = (np.vstack(pair) for pair in zip(self.arrays, (q, qd, qdd), strict=True))
        return States(q, qd, qdd, self.described, weights=weights)

    def evenly(self, most: int) -> States:
        """Take all, or `most` evenly spaced ones."""
        return self.at(evenly(len(self), most))


def in_words(described: Mapping[str, str | int]) -> str:
    """Origin of states in words, from `States.described`."""
    if "trajectory" in described:
        name = described["trajectory"]
        if "motions" in described:
            name = motion.counted_motions(str(described["motions"]).split(", "))
        return f"{counted(int(described['set_points']), 'set point')} of {name}"
    return f"{described['states']} states drawn from {described['box']}, seed {described['seed']}"


def states_of(trajectory: Trajectory) -> States:
    """Take the set points of a trajectory."""
    require_type(trajectory, Trajectory, "trajectory", "a Trajectory, such as `read_trajectory` returns")
    described: dict[str, str | int] = {
        "trajectory": trajectory.name,
        "trajectory_fingerprint": trajectory.fingerprint,
        "set_points": trajectory.n_stated,
    }
    if trajectory.motions:
        described["motions"] = motion.listed(trajectory.motions)
    return States(trajectory.q, trajectory.qd, trajectory.qdd, described, trajectory.motions)


def motions_in(dataset: xr.Dataset) -> tuple[Motion, ...]:
    """Motions of a decomposition's set points; empty for a single motion or a part."""
    about = dataset.attrs
    if "motions" not in about:
        return ()
    ends = list(map(int, about["motion_ends"]))
    if ends[-1] != dataset.sizes["time"]:
        return ()
    rows = zip(about["motions"], [0, *ends[:-1]], ends, about["motion_fingerprints"], strict=True)
    return tuple(Motion(str(name), first, end, fingerprint=str(sha)) for name, first, end, sha in rows)


def states_for(arm: RobotArm, states: States) -> States:
    """Flatten states to shape (N, n); TrajectoryError if there are none or they do not fit the arm."""
    require_joints(arm, states)
    if not states.q.size:
        raise refusal("there are no states", "states", "at least one", "none")
    return states if states.q.ndim == 2 else states.in_a_row


def require_dataset(value: object) -> None:
    """Raise a TrajectoryError if states are given as an object of the wrong type."""
    if not hasattr(value, "data_vars"):
        expected = "a trajectory, its shipped name or its path, States, or a Dataset of `decompose`"
        raise refusal("these are not states", "states", expected, in_python(value))


def require_joints(arm: RobotArm, states: States) -> None:
    """Raise a TrajectoryError if states have another number of joints."""
    if states.q.shape[-1] != arm.n_joints:
        message, expected = f"the states do not fit arm {arm.name}", f"shape (..., {arm.n_joints})"
        raise refusal(message, "q", expected, f"shape {states.q.shape}")


def states_in_box(arm: RobotArm | str | Path, count: int = 4000, seed: int = 0) -> States:
    """Draw states uniformly within the arm's ranges and its velocity and acceleration limits.

    Parameters
    ----------
    arm
        The arm, or the name of a built-in one, or the path of its file.
    count, seed
        Number of states; the same seed draws the same states.

    Returns
    -------
    States
        N = count states, shape (N, n).

    Raises
    ------
    UsageError
        If count is not 1 or more.

    Warns
    -----
    GdAnalyzeWarning
        If limits are assumed because the arm does not state them; `States.described` names them.
    """
    arm = arm_of(arm)
    require_whole(count, "count", 1)
    require_whole(seed, "seed", 0)
    limits = box_limits(arm)
    random = np.random.default_rng(seed)
    shape = (count, arm.n_joints)
    box = f"the arm's ranges, velocity and acceleration limits{limits.remark}"
    q = random.uniform(limits.lower, limits.upper, shape)
    largest = (limits.velocity, limits.acceleration)
    qd, qdd = (random.uniform(-most, most, shape) for most in largest)
    return States(q, qd, qdd, {"box": box, "states": count, "seed": seed})


def broadcast_states(
    arm: RobotArm, error: type[GdAnalyzeError] = UsageError, /, **quantities: ArrayLike
) -> list[FloatArray]:
    """Arrays of quantities with one finite number per joint, leading axes broadcast to one shape.

    Raises `error`.
    """
    arrays = [array_of(values, name, error) for name, values in quantities.items()]
    for name, array in zip(quantities, arrays, strict=True):
        if array.shape[-1:] != (arm.n_joints,):
            message, expected = f"{name} does not fit arm {arm.name}", f"shape (..., {arm.n_joints})"
            raise error(message, where=name, expected=expected, found=str(array.shape))
        require_possible(array, name, error)
    try:
        shape = np.broadcast_shapes(*(array.shape for array in arrays))
    except ValueError:
        message, expected = f"{' and '.join(quantities)} differ in shape", "equal leading axes, or axes of 1"
        shapes = ", ".join(f"shape {array.shape}" for array in arrays)
        raise error(message, where=", ".join(quantities), expected=expected, found=shapes) from None
    # Views that cannot be written: of those of `broadcast_arrays` NumPy warns as soon as they are asked.
    return [np.broadcast_to(array, shape) for array in arrays]
