"""What spares work on arms of many terms changes nothing of what is found."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.errors import ArmError
from gd_analyze.harmonics import products as of_products
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.equations import Equation, each_equation, elements_named, equations, harmonics_for
from gd_analyze.harmonics.products import to_terms
from gd_analyze.harmonics.transform import Harmonics, harmonics_of
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.robots.arm import RobotArm
from parallel_axes import arm_of, arms_with_runs
from strategies import arms, examples

ANY_ARM = st.one_of(arms(max_joints=4), arms_with_runs(max_joints=5))


@examples(40)
@given(ANY_ARM)
def test_double_angles_of_all_products_at_once_are_those_of_each_by_itself(arm):
    harmonics = harmonics_of(arm)
    for parts in [*harmonics.inertia.values(), *harmonics.gravity_loading]:
        waves = TrigonometricPolynomial.stacked([parts.total(), parts])
        at_once = to_terms(waves, harmonics.velocities, harmonics.noise[0])
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(of_products, "has_one_double", lambda table, r: False)
            one_by_one = to_terms(waves, harmonics.velocities, harmonics.noise[0])
        assert [*at_once] == [*one_by_one]
        assert all((at_once[monomial] == weights).all() for monomial, weights in one_by_one.items())


@examples(30)
@given(ANY_ARM, st.sampled_from([1e-6, 0.01, 0.3, 1.0]))
def test_a_share_asked_for_is_what_is_left_of_the_whole(arm, share):
    harmonics = harmonics_of(arm)
    whole = equations(harmonics, ("D", "h", "c"))
    cut = {each.symbol: each.terms for each in equations(harmonics, ("D", "h", "c"), min_share=share)}
    assert cut == {each.symbol: tuple(t for t in each.terms if t.share >= share) for each in whole}


@examples(30)
@given(ANY_ARM, st.data())
def test_single_elements_are_those_of_the_whole(arm, data):
    i, j, k = (data.draw(st.integers(1, arm.n_joints)) for _ in range(3))
    harmonics = harmonics_of(arm)
    for label in (f"D{i}{j}", f"h{i}{j}{k}", f"c{i}"):
        assert_same(harmonics, equations(arm, [label]), equations(harmonics, [label]))


def assert_same(harmonics: Harmonics, found: tuple[Equation, ...], whole: tuple[Equation, ...]) -> None:
    # On a grid of another size numbers are rounded in another order, by far less than what counts as noise.
    for one, other in zip(found, whole, strict=True):
        assert one.symbol == other.symbol
        weights = {term.factors: term.coefficient for term in other.terms}
        assert {term.factors for term in one.terms} == {*weights}
        apart = [abs(term.coefficient - weights[term.factors]) for term in one.terms]
        assert max(apart, default=0.0) <= max(harmonics.noise)


def general(n: int) -> RobotArm:
    return arm_of(["askew"] * n, np.random.default_rng(n))


def test_what_no_element_asked_for_depends_on_is_not_looked_for():
    arm = general(5)
    assert {i for _, i, _ in harmonics_for(arm, ["D45", "h535"]).inertia_by_link} == {2, 3, 4}
    assert harmonics_for(arm, ["c1", "c"]).inertia_by_link == {}
    assert len(harmonics_for(arm, ["c"]).potential) == len(harmonics_of(arm).potential)


def test_outer_elements_of_an_arm_whose_whole_takes_too_much_memory():
    arm = general(12)
    with pytest.raises(ArmError, match=r"take too much memory") as raised:
        equations(arm, ["D12"])
    # D44 depends on eight angles, 5^8 positions, and D33 on nine: 2 n^2 numbers at each are 0.9 and 4.5 GB.
    assert "found: 12 joints: values on a grid of 112 GB" in str(raised.value)
    assert "next: elements from D44 on, and c, are found;" in str(raised.value)
    (equation,) = equations(arm, ["D10,11"])
    # Of the angles of joints 11 and 12 only: at most 25 products.
    assert 0 < len(equation.terms) <= 25


@pytest.mark.parametrize("labels", [(), ("D12",), ("h1", "c")])
def test_the_work_told_adds_up(labels):
    harmonics = harmonics_of(general(4))
    told: list[int] = []
    found = tuple(each_equation(harmonics, labels, progress=told.append))
    assert found == equations(harmonics, labels)
    assert sum(told) == len(elements_named(labels, 4))


def test_an_arm_without_terms():
    velocities = AbsoluteVelocities.of(general(3))
    nothing = TrigonometricPolynomial(
        (False,) * 3, np.zeros((0, 3), dtype=np.int64), np.zeros((1, 0), dtype=complex)
    )
    assert to_terms(nothing, velocities) == {}
