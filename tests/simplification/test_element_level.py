"""The promise of a simplified model, and that no cheaper one keeps it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from budgets import of_shares, of_torque
from few_tries import few_tries
from gd_analyze.arrays import ROUND_OFF_SHARE, peak_magnitude
from gd_analyze.dynamics.decomposition import decompose
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.errors import GdAnalyzeError, UsageError
from gd_analyze.motions.read import read_trajectory
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.operations.trace import Trace, is_constant
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.robots.parts import Drive
from gd_analyze.simplification.budget import Budget, ReferenceTorques
from gd_analyze.simplification.effort import ROUGH
from gd_analyze.simplification.element import ELEMENT, Part, blocks, parts_of, torque_by_part, trace_parts
from gd_analyze.simplification.evaluation import losses
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.selection import select
from gd_analyze.simplification.simplify import simplify
from made_models import by_elements
from strategies import arms_with_states, examples, motions, two_link_of

budgets = st.one_of(st.floats(0, 1.2).map(of_shares), st.floats(0, 50).map(of_torque))


@examples(15)
@given(motions(max_joints=3, massive=True), budgets)
@few_tries()
def test_the_promise_holds_and_is_the_torque_of_what_was_dropped(case, budget):
    arm, motion = case
    dataset = decompose(arm, motion)
    model = by_elements(arm, dataset, budget)
    peak = np.abs(dataset.torque.values).max(axis=0)
    # A joint's budget never falls below round-off, where "no error" has no meaning.
    least = ROUND_OFF_SHARE * peak.max()
    assert (
        model.accuracy.errors.largest
        <= np.maximum(budget.allowed(ReferenceTorques(arm, peak_magnitude(dataset.torque.values))), least)
    ).all()
    assert (model.accuracy.errors.largest <= model.accuracy.allowed).all()
    parts = dropped_by(model)
    lost = torque_by_part(dataset, dataset.qdd.values, parts).sum(axis=0).T
    error = dataset.torque.values - model.torque(motion.q, motion.qd, motion.qdd)
    # The model's arithmetic is folded, the dataset's is not: two correct programs.
    bound = round_off_bounds(arm, motion.q, motion.qd, motion.qdd)["torque"]
    assert np.abs(error - lost).max() <= bound
    assert np.abs(model.accuracy.errors.largest - np.abs(lost).max(axis=0)).max() <= bound + least
    assert set(model.terms.values()) <= {1.0}
    assert model.terms.keys() | {*parts} == {*parts_of(arm.n_joints)}


def dropped_by(model) -> tuple[Part, ...]:
    return tuple(part for part in parts_of(model.arm.n_joints) if part not in model.terms)


def cost_of(arm, parts, drives=False) -> int:
    """Operations that the torque of a selection takes, counted on the program itself."""
    count = ELEMENT.write(ExactForm(arm, drives), dict.fromkeys(parts, 1.0), ROUGH).count
    return count.total + count.sines_cosines


def cheapest_by_trying_all(arm, dataset, allowed, drives=False) -> int:
    """Every one of the 2^12 subsets of a two-joint arm's parts."""
    parts = parts_of(arm.n_joints)
    errors = torque_by_part(dataset, dataset.qdd.values, parts)
    # The error of a subset is linear in it: all subsets in one product.
    dropped = (np.arange(2 ** len(parts))[:, None] >> np.arange(len(parts))) & 1
    lost = np.abs(np.einsum("xp,pit->xit", dropped, errors)).max(axis=2)
    fitting = np.flatnonzero((lost <= allowed).all(axis=1))
    # Dropping more never costs more, so only the largest of the fitting subsets are worth a program.
    as_sets = {int(x) for x in fitting}
    largest = [
        x for x in as_sets if not any((x | 1 << p) in as_sets for p in range(len(parts)) if not x >> p & 1)
    ]
    return min(
        cost_of(arm, [part for p, part in enumerate(parts) if not x >> p & 1], drives) for x in largest
    )


@pytest.mark.parametrize("budget", ["0%", "1%", "5%", "10%", "20%", "40%", "60%", "80%", "5%,50%", "50%,5%"])
def test_no_cheaper_model_of_the_two_link_arm_exists(two_link, swing_dataset, budget):
    model = by_elements(two_link, swing_dataset, Budget.parse(budget))
    assert cost_of(two_link, model.terms) == cheapest_by_trying_all(
        two_link, swing_dataset, model.accuracy.allowed
    )
    assert model.operations.total + model.operations.sines_cosines == cost_of(two_link, model.terms)


@examples(6)
@given(
    arms_with_states(max_joints=2, count=8, massive=True).filter(lambda case: case[0].n_joints == 2),
    st.sampled_from([0.001, 0.03, 0.1, 0.25, 0.5, 0.7]),
    st.booleans(),
)
def test_no_cheaper_model_of_any_two_joint_arm_exists(case, share, drives):
    arm, states = case
    arm = dataclasses.replace(arm, drives=(Drive(0.3), Drive(0.2)))
    motion = Trajectory(np.arange(8.0), states.q, states.qd, states.qdd)
    dataset = decompose(arm, motion, drives=drives)
    model = by_elements(arm, dataset, of_shares(share), drives)
    assert cost_of(arm, model.terms, drives) == cheapest_by_trying_all(
        arm, dataset, model.accuracy.allowed, drives
    )


def test_budget_zero_drops_what_is_zero_only(puma, pick_and_place_dataset):
    model = by_elements(puma, pick_and_place_dataset, of_shares(0.0))
    assert not model.accuracy.errors.largest.any()
    gone = dropped_by(model)
    lost = np.abs(torque_by_part(pick_and_place_dataset, pick_and_place_dataset.qdd.values, gone)).max()
    assert lost <= ROUND_OFF_SHARE * np.abs(pick_and_place_dataset.torque.values).max()
    labels = {part.label for part in gone}
    assert "c1" in labels  # the waist stands upright: gravity never loads it
    assert "c2" not in labels


def test_budget_of_each_joint(puma, pick_and_place_dataset):
    strict = Budget.parse("0.1%,0.1%,0.1%,50%,50%,50%")
    model = by_elements(puma, pick_and_place_dataset, strict)
    shares = model.accuracy.errors.largest_share
    assert (shares <= [0.001, 0.001, 0.001, 0.5, 0.5, 0.5]).all()
    assert shares[3:].max() > 0.001  # the loose joints use what they got
    with pytest.raises(UsageError, match="wrong number of entries"):
        by_elements(puma, pick_and_place_dataset, Budget.parse("1%,1%"))


def test_a_larger_budget_never_costs_more(puma, pick_and_place_dataset):
    counts = [
        by_elements(puma, pick_and_place_dataset, of_shares(share)).operations
        for share in (0.0, 0.001, 0.01, 0.05, 0.2)
    ]
    totals = [count.total + count.sines_cosines for count in counts]
    assert totals == sorted(totals, reverse=True)
    assert totals[-1] < totals[0]


def test_a_joint_without_torque_among_others():
    """Gravity along the axes: the arm feels its own acceleration at joint 2 alone for one set point."""
    flat = dataclasses.replace(two_link_of(1.0, 1.0, 1.0), gravity=np.array([0.0, 0.0, -9.8062]))
    states = (np.zeros((1, 2)), np.zeros((1, 2)), np.array([[-5.0, 16.0]]))
    # tau_1 = (8/3 + 1/2 ...) qdd_1 + (5/6) qdd_2: chosen to cancel up to round-off at q = 0.
    dataset = decompose(flat, Trajectory(np.zeros(1), *states))
    assert abs(dataset.torque.values[0, 0]) <= 1e-13
    model = by_elements(flat, dataset, Budget.parse("1%"))
    assert (model.accuracy.errors.largest <= model.accuracy.allowed).all()


def test_a_model_that_misses_its_budget_is_not_given_out(two_link, swing_dataset, monkeypatch):
    write = type(ELEMENT).write

    def write_nothing(self, form, terms, effort):
        return write(self, form, {}, effort)

    monkeypatch.setattr(type(ELEMENT), "write", write_nothing)
    with pytest.raises(GdAnalyzeError, match="misses its budget"):
        by_elements(two_link, swing_dataset, Budget.parse("1%"))


def test_losses_name_what_went_and_how_much(puma, pick_and_place_dataset):
    model = by_elements(puma, pick_and_place_dataset, Budget.parse("1%"))
    found = losses(model, ExactDynamics.of(puma, pick_and_place_dataset))
    assert {loss.part for loss in found} == {part.label for part in dropped_by(model)}
    shares = [loss.torque_share for loss in found]
    assert shares == sorted(shares, reverse=True)
    parts = {p.label: p for p in parts_of(6)}
    for loss in found:
        torque = np.abs(
            torque_by_part(pick_and_place_dataset, pick_and_place_dataset.qdd.values, (parts[loss.part],))[0]
        ).max(axis=1)
        assert loss.torque_peak == torque[loss.torque_joint - 1]
        assert loss.torque_share <= 1.0


def test_blocks_by_hand():
    """x y is shared by both outputs, + z belongs to the first, cos to the second."""
    trace = Trace()
    x, y, z = trace.inputs("x", 3)[:, 0]
    shared = x * y
    cosine = trace.apply("cos", shared)
    assert blocks(trace, [shared + z, cosine * 2.0, 1.0]) == {
        frozenset({0, 1}): 1,
        frozenset({0}): 1,
        frozenset({1}): 2,
    }


def test_selection_uses_that_errors_cancel():
    """Two parts of 5 N m each and opposite: neither may go alone under 1 N m, both may go together."""
    errors = np.array([[[5.0]], [[-5.0]], [[0.5]]])
    costs = {frozenset({0}): 1, frozenset({1}): 1, frozenset({2}): 1}
    assert select(errors, 1.0, costs)[0].tolist() == [False, False, False]
    assert select(errors[:1], 1.0, {frozenset({0}): 1})[0].tolist() == [True]


def test_selection_holds_huge_errors_against_tiny_budgets():
    """Coefficients of 1e15 exceed a solver's tolerances; the promise must not."""
    errors = np.array([[[1e3, 0.0]], [[1e-13, 1e-13]], [[0.0, 2e-12]]])
    kept, _ = select(errors, 1e-12, {frozenset({p}): 1 for p in range(3)})
    assert kept.tolist() == [True, False, True]


def test_shipped_arms_are_simplified_within_one_percent():
    arm = load_arm("puma560")
    for name in ("large-slew", "pick-and-place", "wrist-move"):
        dataset = decompose(arm, read_trajectory(name, arm))
        model = by_elements(arm, dataset, Budget.parse("1%"))
        assert (model.accuracy.errors.largest_share <= 0.01).all()
        assert model.accuracy.solved
        given = simplify(arm, dataset, Budget.parse("1%"), level="element")
        assert given.operations.total <= given.operations_full.total < model.operations.total
        assert not given.saves
        assert not given.accuracy.errors.largest.any()
        assert set(given.terms) == set(parts_of(6))


@pytest.mark.parametrize(("name", "drives"), [("puma560", False), ("puma560", True), ("two_link", False)])
def test_what_the_search_minimises_is_the_number_of_operations(name, drives, rng):
    """Its price of a selection and the count of that selection's program differ by one constant.

    Every joint keeps its h here: the term that each joint adds for free, having nothing to add it to, is that
    constant. So do D33 .. D36 keep their translation: shoulder and elbow of the PUMA are parallel, and where
    rotation alone is left of D2j and D3j, their products with qdd_j are one more shared than is priced.
    """
    arm = load_arm(name)
    traced, parts = trace_parts(arm), parts_of(arm.n_joints)
    prices = ELEMENT.costs(ExactForm(arm, drives), parts)
    nonzero = np.array([not is_constant(traced.expression(part), 0.0) for part in parts])
    held = {f"h{i} {effect}" for i in range(1, 7) for effect in ("translation", "rotation")}
    held |= {f"D3{j} translation" for j in range(3, 7)}
    always = np.array([part.label in held for part in parts])
    differences = set()
    for _ in range(40):
        keep = nonzero & (always | (rng.random(len(parts)) < rng.random()))
        price = sum(operations for needing, operations in prices.items() if any(keep[p] for p in needing))
        chosen = [part for part, kept in zip(parts, keep, strict=True) if kept]
        differences.add(price - cost_of(arm, chosen, drives))
    assert len(differences) == 1
