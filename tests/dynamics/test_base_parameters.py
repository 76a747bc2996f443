"""Base parameters: as many as the regressor has rank, in its row space, and torque needs nothing else."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics import newton_euler_regrouped
from gd_analyze.dynamics.base_parameters import link_regressor, parameters_of
from gd_analyze.dynamics.newton_euler_link import torque as torque_of_links
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.dynamics.regrouped_links import regrouped
from gd_analyze.dynamics.regrouping import PARAMETER_KINDS
from gd_analyze.robots.frames import standard_placements
from gd_analyze.types import BaseParameters, DHRow, Drive, Joint, Link, Placement, RobotArm
from parallel_axes import arms_with_runs, of_every_turn, scara
from strategies import arms, examples, random_inertia, random_states

# Above it the least direction that acts stands out (2.8e-4 and more in 1500 drawn arms), below it
# is round-off (2.4e-13 and less): some hundred roundings of what a row adds up.
ACTS = 1e-10


def stacked(base: BaseParameters, count: int = 40) -> FloatArray:
    """Rows of joints and states; columns of all parameters, those of drives last if they count."""
    arm, n = base.arm, base.arm.n_joints
    states = random_states(n, count, 0)
    columns = np.moveaxis(link_regressor(arm, *states.last), -1, 1).reshape(n * count, 10 * n)
    if not base.drives:
        return columns
    drives = np.einsum("ij,jn->inj", np.eye(n), states.qdd.T).reshape(n * count, n)
    return np.hstack([columns, drives])


def map_of(base: BaseParameters) -> FloatArray:
    """From all parameters, in the links' own frames, to base parameters."""
    of_drives = np.zeros((len(base), base.arm.n_joints))
    for row, one in zip(of_drives, base, strict=True):
        for coefficient, kind, link in one.combination:
            row[link - 1] += coefficient * (kind == "J")
    return np.hstack([base.matrix.reshape(len(base), -1), of_drives[:, : base.drives * base.arm.n_joints]])


def assert_minimal(base: BaseParameters) -> None:
    """Every row of the regressor is made of the map's rows, and these are as many as its rank."""
    rows, into = stacked(base), map_of(base)
    # Of columns of one size: units differ, and the answer must not hang on theirs.
    sizes = np.linalg.norm(rows, axis=0)
    sizes[sizes <= ACTS * sizes.max(initial=0.0)] = 1.0
    rows, into = rows / sizes, into / sizes
    spread = np.linalg.svd(rows, compute_uv=False)
    assert np.count_nonzero(spread > ACTS * spread[0]) * bool(spread[0] > 0) == len(base)
    if len(base):
        across = np.linalg.svd(into, full_matrices=False)[2]
        # The map is known to round-off over the share at which directions count as told apart.
        assert np.abs(rows - rows @ across.T @ across).max() <= 1e-8 * spread[0]


def with_drives(arm: RobotArm) -> RobotArm:
    return dataclasses.replace(arm, drives=tuple(Drive(inertia=0.1 * (i + 1)) for i in range(arm.n_joints)))


def numbers(base: BaseParameters, of: str = "number") -> FloatArray:
    return np.array([getattr(one, of) for one in base])


@examples(25)
@of_every_turn(drives=True)
@given(st.one_of(arms(max_joints=7), arms_with_runs()), st.booleans())
def test_they_are_minimal_and_the_recursion_needs_nothing_else(arm, drives):
    """Links that have base parameters only, all else zero, ask for the torque of the arm."""
    arm = with_drives(arm)
    base = gd.base_parameters(arm, drives)
    assert_minimal(base)
    states = random_states(arm.n_joints, 6, 1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(newton_euler_regrouped, "regrouped", lambda arm: bare(arm, base))
        found = newton_euler_regrouped.torque(arm, *states.last)
    for one in base:
        if one.kind == "J":
            found[one.link - 1] += one.number * states.last[2][one.link - 1]
    exact = torque_of_links(arm, *states.last)
    of_drives = drives * arm.drive_inertia[:, None] * states.last[2]
    # As two formulations differ; moved inertias and masses that cancel stand for many links' roundings.
    allowed = 80 * round_off_bounds(arm, *states.arrays)["torque"] + 1e-14 * np.abs(of_drives).max()
    assert np.abs(found - exact - of_drives).max() <= allowed


def bare(arm: RobotArm, base: BaseParameters):
    """Links of the recursion with nothing but base parameters."""
    rewritten = regrouped(arm)
    links = []
    for i, link in enumerate(rewritten.links, 1):
        moments = {one.kind: one.number for one in base if one.link == i}
        first = np.array([moments.get(f"m{x}", 0.0) for x in "xyz"])
        second = np.array([[moments.get(f"P{min(x, y)}{max(x, y)}", 0.0) for x in "xyz"] for y in "xyz"])
        mass = moments.get("m", 0.0)
        assert mass == 0 or link.prismatic is not None
        links.append(dataclasses.replace(link, mass=mass, first=first, second=second, is_round=False))
    return dataclasses.replace(rewritten, links=tuple(links))


@examples(25)
@of_every_turn()
@given(st.one_of(arms(max_joints=6), arms_with_runs()))
def test_the_numbers_are_the_map_of_the_arms_parameters(arm):
    base = gd.base_parameters(with_drives(arm))
    without = gd.base_parameters(arm)
    parameters = parameters_of(arm)
    scale = np.abs(without.matrix * parameters).sum(axis=(1, 2))
    # Each is some dozen products, carried along the arm one way and the other.
    found = without.matrix.reshape(len(without), -1) @ parameters.ravel()
    assert (np.abs(found - numbers(without)) <= 1e-12 * (1 + scale)).all()
    for each in (base, without):
        parts = sum(numbers(each, of) for of in ("translation", "rotation", "drive"))
        sizes = sum(np.abs(numbers(each, of)) for of in ("translation", "rotation", "drive"))
        assert (np.abs(parts - numbers(each)) <= 1e-12 * (1 + sizes)).all()


# Published counts: general six and seven joints with the first axis along gravity take 36 and 43, drives add
# one each but those of the first two, which turn with their links about axes across each other.
@pytest.mark.parametrize(
    ("name", "counts"), [("puma560", (36, 40)), ("stanford", (33, 37)), ("two_link", (6,))]
)
def test_counts_of_the_arms_supplied(name, counts):
    for drives, count in enumerate(counts):
        base = gd.base_parameters(name, bool(drives))
        assert len(base) == count
        assert_minimal(base)


def test_a_general_arm_of_seven_joints_has_43():
    """KUKA's LBR, modified axes of Lloyd et al. 2021; published code for its like takes 43 of 70."""
    twists, offsets = [-90, 90, 90, -90, -90, 90, 0], [0.34, 0, 0.4, 0, 0.4, 0, 0.126]
    rng, joints, links = np.random.default_rng(0), [], []
    for i, twist in enumerate(twists):
        before, behind = standard_placements("revolute", DHRow(0.0, offsets[i], 0.0, np.deg2rad(twist)))
        joints.append(Joint(str(i + 1), "revolute", before))
        links.append(Link(str(i + 1), 1.0, rng.uniform(-0.1, 0.1, 3), random_inertia(rng), behind))
    base = gd.base_parameters(RobotArm("lbr", tuple(joints), tuple(links), np.array([0.0, 0.0, -9.81])))
    assert len(base) == 43
    assert_minimal(base)


def test_a_scara_by_name():
    """All axes are parallel: of each turn what is about it, of the slide what it lifts."""
    base = gd.base_parameters(scara())
    assert [one.symbol for one in base] == ["PXX1", "MX2", "MY2", "PXX2", "M3", "MX4", "MY4", "PXX4"]
    assert base["M3"].combination == ((1.0, "m", 3), (1.0, "m", 4))
    assert base["M3"].number == base["M3"].translation == pytest.approx(1.5, rel=1e-15)
    assert [share[1:] for share in base["PXX1"].combination] == [("Pxx", 1), ("Pyy", 1), ("m", 2)]
    assert base["PXX1"].combination[2].coefficient == pytest.approx(0.35**2, rel=1e-14)
    assert {link for kind, link in base.never_acting if kind == "m"} == {1}
    assert base.acting_alone == (("mx", 4), ("my", 4))
    assert_minimal(base)


def test_the_pumas_by_name(puma):
    base = gd.base_parameters(puma)
    forearm = [("mx", 2), *(("m", link) for link in (3, 4, 5, 6))]
    assert [share[1:] for share in base["MX2"].combination] == forearm
    assert [share[0] for share in base["MX2"].combination] == pytest.approx([1.0, *[0.4318] * 4])
    assert base["PYY4"].combination == ((1.0, "Pyy", 4), (1.0, "Pzz", 5))
    assert ("J", 1) in [share[1:] for share in base["PXX1"].combination]
    # The second drive turns with its link across the first axis: as an inertia about its own.
    second = [share[0] for one in base for share in one.combination if share[1:] == ("J", 2)]
    assert second == pytest.approx([-0.5, 0.5, 0.5], rel=1e-12)
    assert base.never_acting == tuple(
        (kind, 1) for kind in PARAMETER_KINDS[:-1] if kind not in ("Pxx", "Pyy")
    )


@pytest.mark.parametrize(("gravity", "at_least", "at_most"), [([0.0, 9.81, 0.0], 38, 38), ([0, 0, 0], 1, 35)])
def test_gravity_decides_what_first_moments_act(puma, gravity, at_least, at_most):
    """Across the first axis it acts on MX1 and MY1; without it nothing but turning tells of them."""
    base = gd.base_parameters(dataclasses.replace(puma, gravity_vector=np.array(gravity, dtype=float)), False)
    assert at_least <= len(base) <= at_most
    assert ({"MX1", "MY1"} < {one.symbol for one in base}) == any(gravity)
    assert_minimal(base)


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_the_size_of_the_arm_does_not_matter(puma, size):
    def grown(parts, name):
        places = [getattr(part, name) for part in parts]
        places = [Placement(place.rotation, size * place.translation) for place in places]
        return tuple(
            dataclasses.replace(part, **{name: place}) for part, place in zip(parts, places, strict=True)
        )

    joints, links = grown(puma.joints, "placement"), grown(puma.links, "frame")
    arm = dataclasses.replace(puma, joints=joints, links=links, dh_table=())
    found, usual = ([[s[1:] for s in one.combination] for one in gd.base_parameters(x)] for x in (arm, puma))
    assert found == usual


def test_a_gantry_is_masses():
    """Three slides, and nothing turns."""
    axes = np.eye(3)
    joints = tuple(Joint(str(i), "prismatic", axis=axis) for i, axis in enumerate(axes, 1))
    links = tuple(Link(str(i), float(i), np.full(3, 0.1), 0.1 * np.eye(3)) for i in (1, 2, 3))
    gantry = RobotArm("gantry", joints, links)
    base = gd.base_parameters(gantry)
    assert [one.symbol for one in base] == ["M1", "M2", "M3"]
    assert base.acting_alone == (("m", 1), ("m", 2), ("m", 3))
    assert {one.unit for one in base} == {"kg"}
    assert_minimal(base)
    # Only against gravity are links heavier than their drives.
    driven = gd.base_parameters(with_drives(gantry))
    assert [one.symbol for one in driven] == ["M1", "M2", "M3", "J3"]
    assert driven["M2"].combination == ((1.0, "m", 2), (1.0, "J", 2))
    assert_minimal(driven)
