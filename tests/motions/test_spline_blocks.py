"""A long spline made of blocks is the whole one: at their joints, at ends, gaps and uneven stamps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from gd_analyze.arrays import FloatArray
from gd_analyze.motions import spline
from gd_analyze.motions.sampling import Sampling, sampling_of
from gd_analyze.motions.spline import derivatives

ORDERS = (0, 1, 2)
BLOCK = 700
EVEN = np.arange(6000) / 1000


def sampled(time: FloatArray, largest_gap: float | None = None) -> Sampling:
    moving = np.arange(float(len(time)))[:, None]
    return sampling_of(time, moving, np.ones(len(time), dtype=bool), largest_gap, "log", 16)


def with_pauses() -> FloatArray:
    return EVEN + np.select([EVEN >= 4.5, EVEN >= 3.1], [3.0, 1.0], 0.0)


def jittering() -> FloatArray:
    return EVEN + np.random.default_rng(1).uniform(-0.45, 0.45, len(EVEN)) / 1000


def at_random() -> FloatArray:
    return np.cumsum(np.random.default_rng(2).exponential(1e-3, len(EVEN)))


def at_two_rates() -> FloatArray:
    """A thousand readings a second, with 2 000 in between at twenty a second."""
    return np.cumsum(np.where(np.arange(8000) // 2000 == 2, 4.9e-2, 1e-3))


def read_at(time: FloatArray) -> FloatArray:
    """Positions far from zero and near it, with noise."""
    q = np.column_stack([100.0 + 0.3 * np.cos(1.3 * time), np.sin(4.4 * time)])
    return q + 1e-4 * np.random.default_rng(0).normal(size=q.shape)


def of_blocks(monkeypatch: pytest.MonkeyPatch, length: int, *given) -> FloatArray:
    monkeypatch.setattr(spline, "BLOCK_READINGS", length)
    return derivatives(*given, ORDERS)


def assert_equal(blocks: FloatArray, whole: FloatArray, values: FloatArray, cutoff: float) -> None:
    """The overlap leaves 1e-22 of a reading's effect, less than rounding.

    Readings round to eps times the largest; differentiation at a cut-off multiplies by 2 pi f_c.
    """
    rounding = np.finfo(float).eps * np.nanmax(np.abs(values))
    for order in ORDERS:
        allowed = 20 * rounding * max(2 * np.pi * cutoff, 1.0) ** order
        np.testing.assert_allclose(blocks[order], whole[order], rtol=0, atol=allowed)


@pytest.mark.parametrize(
    ("instants", "largest_gap", "stretches"),
    [
        (lambda: EVEN, None, 1),
        (jittering, None, 1),
        (at_random, None, 1),
        (with_pauses, None, 3),
        (with_pauses, 10.0, 1),
        (at_two_rates, None, 1),
    ],
)
@pytest.mark.parametrize("cutoff", [2.0, 30.0])
def test_blocks_make_the_whole_spline(
    instants: Callable[[], FloatArray],
    largest_gap: float | None,
    stretches: int,
    cutoff: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sampling = sampled(instants(), largest_gap)
    assert len(sampling.stretches) == stretches
    values, cutoffs = read_at(sampling.time), np.full(2, cutoff)
    whole = of_blocks(monkeypatch, 10**6, sampling, values, cutoffs)
    blocks = of_blocks(monkeypatch, BLOCK, sampling, values, cutoffs)
    assert_equal(blocks, whole, values, cutoff)


def test_blocks_where_joints_differ_and_lack_readings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Missing cells are bridged over the joint of two blocks; a joint that was hardly read stays unknown."""
    sampling, values = sampled(EVEN), read_at(EVEN)
    values[::7, 0] = np.nan
    values[2000:2400, 0] = np.nan
    cutoffs = np.array([20.0, 30.0])
    whole = of_blocks(monkeypatch, 10**6, sampling, values, cutoffs)
    blocks = of_blocks(monkeypatch, BLOCK, sampling, values, cutoffs)
    assert np.isfinite(blocks).all()
    assert_equal(blocks, whole, values, 30.0)
    values[2:, 1] = np.nan
    blocks = of_blocks(monkeypatch, BLOCK, sampling, values, cutoffs)
    assert np.isnan(blocks[..., 1]).all()
    assert np.isfinite(blocks[..., 0]).all()


def test_a_block_solves_little_more_than_its_readings(monkeypatch: pytest.MonkeyPatch) -> None:
    """However long the overlap, the blocks of a stretch are at most three times the stretch."""
    sizes: list[int] = []
    solve = spline._Equations.spline

    def counted(equations, values, origin, part):
        sizes.append(len(values))
        return solve(equations, values, origin, part)

    monkeypatch.setattr(spline._Equations, "spline", counted)
    sampling, values = sampled(EVEN), read_at(EVEN)
    for cutoff in (5.0, 50.0, 200.0):
        sizes.clear()
        of_blocks(monkeypatch, 100, sampling, values, np.full(2, cutoff))
        overlap = 16 / cutoff * 1000
        assert max(sizes) <= 3 * max(overlap, 100) + 2
        assert sum(sizes) <= 3 * len(EVEN)
