from __future__ import annotations

import numpy as np
import pytest

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.trajectory import Trajectory

TIME = np.arange(3.0)
Q = np.arange(6.0).reshape(3, 2)


def test_arrays_are_read_only_copies() -> None:
    source = Q.copy()
    trajectory = Trajectory(TIME, source, Q, Q)
    source[0, 0] = 99.0
    assert trajectory.q[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        trajectory.q[0, 0] = 1.0


def test_counts() -> None:
    trajectory = Trajectory(TIME, Q, Q, Q)
    assert (trajectory.n_set_points, trajectory.n_joints) == (3, 2)


def test_fingerprint_follows_every_number() -> None:
    base = Trajectory(TIME, Q, Q, Q, name="a").fingerprint
    assert Trajectory(TIME, Q, Q, Q, name="b").fingerprint == base
    others = [
        Trajectory(TIME + 1, Q, Q, Q),
        Trajectory(TIME, Q + 1, Q, Q),
        Trajectory(TIME, Q, Q + 1, Q),
        Trajectory(TIME, Q, Q, Q + 1),
    ]
    assert len({base, *(other.fingerprint for other in others)}) == 5


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ((TIME, Q[:0], Q, Q), "at least one set point"),
        ((TIME[:2], Q, Q, Q), "time has the wrong shape"),
        ((TIME, Q, Q[:, :1], Q), "qd has the wrong shape"),
        ((TIME, Q, Q, np.where(Q == 3, np.nan, Q)), "qdd is not finite at set point 2"),
        ((TIME[::-1], Q, Q, Q), "set point 2"),
    ],
)
def test_impossible_values_are_refused(arrays: tuple[np.ndarray, ...], message: str) -> None:
    with pytest.raises(TrajectoryError, match=message):
        Trajectory(*arrays)
