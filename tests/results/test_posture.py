"""D, h and c as numbers at one posture."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.errors import UsageError
from gd_analyze.results.posture import posture_result
from strategies import arms, examples


def rows(arm, *arguments, **keywords):
    return {row["element"]: row for row in posture_result(arm, *arguments, **keywords).values()["elements"]}


@examples(15)
@given(arms(max_joints=4, massive=True), st.integers(0, 2**31))
def test_the_numbers_are_those_of_the_dynamics(arm, seed):
    q, qd = np.random.default_rng(seed).normal(size=(2, arm.n_joints))
    dynamics, n = gd.types.ArmDynamics(arm), arm.n_joints
    still, moving = rows(arm, q.tolist()), rows(arm, q.tolist(), qd.tolist())
    whole = {
        "D": dynamics.inertia(q),
        "c": dynamics.gravity_loading(q),
        "h": dynamics.coriolis_centrifugal(q, qd),
    }
    coefficients = dynamics.christoffel(q)
    for name, row in (*still.items(), *moving.items()):
        index = tuple(int(digit) - 1 for digit in name[1:])
        value = coefficients[index] if len(index) == 3 else whole[name[0]][index]
        largest = np.abs(coefficients if len(index) == 3 else whole[name[0]]).max()
        np.testing.assert_allclose(row["value"], value, rtol=1e-12, atol=1e-12 * largest)
        parts = row["translation"] + row["rotation"] + row["drive"]
        np.testing.assert_allclose(row["value"], parts, rtol=1e-12, atol=1e-12 * largest)
    assert [name for name in moving if name[0] == "h"] == [f"h{i + 1}" for i in range(n)]
    assert sum(name[0] == "D" for name in still) == n * (n + 1) // 2
    order = [name[0] for name in still]
    assert order == sorted(order, key="Dhc".index)


def test_the_two_link_arm_by_hand(two_link):
    """[FGL87] section 3.2.6, with q2 a right angle."""
    (m1, m2), g = two_link.mass, -two_link.gravity_vector[1]
    found = rows(two_link, [0.0, np.pi / 2])
    assert found["D11"]["value"] == pytest.approx(m1 / 3 + 4 * m2 / 3)
    assert found["D11"]["rotation"] == pytest.approx((m1 + m2) / 12)
    assert found["h112"]["value"] == pytest.approx(-m2 / 2)
    assert found["c1"]["value"] == pytest.approx((m1 / 2 + m2) * g)
    assert found["c2"]["value"] == 0.0
    assert "h111" not in found
    assert rows(two_link, [0.0, 0.0], None, ["h111"])["h111"]["value"] == 0.0


def test_elements_named(puma):
    q, qd = [0.1] * 6, [0.2] * 6
    assert list(rows(puma, q, None, ["D12", "c2"])) == ["D12", "c2"]
    assert all(name.startswith("h1") and len(name) == 4 for name in rows(puma, q, None, ["h1"]))
    assert list(rows(puma, q, qd, ["h1", "D"]))[-1] == "h1"
    assert list(rows(puma, q, qd, ["h112"])) == ["h112", "h1"]
    with pytest.raises(UsageError, match="D17"):
        rows(puma, q, None, ["D17"])


def test_drives_stand_on_the_diagonal_alone(puma):
    found = rows(puma, [0.0] * 6, None, ["D"])
    assert [found[f"D{i}{i}"]["drive"] for i in range(1, 7)] == puma.drive_inertia.tolist()
    assert found["D12"]["drive"] == 0.0


def test_units_follow_the_joints():
    stanford = gd.load_arm("stanford")
    found = rows(stanford, [0.0, 0.0, 0.6, 0.0, 0.0, 0.0])
    assert (found["D33"]["unit"], found["D13"]["unit"], found["c3"]["unit"]) == ("kg", "kg m", "N")


def test_a_posture_beyond_the_range_is_told(puma):
    assert "waist" in posture_result(puma, [9.0, 0, 0, 0, 0, 0]).notices[0]
    assert posture_result(puma, [0.0] * 6).notices == ()
