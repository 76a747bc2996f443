"""Dominance at every set point: against a loop over the text's equations, and what must add up."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

import gd_analyze as gd
from gd_analyze.dynamics import generalized_dalembert as dalembert
from gd_analyze.dynamics.dominance_over_time import stretches
from gd_analyze.dynamics.kinematics import solve_kinematics
from strategies import examples, motions

EPS = float(np.finfo(float).eps)


def by_the_text(arm: gd.RobotArm, motion: gd.Trajectory) -> dict[str, np.ndarray]:
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


@examples(100)
@given(motions(max_joints=6, count=8, massive=True))
def test_every_share_is_that_of_a_loop_over_the_texts_equations(case):
    arm, motion = case
    over_time = gd.dominance_over_time(gd.decompose(arm, motion))
    verdict = gd.verdicts(over_time)
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
            words = {(True, True): "both", (True, False): "translation", (False, True): "rotation"}
            if min(abs(abs(parts[k]) / peak - 0.1)) > 3 * noise / peak:
                assert verdict.sel(element=label).values[k] == words.get(tuple(needed), "zero")


@examples(50)
@given(motions(max_joints=5))
def test_shares_sum_to_one_and_verdicts_to_that_of_the_motion(case):
    arm, motion = case
    dataset = gd.decompose(arm, motion)
    ranking = gd.rank(dataset, christoffel=True)
    over_time = gd.dominance_over_time(dataset, ranking)
    total, largest = over_time.share.sum("effect", skipna=False), np.abs(over_time.share).max("effect")
    known = ~np.isnan(total.values)
    # Each share has the rounding of one division.
    assert (np.abs(total.values - 1) <= 2 * EPS * (1 + largest.values))[known].all()
    union = over_time.needed.any("time").values @ [1, 2]
    words = np.array(["zero", "translation", "rotation", "both"])[union]
    assert words.tolist() == ranking.dominant.values.tolist()
    assert np.allclose(np.abs(over_time.torque).max("time"), ranking.torque_peak, rtol=1e-12, atol=0)
    assert (np.abs(over_time.dominance.sum("effect")).max("time") <= 1 + 4 * EPS).all()


def test_what_h_ijk_make_adds_up_to_h():
    dataset = gd.decompose("puma560", "pick-and-place")
    ranking = gd.rank(dataset, christoffel=True)
    over_time = gd.dominance_over_time(dataset, ranking)
    for i in range(1, 7):
        row = (ranking.quantity == "christoffel") & (ranking.i == i)
        h = over_time.torque.sel(element=f"h{i}")
        # 21 products, each rounded at its own size.
        assert np.abs(over_time.torque[:, row.values].sum("element") - h).max() <= 50 * EPS * np.abs(h).max()


def test_the_motion_in_stretches():
    """D25 of the PUMA: its translational part vanishes in the middle of the motion."""
    over_time = gd.dominance_over_time(gd.decompose("puma560", "pick-and-place", drives=False))
    every = stretches(over_time)
    found = every["D25"]
    assert [stretch["verdict"] for stretch in found] == ["both", "rotation", "both"]
    assert found[0]["begin"] == 0
    assert found[-1]["end"] == over_time.time.values[-1]
    assert [stretch["verdict"] for stretch in every["D45"]] == ["zero"]


def test_budget_shares_are_of_what_is_allowed_at_the_joint():
    dataset = gd.decompose("puma560", "pick-and-place")
    allowed = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    over_time = gd.dominance_over_time(dataset, gd.rank(dataset, budget=allowed))
    shares = np.abs(over_time.torque) / allowed[over_time.torque_joint.values - 1]
    assert np.allclose(over_time.budget_share, shares, rtol=4 * EPS)
    d12 = over_time.torque.sel(element="D12")
    joint = int(d12.torque_joint)
    expected = dataset.inertia.sum("effect").values[:, 0, 1] * dataset.qdd.values[:, 2 - joint]
    assert np.allclose(d12, expected, rtol=4 * EPS)


def test_without_h_ijk_they_cannot_be_ranked():
    dataset = gd.decompose("puma560", "pick-and-place", christoffel=False)
    with pytest.raises(gd.GdAnalyzeError, match="christoffel"):
        gd.rank(dataset, christoffel=True)
