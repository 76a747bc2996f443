"""Fits of a program's numbers."""

from __future__ import annotations

import numpy as np
import pytest

from gd_analyze.motions.states import states_in_box
from gd_analyze.operations.tape import Tape
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.fitting import Aim, Columns, fitted, norm, unfitted
from gd_analyze.simplification.program_cache import inputs_of


@pytest.fixture(scope="module")
def aim_and_tape() -> tuple[Aim, Tape]:
    exact = ExactDynamics.of(load_arm("stanford"), states_in_box(load_arm("stanford"), 200))
    scale = 1.0 / exact.peak_torque
    aim = Aim(inputs_of(exact.states), exact.torque.T * scale[:, None], scale, np.ones(exact.torque.T.shape))
    return aim, Tape(exact.form.recursion.program)


@pytest.mark.parametrize("power", [2.0, 8.0])
def test_numbers_that_are_off_are_found_again(aim_and_tape: tuple[Aim, Tape], power: float) -> None:
    aim, tape = aim_and_tape
    numbers = tape.numbers * (1.0 + 0.05 * np.cos(np.arange(len(tape))))
    start = unfitted(tape, aim, numbers)
    found = fitted(tape, aim, start, power, 8)
    # The torque of 5 % is gone but for steps that are held back: an order of magnitude at least.
    assert found.largest < 0.1 * start.largest


def test_a_fit_is_never_worse(aim_and_tape: tuple[Aim, Tape]) -> None:
    aim, tape = aim_and_tape
    for seed in range(5):
        rng = np.random.default_rng(seed)
        start = unfitted(tape, aim, tape.numbers * rng.uniform(0.5, 1.5, len(tape)))
        assert norm(fitted(tape, aim, start, 12.0, 2).errors, 12.0) <= norm(start.errors, 12.0)


def test_a_high_power_brings_the_largest_error_down() -> None:
    """The line nearest to a parabola on -1 .. 1: squares leave 2/3 at the ends, at best 1/2 is left."""
    x = np.linspace(-1.0, 1.0, 401)
    columns, target = np.stack([np.ones_like(x), x]), x**2

    def largest(power: float) -> float:
        return float(np.abs(Columns(columns).least(target, power)[1]).max())

    assert largest(2.0) == pytest.approx(2 / 3, abs=0.01)
    # Chebyshev: the mean of largest and smallest value. A power of 12 is close to that, not there.
    assert largest(12.0) == pytest.approx(0.5, abs=0.05)


def test_norms_do_not_overflow() -> None:
    assert norm(np.array([1e200, 1e200]), 12.0) == pytest.approx(1e200 * 2 ** (1 / 12))
    assert norm(np.zeros(3), 12.0) == 0.0
