"""Dominance at every set point: against a loop over the text's equations, and what must add up."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.dynamics import generalized_dalembert as dalembert
from gd_analyze.dynamics.dominance_over_time import stretches
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.results.verdict_lists import LISTS, verdict_lists
from gd_analyze.types import Drive
from strategies import examples, motions

EPS = float(np.finfo(float).eps)


def by_the_text(arm: gd.types.RobotArm, motion: gd.Trajectory) -> dict[str, np.ndarray]:
    """D and h by effect from the text's sums over links, (N, 2) each, [FGL87] (3.4-25) to (3.4-27)."""
    kinematics = solve_kinematics(arm, motion.q.T)
    inertia = dalembert.inertia_by_link(arm, kinematics).sum(axis=1)
    terms = dalembert.coriolis_centrifugal_by_link(arm, kinematics, motion.qd.T).sum(axis=1)
    effects = np.array([term.effect for term in dalembert.terms_of(arm)])
    velocity = np.stack([terms[effects == effect].sum(axis=0) for effect in dalembert.EFFECTS])
    found = {}
    for i in range(arm.n_joints):
        found[f"h{i + 1}"] = velocity[:, i].T
        for j in range(i, arm.n_joints):
            found[f"D{i + 1}{j + 1}"] = inertia[:, i, j].T
    return found


@examples(50)
@given(motions(max_joints=6, count=8, massive=True))
def test_every_share_is_that_of_a_loop_over_the_texts_equations(case):
    arm, motion = case
    over_time = gd.tables.dominance_over_time(gd.decompose(arm, motion))
    verdict = gd.tables.verdicts(over_time)
    found = by_the_text(arm, motion)
    # Sums of some hundred products as large as the largest element of D, times squared velocities for h.
    largest = {"D": max(np.abs(v).max() for k, v in found.items() if k[0] == "D")}
    largest["h"] = largest["D"] * np.abs(motion.qd).max() ** 2
    for label, parts in found.items():
        ours, peak = over_time.sel(element=label), np.abs(parts.sum(axis=1)).max()
        noise = 500 * EPS * largest[label[0]]
        if peak <= 1e3 * noise:
            continue
        for k in range(motion.n_set_points):
            whole, needed = parts[k].sum(), []
            for effect, part in enumerate(parts[k]):
                share = part / peak
                assert abs(ours.dominance.values[k, effect] - share) <= 3 * noise / peak
                needed.append(abs(share) > 0.1)
                # A share is as uncertain as part and whole are, each over the whole.
                if abs(whole) > 1e3 * noise:
                    bound = 2 * noise / abs(whole) * (1 + abs(part / whole))
                    assert abs(ours.share.values[k, effect] - part / whole) <= bound
            if min(abs(abs(parts[k]) / peak - 0.1)) > 3 * noise / peak:
                assert ours.needed.values[k].tolist() == needed
            words = {(True, True): "both", (True, False): "translation", (False, True): "rotation"}
            if any(ours.needed.values[k]) and verdict.sel(element=label).values[k] != "negligible":
                assert verdict.sel(element=label).values[k] == words[tuple(ours.needed.values[k].tolist())]


@examples(50)
@given(motions(max_joints=5))
def test_shares_sum_to_one_and_needed_parts_to_those_of_the_motion(case):
    arm, motion = case
    dataset = gd.decompose(arm, motion)
    ranking = gd.rank(dataset, christoffel=True)
    over_time = gd.tables.dominance_over_time(dataset, ranking)
    total, largest = over_time.share.sum("effect", skipna=False), np.abs(over_time.share).max("effect")
    known = ~np.isnan(total.values)
    # Each share has the rounding of one division.
    assert (np.abs(total.values - 1) <= 2 * EPS * (1 + largest.values))[known].all()
    union = over_time.needed.any("time").values @ [1, 2]
    words = np.array(["zero", "translation", "rotation", "both"])[union]
    assert words.tolist() == ranking.dominant.values.tolist()
    assert np.allclose(np.abs(over_time.torque).max("time"), ranking.torque_peak, rtol=1e-12, atol=0)
    assert (np.abs(over_time.dominance.sum("effect")).max("time") <= 1 + 4 * EPS).all()


# What represents an element over the motion, and at a set point where it counts.
WITHIN = {
    "gravity": {"gravity"},
    "translation": {"translation"},
    "rotation": {"rotation"},
    "both": {"translation", "rotation", "both"},
    "drive": set(),
}


@examples(30)
@given(motions(max_joints=5, count=8), st.floats(1e-6, 0.5), st.booleans())
def test_verdicts_over_the_motion_are_made_of_those_at_its_set_points(case, budget, driven):
    """Negligible over the motion is negligible at every set point, where the torque is at most its share."""
    arm, motion = case
    if driven:
        arm = dataclasses.replace(arm, drives=tuple(Drive(0.01 * (k + 1)) for k in range(arm.n_joints)))
    dataset, n = gd.decompose(arm, motion), arm.n_joints
    ranking = gd.rank(dataset, budget=budget)
    over_time = gd.tables.dominance_over_time(dataset, ranking)
    for label in ranking.element.values:
        whole, at = ranking.sel(element=label), over_time.sel(element=label)
        words_at = gd.tables.verdicts(over_time).sel(element=label).values
        verdict, words = str(whole.verdict.values), set(words_at.tolist())
        if verdict in ("zero", "negligible"):
            assert words == {verdict}
        else:
            beside = {"negligible", "drive"} if whole.drive else {"negligible"}
            assert words - beside <= WITHIN[verdict]
            assert verdict in words or verdict == "both"
            assert words - {"negligible"}
        # The same quotients, largest first or last.
        assert whole.consequence == at.consequence.max()
        assert np.array_equal(whole.part_consequence, at.part_consequence.max("time"))
        # A share and its limit are each one division.
        small = at.consequence * (n + 2) <= 1 + 4 * EPS
        assert small.values[np.isin(words_at, ["zero", "negligible"])].all()
        assert (
            (at.consequence * (n + 2) >= 1 - 4 * EPS).values[~np.isin(words_at, ["zero", "negligible"])].all()
        )
        driving = at.part_consequence.values[words_at == "drive"]
        # Parts that have one sign, as on the diagonal of D, make no more than their sum.
        assert (driving[:, :2].sum(axis=1) * (n + 2) <= 1 + 8 * EPS).all()


def test_the_puma_in_verdicts():
    """Its wrist is moved by drives; half of the elements count at some set points only."""
    dataset = gd.decompose("puma560", "pick-and-place")
    ranking = gd.rank(dataset)
    is_small = gd.tables.verdicts(gd.tables.dominance_over_time(dataset, ranking)) == "negligible"
    # 17 elements by their links' torque alone; as the drive of joint 6 counts, so does D66.
    assert (is_small.any("time") & ~is_small.all("time")).sum() == 18
    lists = verdict_lists(ranking)
    assert sorted(label for name in LISTS for label in lists.labels(name)) == sorted(ranking.element.values)
    for name, some in lists.lists.items():
        shares = [row.torque_share for row in some]
        assert shares == sorted(shares, reverse=True), name
    assert lists.labels("translation") == ["h3", "D13", "D12"]
    assert lists.labels("drive") == ["D66"]
    assert set(lists.labels("zero")) == {"D45", "D56", "c1", "c6"}
    peak = np.abs(dataset.torque).max("time").values
    drives = np.abs(dataset.drive_torque).max("time").values
    assert [(row.joint, row.element) for row in lists.drives] == [(4, "D44"), (5, "D55"), (6, "D66")]
    # Products J qdd in another order: two roundings each.
    assert np.allclose([row.share for row in lists.drives], (drives / peak)[3:], rtol=4 * EPS, atol=0)
    assert not verdict_lists(gd.rank(gd.decompose("puma560", "pick-and-place", drives=False))).drives


def test_what_h_ijk_make_adds_up_to_h():
    dataset = gd.decompose("puma560", "pick-and-place")
    ranking = gd.rank(dataset, christoffel=True)
    over_time = gd.tables.dominance_over_time(dataset, ranking)
    for i in range(1, 7):
        row = (ranking.quantity == "christoffel") & (ranking.i == i)
        h = over_time.torque.sel(element=f"h{i}")
        # 21 products, each rounded at its own size.
        assert np.abs(over_time.torque[:, row.values].sum("element") - h).max() <= 50 * EPS * np.abs(h).max()


def test_the_motion_in_stretches():
    """D25 of the PUMA: its translational part vanishes in the middle of the motion."""
    over_time = gd.tables.dominance_over_time(gd.decompose("puma560", "pick-and-place", drives=False))
    every = stretches(over_time)
    found = every["D25"]
    assert [stretch["verdict"] for stretch in found if stretch["verdict"] != "negligible"] == [
        "both", "rotation", "both",
    ]  # fmt: skip
    assert found[0]["begin"] == 0
    assert found[-1]["end"] == over_time.time.values[-1]
    assert [stretch["verdict"] for stretch in every["D45"]] == ["zero"]
    middle = over_time.time.values[15]
    parted = stretches(over_time, [0.0, middle])["D45"]
    assert [stretch["begin"] for stretch in parted] == [0.0, middle]
    assert parted[0]["end"] == over_time.time.values[14]


def test_consequences_are_of_what_is_allowed_at_the_joint():
    dataset = gd.decompose("puma560", "pick-and-place")
    allowed = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    over_time = gd.tables.dominance_over_time(dataset, gd.rank(dataset, budget=allowed))
    moved = np.abs(dataset.inertia.sum("effect").values[:, 0, 1])
    shares = np.maximum(
        moved * np.abs(dataset.qdd.values[:, 1]) / 1.0, moved * np.abs(dataset.qdd.values[:, 0]) / 2.0
    )
    assert np.allclose(over_time.consequence.sel(element="D12"), shares, rtol=4 * EPS)
    whole = dataset.inertia.sum("effect").values[:, 3, 3] + dataset.attrs["drive_inertia"][3]
    shares = np.abs(whole * dataset.qdd.values[:, 3]) / 4.0
    assert np.allclose(over_time.consequence.sel(element="D44"), shares, rtol=4 * EPS)
    d12 = over_time.torque.sel(element="D12")
    joint = int(d12.torque_joint)
    expected = dataset.inertia.sum("effect").values[:, 0, 1] * dataset.qdd.values[:, 2 - joint]
    assert np.allclose(d12, expected, rtol=4 * EPS)


def test_without_h_ijk_they_cannot_be_ranked():
    dataset = gd.decompose("puma560", "pick-and-place", christoffel=False)
    with pytest.raises(gd.GdAnalyzeError, match="christoffel"):
        gd.rank(dataset, christoffel=True)
