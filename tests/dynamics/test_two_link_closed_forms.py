"""The text's worked example: two uniform rods, [FGL87] sections 3.2.6, 3.3.7 and 3.4.2."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.robots.arm import RobotArm
from strategies import States, examples, random_states, two_link_of


def closed_forms(length: float, m1: float, m2: float, g: float, states: States) -> dict[str, FloatArray]:
    """D, h and c as the text prints them, with l the length of both rods."""
    (th1, th2), (w1, w2) = states.q.T, states.qd.T
    c1, c2, s2, c12 = np.cos(th1), np.cos(th2), np.sin(th2), np.cos(th1 + th2)
    ll = length**2
    d11 = m1 * ll / 3 + 4 / 3 * m2 * ll + m2 * c2 * ll
    d12 = m2 * ll / 3 + m2 * ll * c2 / 2
    d22 = np.full_like(d12, m2 * ll / 3)
    h1 = -m2 * s2 * ll * w2**2 / 2 - m2 * s2 * ll * w1 * w2
    h2 = m2 * s2 * ll * w1**2 / 2
    g1 = m1 * g * length * c1 / 2 + m2 * g * length * c12 / 2 + m2 * g * length * c1
    g2 = m2 * g * length * c12 / 2
    return {
        "inertia": np.stack([np.stack([d11, d12], -1), np.stack([d12, d22], -1)], -2),
        "coriolis_centrifugal": np.stack([h1, h2], -1),
        "gravity_loading": np.stack([g1, g2], -1),
    }


def assert_matches(arm: RobotArm, states: States, length: float, m1: float, m2: float, g: float) -> None:
    found = decompose_states(arm, states)
    bounds = round_off_bounds(arm, states.q, states.qd, states.qdd)
    expected = closed_forms(length, m1, m2, g, states)
    # The closed form of a few roundings is one of the two correct programs that the bounds speak of.
    for name, values in expected.items():
        whole = found[name] if name == "gravity_loading" else found[name].sum(axis=1)
        assert np.abs(whole - values).max() <= bounds[name], name
    # Both rods turn about one fixed direction: their rotation alone is quadratic in constants.
    assert not found["coriolis_centrifugal"][:, 1].any()
    assert not found["christoffel"][:, 1].any()
    across = np.array([m1 + m2, m2, m2]) * length**2 / 12
    rotation = found["inertia"][:, 1]
    np.testing.assert_allclose(rotation[:, [0, 0, 1], [0, 1, 1]] - across, 0.0, atol=bounds["inertia"])


def test_shipped_arm(two_link):
    length = float(two_link.links[0].frame.translation[0])
    m1, m2 = two_link.mass
    g = -float(two_link.gravity[1])
    assert_matches(two_link, random_states(2, 200, 3), length, m1, m2, g)


sizes = st.floats(0.01, 100.0)


@examples(30)
@given(sizes, sizes, sizes, st.floats(0.0, 30.0), st.integers(0, 2**32 - 1))
def test_rods_of_any_length_and_mass(length, m1, m2, g, seed):
    assert_matches(two_link_of(length, m1, m2, g), random_states(2, 20, seed), length, m1, m2, g)
