"""Thinning of long curves."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.report.thinning import breaks, broken, thinned


@given(st.integers(1, 5), st.integers(1, 3000), st.integers(30, 400), st.integers(0, 2**32 - 1))
def test_thinning_keeps_ends_and_extremes(k: int, count: int, most: int, seed: int) -> None:
    curves = np.random.default_rng(seed).normal(size=(k, count)).cumsum(axis=1)
    chosen = thinned(curves, most)
    assert (np.diff(chosen) > 0).all()
    assert chosen[0] == 0
    assert chosen[-1] == count - 1
    assert len(chosen) <= most
    assert (curves[:, chosen].max(axis=1) == curves.max(axis=1)).all()
    assert (curves[:, chosen].min(axis=1) == curves.min(axis=1)).all()
    if count <= most:
        assert len(chosen) == count


def test_lines_break_before_the_first_set_point_that_is_drawn_behind_a_gap():
    chosen = np.array([0, 5, 9, 20])
    assert breaks(chosen, (6,)).tolist() == [2]
    assert breaks(chosen, (10, 15)).tolist() == [3]
    assert breaks(chosen, ()).tolist() == []
    assert breaks(chosen, (21, 30)).tolist() == []
    points = np.arange(8.0).reshape(4, 2)
    line = broken(points, breaks(chosen, (6,)))
    assert np.isnan(line).all(axis=1).tolist() == [False, False, True, False, False]
    assert broken(points, breaks(chosen, ())) is points
