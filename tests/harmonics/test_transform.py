"""The harmonic form is the numeric one, for any arm and state."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze import load_arm
from gd_analyze.formulas.formula import Product
from gd_analyze.formulas.languages import Plain
from gd_analyze.formulas.writing import powers
from gd_analyze.harmonics.products import to_products
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.tables import decompose_states, harmonics_of
from harmonic_arms import states_of, tolerances
from parallel_axes import arm_of, arms_with_runs, of_every_turn
from strategies import arms, examples, two_link_of

BUILT_IN = ("puma560", "stanford", "two_link")


@pytest.fixture(scope="module", params=BUILT_IN)
def built_in(request) -> Harmonics:
    return harmonics_of(load_arm(request.param))


def assert_exact(harmonics: Harmonics, seed: int, count: int = 5) -> None:
    """D by effect and link, h_ijk by effect and c against the formulas of the text."""
    arm, n = harmonics.arm, harmonics.arm.n_joints
    states = states_of(arm, count, seed)
    numeric = decompose_states(arm, states, by_link=True)
    allowed, q = tolerances(harmonics), states.q.T
    for effect in range(2):
        for (i, j), parts in harmonics.inertia.items():
            error = parts(q)[effect] - numeric["inertia"][:, effect, i, j]
            assert np.abs(error).max() <= allowed["inertia"], (i, j, effect)
        for (s, i, j), parts in harmonics.inertia_by_link.items():
            error = parts(q)[effect] - numeric["inertia_by_link"][:, effect, s, i, j]
            assert np.abs(error).max() <= allowed["inertia"], (s, i, j, effect)
        for i, j, k in np.ndindex(n, n, n):
            error = harmonics.christoffel(i, j, k)(q)[effect] - numeric["christoffel"][:, effect, i, j, k]
            assert np.abs(error).max() <= allowed["christoffel"], (i, j, k, effect)
    for i, polynomial in enumerate(harmonics.gravity_loading):
        error = polynomial(q)[0] - numeric["gravity_loading"][:, i]
        assert np.abs(error).max() <= allowed["gravity_loading"], i
        for s, values in enumerate(harmonics.potential_by_link.derivative(i)(q)):
            error = values - numeric["gravity_loading_by_link"][:, s, i]
            assert np.abs(error).max() <= allowed["gravity_loading"], (s, i)


def test_built_in_arms(built_in):
    assert_exact(built_in, 1, 50)


@of_every_turn(seed=1)
@examples(50)
@given(arms(max_joints=5) | arms_with_runs(max_joints=5), st.integers(0, 2**32 - 1))
def test_arms_of_every_make_and_with_parallel_axes(arm, seed):
    assert_exact(harmonics_of(arm), seed)


@pytest.mark.parametrize(
    "turns",
    [
        ["same"] * 8,
        ["same", "opposite", "opposite", "same", "askew"],
        ["askew"] * 6,
        ["askew", "slides"] * 3 + ["askew"],
        ["askew", "askew", "same", "askew", "slides", "askew", "opposite", "askew"],
    ],
    ids="-".join,
)
def test_given_structures(turns, rng):
    arm = arm_of(turns, rng)
    assert_exact(harmonics_of(arm), 2, 3)


def test_structural_zeros_are_clear(built_in):
    # Round-off leaves some 1e-3 of the cut or nothing; the smallest true amplitude of a built-in arm, 1e-6
    # kg m^2, is 1e5 times the cut.
    assert built_in.gap > 1e3
    parts = [(part, built_in.cut[0]) for part in built_in.inertia.values()]
    for polynomial, cut in [*parts, (built_in.potential, built_in.cut[1])]:
        amplitudes = np.abs(polynomial.coefficients[polynomial.coefficients != 0.0])
        assert amplitudes.min(initial=np.inf) > 1e3 * cut


@examples(10)
@given(arms(max_joints=4, massive=True), st.integers(-20, 20))
def test_coefficients_scale_with_the_masses(arm, power):
    """A power of two scales every rounding too: the same functions, the same digits."""
    factor = 2.0**power
    links = tuple(
        dataclasses.replace(link, mass=factor * link.mass, inertia_com=factor * link.inertia_com)
        for link in arm.links
    )
    light, heavy = harmonics_of(arm), harmonics_of(dataclasses.replace(arm, links=links))
    assert heavy.noise == (factor * light.noise[0], factor * light.noise[1])
    pairs = [(one, heavy.inertia_by_link[key]) for key, one in light.inertia_by_link.items()]
    for one, other in [*pairs, (light.potential, heavy.potential)]:
        np.testing.assert_array_equal(one.multiples, other.multiples)
        np.testing.assert_array_equal(factor * one.coefficients, other.coefficients)


def named(harmonics: Harmonics, polynomial: TrigonometricPolynomial) -> dict[str, float]:
    rows = to_products(polynomial, harmonics.velocities, harmonics.noise[0])
    return {Plain().product(Product(1.0, powers(key))): float(row[0]) for key, row in rows.items()}


@examples(10)
@given(st.floats(0.1, 10.0), st.floats(0.1, 10.0), st.floats(0.1, 10.0), st.floats(1.0, 30.0))
def test_two_link_has_the_closed_forms_of_the_text(length, m1, m2, g):
    """[FGL87] section 3.4.2: term by term, and no term more."""
    harmonics = harmonics_of(two_link_of(length, m1, m2, g))
    ll, close = length**2, lambda value: pytest.approx(value, rel=1e-12, abs=0)

    def forms(i: int, j: int) -> list[dict[str, float]]:
        return [named(harmonics, harmonics.inertia[i, j][[effect]]) for effect in range(2)]

    # 1e-12: a dozen roundings of these few sums, cancellation none.
    across = np.array([m1, m2]) * ll / 12
    assert forms(0, 0) == [
        {"1": close(m1 * ll / 4 + m2 * 5 / 4 * ll), "C2": close(m2 * ll)},
        {"1": close(across.sum())},
    ]
    assert forms(0, 1) == [{"1": close(m2 * ll / 4), "C2": close(m2 * ll / 2)}, {"1": close(across[1])}]
    assert forms(1, 1) == [{"1": close(m2 * ll / 4)}, {"1": close(across[1])}]
    assert len(harmonics.inertia[0, 0]) == 2
    triples = [(i, j, k) for i, j, k in np.ndindex(2, 2, 2) if j <= k]
    h = {key: named(harmonics, harmonics.christoffel(*key)[[0]]) for key in triples}
    half = m2 * ll / 2
    assert {key: form for key, form in h.items() if form} == {
        (0, 0, 1): {"S2": close(-half)},
        (0, 1, 1): {"S2": close(-half)},
        (1, 0, 0): {"S2": close(half)},
    }
    assert not any(harmonics.christoffel(*key).coefficients[1].any() for key in h)
    assert [named(harmonics, polynomial) for polynomial in harmonics.gravity_loading] == [
        {"C1": close((m1 / 2 + m2) * g * length), "C12": close(m2 * g * length / 2)},
        {"C12": close(m2 * g * length / 2)},
    ]


def test_the_puma_collapses_to_few_terms(puma):
    harmonics = harmonics_of(puma)
    assert harmonics.velocities.runs == ((0,), (1, 2), (3,), (4,), (5,))
    # Both effects together; a grid of 5 angles per joint could hold 21 (5^5 + 1) / 2.
    assert sum(map(len, harmonics.inertia.values())) <= 250
    for (i, _), parts in harmonics.inertia.items():
        assert not any(len(parts.derivative(joint)) for joint in range(i + 1))


def test_nothing_with_mass_and_nothing_that_falls(two_link):
    floating = harmonics_of(dataclasses.replace(two_link, gravity_vector=np.zeros(3)))
    assert len(floating.potential) == 0
    assert floating.gap > 1e3
    empty = {"mass": 0.0, "com": np.zeros(3), "inertia_com": np.zeros((3, 3))}
    links = tuple(dataclasses.replace(link, **empty) for link in two_link.links)
    nothing = harmonics_of(dataclasses.replace(two_link, links=links))
    assert not any(len(parts) for parts in nothing.inertia.values())
    assert len(nothing.potential) == 0
