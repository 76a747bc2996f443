"""Sweeps: arms from one product of matrices against `decompose` and `rank`; changes against root finding."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.optimize import brentq

import gd_analyze as gd
from gd_analyze import Trajectory
from gd_analyze.dynamics import many_arms
from gd_analyze.dynamics.base_parameters import parameters_of
from gd_analyze.errors import ArmError, UsageError
from gd_analyze.figures.figure import Cells, FigureWords
from gd_analyze.figures.sweep import maps_figure
from gd_analyze.robots.description import describe_in_full, fingerprint
from gd_analyze.robots.varied import VariedArm
from gd_analyze.tables import with_payload

PUMA_A2 = "joint2.a=0.2..0.6:50"


def faster(motion: Trajectory, speed: float) -> Trajectory:
    return Trajectory(motion.time / speed, motion.q, speed * motion.qd, speed**2 * motion.qdd)


def drawn(arm: gd.types.RobotArm) -> Trajectory:
    states = gd.tables.states_in_box(arm, 40, 7)
    return Trajectory(np.arange(40.0), *states.arrays)


@pytest.mark.parametrize("name", list(gd.builtin_arms()))
def test_nothing_changed_is_the_same_arm_to_the_last_bit(name):
    varied = VariedArm(gd.load_arm(name))
    assert fingerprint(varied.at({})) == fingerprint(varied.arm)
    same = {varied.parameter(one): varied.value(varied.parameter(one)) for one in varied.parameters}
    for one, value in same.items():
        again = varied.at({one: value})
        # A product of inertia may be stated as 0, and angles in radians: no more changes.
        np.testing.assert_allclose(parameters_of(again), parameters_of(varied.arm), rtol=1e-15, atol=1e-17)
        np.testing.assert_allclose(again.reach, varied.arm.reach, rtol=1e-15)


@pytest.mark.parametrize(
    ("name", "value"),
    [("link3.mass", 2.5), ("link2.com.y", 0.03), ("link2.com_mm.x", -300.0), ("link4.inertia.xz", 1e-4),
     ("drive2.inertia", 3.0)],
)  # fmt: skip
def test_bodies_are_those_of_the_arm_that_is_read(puma, name, value):
    """Two ways to the same numbers: arrays of bodies, and a file that is read again."""
    varied = VariedArm(puma)
    one = varied.parameter(name)
    bodies, arm = varied.bodies({one: np.array([value])}, 1), varied.at({one: value})
    for ours, theirs in (
        (bodies.mass[0], arm.mass),
        (bodies.com[0], arm.com),
        (bodies.inertia_com[0], arm.inertia_com),
        (bodies.drive_inertia[0], arm.drive_inertia),
    ):
        np.testing.assert_allclose(ours, theirs, rtol=1e-15)
    assert describe_in_full(arm) != describe_in_full(puma)


@pytest.mark.parametrize(
    ("name", "vary"),
    [
        ("puma560", ["link3.mass=2..8:3", "speed=0.3..1.5:2", "link2.com.x=-0.5..0.1:2"]),
        ("stanford", ["joint2.d=0.05..0.3:2", "link4.mass=0.5..2:2", "drive4.inertia=0.1..1:2"]),
        ("two_link", ["gravity.y=-9.81..1:2", "link2.mass=0.5..3:3"]),
    ],
)
@pytest.mark.parametrize("drives", [True, False])
def test_points_are_what_decompose_and_rank_say_of_each_arm(name, vary, drives):
    arm = gd.load_arm(name)
    drives = drives and bool(arm.drives)
    varied, motion = VariedArm(arm), drawn(arm)
    found = gd.sweep(arm, motion, vary, budget="2%", drives=drives, operations="none")
    names = found.parameter.values.tolist()
    flat = found.stack(point=names)
    for k in range(flat.sizes["point"]):
        at = flat.isel(point=k)
        values = dict(zip(names, at.point.item(), strict=True))
        speed = values.pop("speed", 1.0)
        made = varied.at({varied.parameter(one): value for one, value in values.items()})
        dataset = gd.decompose(made, faster(motion, speed), drives=drives)
        torque = np.abs(dataset.torque.values).max(axis=0)
        # Some hundred roundings of sums of terms no larger than the largest torque.
        np.testing.assert_allclose(at.peak_torque.values, torque, rtol=0, atol=1e-13 * torque.max())
        ranking = gd.rank(dataset, budget=0.02)
        labels = ranking.element.values
        assert at.verdict.sel(element=labels).values.tolist() == ranking.verdict.values.tolist()
        parts = np.abs(dataset.coriolis_centrifugal.values).max(axis=0)
        ours = at.contribution.sel(of=["velocity translation", "velocity rotation"]).transpose("of", "joint")
        np.testing.assert_allclose(ours.values, parts, rtol=0, atol=1e-12 * torque.max())
        qdd = dataset.qdd.values
        inertia = np.abs(np.einsum("teij,tj->tei", dataset.inertia.values, qdd)).max(axis=0)
        ours = at.contribution.sel(of=["inertia translation", "inertia rotation"]).transpose("of", "joint")
        np.testing.assert_allclose(ours.values, inertia, rtol=0, atol=1e-12 * torque.max())
        without = np.abs(dataset.coriolis_centrifugal.values.sum(axis=1)).max(axis=0) <= 0.02 * torque
        expected = np.where(without, "within budget", "beyond budget").tolist()
        assert at.verdict.values[len(labels) :].tolist() == expected


@pytest.mark.slow
def test_the_shoulder_to_elbow_length_of_the_puma(puma, pick_and_place):
    """Three verdicts change with a2; where, root finding on what `rank` measures says as well."""
    found = gd.sweep(puma, pick_and_place, PUMA_A2, operations="none")
    changes = {
        element: (before, after, at, seen)
        for element, before, after, at, seen in zip(
            found.change_element.values.tolist(),
            found.change_from.values.tolist(),
            found.change_to.values.tolist(),
            found.change_at.values[:, 0].tolist(),
            found.change_seen.values.tolist(),
            strict=True,
        )
    }
    assert {key: one[:2] for key, one in changes.items()} == {
        "h3": ("both", "translation"),
        "h4": ("negligible", "both"),
        "D15": ("both", "translation"),
    }
    varied = VariedArm(puma)
    length = varied.parameter("joint2.a")

    def beyond(element: str, at: float) -> float:
        dataset = gd.decompose(varied.at({length: at}), pick_and_place, christoffel=False)
        row = gd.rank(dataset)
        one = row.sel(element=element)
        if element == "h4":  # joint 4's row: six elements of D, h, c share its allowed error
            return float(one.torque_peak) - row.attrs["floor"][3]
        return float(one.change_without.sel(effect="rotation")) - 0.1

    for element, (_, _, at, seen) in changes.items():
        root = brentq(lambda length, element=element: beyond(element, length), at - 2e-3, at + 2e-3)
        # Bisected to a 5000th of the range of 0.4 m; the value told is the middle.
        assert abs(at - root) <= 4.1e-5
        assert at < seen <= at + 0.4 / 49
    # The grid's first points beyond: what a sweep without bisection would tell.
    assert [round(changes[key][3], 3) for key in ("h3", "D15", "h4")] == [0.233, 0.469, 0.453]


@pytest.mark.slow
def test_lines_of_two_parameters_lie_where_one_of_them_changes_the_verdict(puma, pick_and_place):
    both = gd.sweep(
        puma, pick_and_place, ["joint2.a=0.2..0.6:3", "link3.mass=1..8:3"], operations="none", precision=2e-3
    )
    lines = both.isel(change=both.change_parameter.values == "joint2.a")
    assert lines.sizes["change"] >= 4
    assert set(both.change_parameter.values.tolist()) == {"joint2.a", "link3.mass"}
    mass = VariedArm(puma).parameter("link3.mass")
    for value in np.unique(lines.change_at.values[:, 1]):
        arm = VariedArm(puma).at({mass: float(value)})
        alone = gd.sweep(arm, pick_and_place, "joint2.a=0.2..0.6:3", operations="none", precision=2e-3)
        here = lines.isel(change=lines.change_at.values[:, 1] == value)
        assert here.change_element.values.tolist() == alone.change_element.values.tolist()
        np.testing.assert_allclose(here.change_at.values[:, 0], alone.change_at.values[:, 0], atol=1e-12)


@pytest.mark.slow
def test_two_changes_between_neighbours_are_both_found(puma, pick_and_place):
    coarse = gd.sweep(puma, pick_and_place, "joint2.a=0.1..0.6:2", operations="none")
    fine = gd.sweep(puma, pick_and_place, "joint2.a=0.1..0.6:26", operations="none")
    of_h4 = [x.isel(change=x.change_element.values == "h4") for x in (coarse, fine)]
    assert of_h4[0].change_to.values[-1] == of_h4[1].change_to.values[-1]
    for element in set(coarse.change_element.values.tolist()):
        ours = coarse.change_at.values[coarse.change_element.values == element, 0]
        theirs = fine.change_at.values[fine.change_element.values == element, 0]
        assert np.abs(ours[:, None] - theirs).min(axis=1).max() <= 1e-4  # a 5000th of 0.5 m


def test_no_precision_is_that_of_the_numbers(two_link, swing):
    """Bisection ends where there is nothing between two numbers."""
    found = gd.sweep(two_link, swing, "link2.mass=0.01..8:3", precision=0.0, operations="none")
    near = gd.sweep(two_link, swing, "link2.mass=0.01..8:3", precision=1e-9, operations="none")
    assert found.sizes["change"] == near.sizes["change"] > 0
    np.testing.assert_allclose(found.change_at.values, near.change_at.values, atol=1e-8)


def test_draws_are_uniform_repeat_and_are_points_of_a_grid(puma, pick_and_place):
    vary = ["link3.mass=1..5", "link3.com_mm.z=50..90"]
    found = gd.sweep(puma, pick_and_place, vary, samples=400, seed=3)
    again = gd.sweep(puma, pick_and_place, vary, samples=400, seed=3)
    assert found.identical(again)
    assert not found.identical(gd.sweep(puma, pick_and_place, vary, samples=400, seed=4))
    mass = found["link3.mass"].values
    assert mass.min() >= 1.0
    assert mass.max() <= 5.0
    # The standard error of the mean of 400 is 0.06 kg.
    assert abs(mass.mean() - 3.0) < 0.3
    assert found.sizes["change"] == 0
    assert found.operations.isnull().all()
    one = VariedArm(puma)
    chosen = {one.parameter(name): float(found[name][7]) for name in ("link3.mass", "link3.com_mm.z")}
    torque = np.abs(gd.decompose(one.at(chosen), pick_and_place).torque.values).max(axis=0)
    np.testing.assert_allclose(found.peak_torque.values[7], torque, rtol=1e-12)


def test_set_points_and_arms_in_blocks_are_as_those_at_once(puma, monkeypatch):
    motion, vary = drawn(puma), ["link3.mass=1..5:7", "speed=0.5..1:2"]
    whole = gd.sweep(puma, motion, vary, operations="none")
    monkeypatch.setattr(many_arms, "SET_POINTS_AT_ONCE", 7)
    monkeypatch.setattr(many_arms, "CELLS_AT_ONCE", 21)
    parts = gd.sweep(puma, motion, vary, operations="none")
    assert (parts.verdict == whole.verdict).all()
    np.testing.assert_allclose(parts.contribution.values, whole.contribution.values, rtol=1e-12, atol=1e-13)


@pytest.mark.slow
def test_processes_give_what_one_gives(two_link, swing):
    vary = ["joint1.a=0.5..1.5:3", "link2.mass=0.5..4:3"]
    assert gd.sweep(two_link, swing, vary, jobs=2).identical(gd.sweep(two_link, swing, vary))


def test_operations_are_those_of_the_models(two_link, swing):
    found = gd.sweep(two_link, swing, "link2.mass=0.5..2:3", budget="5%", operations="term")
    varied = VariedArm(two_link)
    for value, operations in zip(found["link2.mass"].values, found.operations.values, strict=True):
        arm = varied.at({varied.parameter("link2.mass"): float(value)})
        assert gd.simplify(arm, swing, "5%", level="term").operations.total == operations
    quick = gd.sweep(two_link, swing, "link2.mass=0.5..2:3", budget="5%")
    # Terms left by size alone: as many as the search finds, or some more.
    assert (quick.operations.values >= 0.9 * found.operations.values).all()
    assert (quick.operations.values <= 1.5 * found.operations.values + 5).all()


@pytest.mark.parametrize(
    ("vary", "more", "says"),
    [
        (["link3.mas=1..2"], {}, "link3.mass"),
        (["link9.mass=1..2"], {}, "link9.mass"),
        (["joint2.a_deg=1..2"], {}, "joint2.a_deg"),
        (["link3.mass"], {}, "NAME=LOW..HIGH"),
        (["link3.mass=5..1"], {}, "lower one first"),
        (["link3.mass=1..1"], {}, "lower one first"),
        (["link3.mass=1..1e13"], {}, "link3.mass"),
        (["link3.mass=1..5:1"], {}, "two values"),
        (["speed=0..1"], {}, "speed=0..1"),
        (["link3.mass=1..5", "link3.mass=1..5"], {}, "once"),
        (["joint2.a=0.1..0.5", "joint2.a_mm=1..5"], {}, "once"),
        ([], {}, "once"),
        (["link3.mass=1..5:9"], {"samples": 9}, "leave out :COUNT"),
        (["link3.mass=1..5:2000", "speed=1..2:2000"], {}, "4000000"),
        (["link3.mass=1..5"], {"budget": "uncertainty"}, "uncertainty"),
        (["link3.mass=1..5"], {"budget": "1% norm"}, "norm"),
        (["link3.mass=1..5"], {"samples": 10**12}, "1000000000000"),
    ],
)
def test_what_cannot_be_varied_is_told(puma, pick_and_place, vary, more, says):
    with pytest.raises(UsageError) as caught:
        gd.sweep(puma, pick_and_place, vary, **more)
    assert says in str(caught.value)


@pytest.mark.parametrize(
    ("vary", "found"),
    [
        ("link3.mass=-1..5:3", "-1 kg"),
        ("drive1.inertia=-1..1:3", "-1 kg m^2"),
        ("link1.inertia.zz=-0.1..1:2", "-0.1 kg m^2"),
        ("link4.inertia.zz=0.1..1:2", "0.1 kg m^2"),
        ("link4.inertia.xy=0..1:3", "0.5 kg m^2"),
    ],
)
def test_an_arm_that_cannot_be_is_refused_with_the_value(puma, pick_and_place, vary, found):
    name = vary.partition("=")[0]
    with pytest.raises(ArmError) as caught:
        gd.sweep(puma, pick_and_place, vary, operations="none")
    assert f"--vary {name}" in str(caught.value)
    assert found in str(caught.value)


@pytest.mark.slow
def test_a_payload_and_a_placed_arm_can_be_swept(pick_and_place, puma):
    carrying = with_payload(puma, 2.0, [0.0, 0.0, 0.1])
    found = gd.sweep(carrying, pick_and_place, "joint2.a=0.3..0.5:2", operations="none")
    assert (
        found.peak_torque.values[0, 1]
        > gd.sweep(puma, pick_and_place, "joint2.a=0.3..0.5:2", operations="none").peak_torque.values[0, 1]
    )
    placed = dataclasses.replace(puma, dh_table=(), convention="")
    with pytest.raises(UsageError, match="xyz"):
        gd.sweep(placed, pick_and_place, "joint2.xy=0..1")
    # In placements a2 is the offset of link 2's frame.
    ours = gd.sweep(placed, pick_and_place, "link2.frame_xyz.x=0.3..0.5:3", operations="none")
    theirs = gd.sweep(puma, pick_and_place, "joint2.a=0.3..0.5:3", operations="none")
    np.testing.assert_allclose(ours.peak_torque.values, theirs.peak_torque.values, rtol=1e-12)


def test_a_map_that_hardly_varies_is_hardly_shaded_and_has_a_bar_of_its_shades(two_link, swing):
    grid = gd.sweep(two_link, swing, ["link2.mass=1..1.002:3", "link1.mass=1..1.002:3"], operations="none")
    panel = next(panel for *_, panel in maps_figure(grid).places if panel.key == "peak torque 1")
    shades, bar = (item.opacity for item in panel.items if isinstance(item, Cells))
    # The torque varies by 0.3 % of itself at most, a thirtieth of the least range of shades.
    assert np.ptp(shades) <= 0.1
    assert (bar.min(), bar.max()) == (pytest.approx(0.1), pytest.approx(1.0))
    low, high = (float(item.text) for item in panel.items if isinstance(item, FigureWords))
    assert low == pytest.approx(float(grid.peak_torque[..., 0].min()), rel=1e-3)
    assert high == pytest.approx(1.1 * low, rel=1e-2)
