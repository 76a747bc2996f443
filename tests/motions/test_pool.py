"""Several motions as one trajectory: nothing of any of them is lost, and each is found again."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze import Trajectory, pool, write_trajectory
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.motions.pool import taken_apart, trajectory_of
from gd_analyze.types import Recording
from recordings import swung


@st.composite
def made(draw: st.DrawFn) -> Trajectory:
    count = draw(st.integers(1, 6))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    start = draw(st.sampled_from([0.0, -3.0, 100.0]))
    gaps = (count - 1,) if count > 1 and draw(st.booleans()) else ()
    name = draw(st.sampled_from(["a", "b", "a-2"]))
    return Trajectory(
        start + np.cumsum(rng.uniform(0.01, 1.0, count)), *rng.normal(size=(3, count, 2)), name, gaps=gaps
    )


@given(st.lists(made(), min_size=2, max_size=5))
def test_every_motion_is_found_again(motions):
    whole = pool(motions)
    assert whole.n_set_points == sum(single.n_set_points for single in motions)
    assert len({motion.name for motion in whole.motions}) == len(motions)
    for single, motion, again in zip(motions, whole.motions, taken_apart(whole), strict=True):
        for name in ("q", "qd", "qdd"):
            np.testing.assert_array_equal(getattr(again, name), getattr(single, name))
        # Instants are moved by at most some seconds and back, from and to at most 200 s.
        np.testing.assert_allclose(again.time, single.time, rtol=0, atol=8 * np.spacing(200.0))
        assert again.gaps == single.gaps
        assert motion.fingerprint == single.fingerprint
        assert motion.first == 0 or motion.first in whole.gaps
        assert motion.name.startswith(single.name)
    assert whole.derived == ()
    apart = pool([pool(motions[:1]), pool(motions[1:])])
    np.testing.assert_array_equal(apart.q, whole.q)
    assert [motion.n_set_points for motion in apart.motions] == [single.n_set_points for single in motions]
    assert len(whole.gaps) == len(motions) - 1 + sum(len(single.gaps) for single in motions)


def test_time_runs_on_with_a_pause_that_is_told():
    whole = pool([swung(2.0, "a", 5), swung(4.0, "b", 5)])
    # A tenth of their mean duration of 3 s.
    assert whole.time[[0, 4, 5, 9]].tolist() == [0.0, 2.0, 2.3, 6.3]
    assert whole.gaps == (5,)
    assert all(fact in whole.origin for fact in ("2 motions", "(a, b)", "0.3 s"))
    assert pool([whole]).time.tolist() == whole.time.tolist()
    still = Trajectory([7.0], *[[[0.0, 0.0]]] * 3, "still")
    assert pool([still, still]).time.tolist() == [0.0, 1.0]


@pytest.mark.parametrize(
    ("names", "name"),
    [
        ("abc", "a+b+c"),
        ("abcd", "a+3-more"),
        (["a-2", "a", "a"], "a-2+a+a-3"),
        (["x" * 60, "y" * 60], "x" * 60 + "+1-more"),
    ],
)
def test_names(names, name):
    assert pool([swung(1.0, motion) for motion in names]).name == name


def test_readings_are_those_of_all_where_all_have_some():
    def recorded(name, cutoff, torque=True):
        motion, each = swung(1.0, name, 4), np.full(2, cutoff)
        torques = np.ones((4, 2)) if torque else None
        recording = Recording(motion.q, torques, None, each, each, each, (), ("filtered",))
        return dataclasses.replace(motion, recording=recording)

    both = pool([recorded("a", 5.0), recorded("b", 3.0)]).recording
    assert both.torque.shape == (8, 2)
    # Of the joint's filters the one that passes least is told, of noise the most.
    assert (both.cutoff.tolist(), both.noise_q.tolist()) == ([3.0, 3.0], [5.0, 5.0])
    assert both.treatment[:2] == ("a: filtered", "b: filtered")
    assert both.treatment[2].endswith("3 Hz to 5 Hz")
    whole = pool([recorded("a", 5.0), recorded("b", 3.0)])
    for part, motion in zip(taken_apart(whole), whole.motions, strict=True):
        np.testing.assert_array_equal(part.recording.torque, whole.recording.torque[motion.rows])
    # Taken apart, each has the filter, the noise and the notes of its own again.
    parts = [part.recording for part in taken_apart(whole)]
    assert [part.cutoff.tolist() for part in parts] == [[5.0, 5.0], [3.0, 3.0]]
    assert [part.noise_q.tolist() for part in parts] == [[5.0, 5.0], [3.0, 3.0]]
    assert [part.treatment for part in parts] == [("filtered",), ("filtered",)]
    assert pool([recorded("a", 5.0), recorded("b", 3.0, torque=False)]).recording.torque is None
    assert pool([recorded("a", 5.0), swung(1.0, "plan")]).recording is None


def test_refusals(swing, pick_and_place):
    where = "trajectory pick-and-place"
    for motions, at, found in (
        ([swing, pick_and_place], where, "6 joints"),
        ([], "motions", "none"),
        ([3], "motions", "3"),
    ):
        with pytest.raises(GdAnalyzeError) as caught:
            pool(motions)
        assert (caught.value.details["where"], caught.value.details["found"]) == (at, found)


def test_files_names_and_values_together(two_link, swing, tmp_path):
    write_trajectory(swung(4.0, "quick"), tmp_path / "quick.csv")
    whole = trajectory_of(["two-link-swing", tmp_path / "quick.csv", swung(5.0, "made")], two_link)
    assert whole.name == "two-link-swing+quick+made"
    assert whole.motions[0].fingerprint == swing.fingerprint
    assert whole.motions[1].origin == f"read from {tmp_path / 'quick.csv'}"
