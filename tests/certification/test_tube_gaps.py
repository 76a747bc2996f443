"""A tube along a motion with gaps: each stretch has its own, and nothing is said of what lies between."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.certification.tube import Tube
from gd_analyze.motions.trajectory import Trajectory


def joined(*motions: Trajectory, pause: float = 1.0) -> Trajectory:
    """Motions one after the other, with gaps between."""
    times, end = [], 0.0
    for motion in motions:
        times.append(motion.time - motion.time[0] + end)
        end = float(times[-1][-1]) + pause
    lengths = [motion.n_set_points for motion in motions]
    return Trajectory(
        np.concatenate(times),
        *(np.concatenate([getattr(motion, name) for motion in motions]) for name in ("q", "qd", "qdd")),
        name="joined",
        gaps=tuple(np.cumsum(lengths)[:-1].tolist()),
    )


@pytest.fixture(scope="module")
def swing(two_link):
    return gd.read_trajectory("two-link-swing", two_link)


def test_each_stretch_has_the_boxes_of_its_own(two_link, swing):
    margins_of = joined(swing, swing)
    alone, both = Tube.along(two_link, swing), Tube.along(two_link, margins_of)
    count = len(alone)
    assert len(both) == 2 * count
    for k in range(2):
        part = slice(k * count, (k + 1) * count)
        # Time was shifted, which rounds the steps in their last digits.
        np.testing.assert_allclose(both.lower[part], alone.lower, rtol=0, atol=1e-9)
        np.testing.assert_allclose(both.upper[part], alone.upper, rtol=0, atol=1e-9)


def test_no_box_reaches_across_the_gap(two_link, swing):
    motion = joined(swing, swing)
    tube = Tube.along(two_link, motion)
    before, after = motion.time[motion.gaps[0] - 1], motion.time[motion.gaps[0]]
    assert not ((tube.begin < after) & (tube.end > before)).any()
    assert tube.end.max() == motion.time[-1]
    assert "has 1 gap: each of its 2 stretches has a tube of its own" in tube.note
    whole = Tube.along(two_link, replace(motion, gaps=()))
    assert ((whole.begin < after) & (whole.end > before)).any()


def test_few_boxes_still_have_one_for_each_stretch(two_link, swing):
    motion = joined(swing, swing, swing)
    tube = Tube.along(two_link, motion, most=1)
    assert len(tube) == 3
    for name, row in (("q", 0), ("qd", 1), ("qdd", 2)):
        values = getattr(motion, name)
        for part, lower, upper in zip(motion.stretches, tube.lower, tube.upper, strict=True):
            assert (values[part] >= lower[row]).all()
            assert (values[part] <= upper[row]).all()


def test_single_set_points_between_gaps_are_boxes_too(two_link, swing):
    q, qd, qdd = (getattr(swing, name)[:3] for name in ("q", "qd", "qdd"))
    tube = Tube.along(two_link, Trajectory([0.0, 1.0, 2.0], q, qd, qdd, gaps=(1, 2)))
    assert len(tube) == 3
    np.testing.assert_allclose((tube.lower + tube.upper)[:, 0] / 2, q, atol=1e-12)
    mixed = Tube.along(two_link, Trajectory([0.0, 0.01, 2.0], q, qd, qdd, gaps=(2,)))
    assert mixed.begin[-1] == mixed.end[-1] == 2.0


def test_a_certificate_of_two_stretches_is_that_of_the_worse(two_link, swing):
    model = gd.simplify(two_link, swing, "1%")
    motion = joined(swing, swing)
    alone = gd.certify(model, Tube.along(two_link, swing))
    both = gd.certify(model, Tube.along(two_link, motion))
    np.testing.assert_allclose(both.certified, alone.certified, rtol=1e-6)
