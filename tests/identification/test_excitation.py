"""Exciting motions: within limits between the set points too, from rest to rest, better than chance."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze import base_parameters, exciting_motion
from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.base_parameters import link_regressor
from gd_analyze.errors import GdAnalyzeWarning, TorqueLimitWarning, TrajectoryError, UsageError
from gd_analyze.identification.expected_equations import ExpectedEquations
from gd_analyze.identification.fourier_series import FourierSeries
from gd_analyze.robots.limits import box_limits
from gd_analyze.types import Drive, Workspace
from long_cases import long

# s, and so many set points that their step is 0.25 ms: a thousandth of the fastest harmonic's period.
DURATION, DENSE = 5.0, 20_001
EPS = np.finfo(float).eps


def without_wrist(arm: gd.types.RobotArm) -> gd.types.RobotArm:
    first = {name: getattr(arm, name)[:3] for name in ("joints", "links", "drives")}
    return dataclasses.replace(arm, **first, dh_table=())


@pytest.fixture(scope="module", params=["two_link", "puma560"])
def dense(request: pytest.FixtureRequest) -> tuple[gd.types.RobotArm, gd.Plan]:
    """Two parallel axes, or three that are not: six joints take ten times as long."""
    arm = gd.load_arm(request.param)
    arm = without_wrist(arm) if request.param == "puma560" else arm
    return arm, exciting_motion(arm, DURATION, DENSE)


def told(arm: gd.types.RobotArm, states: FloatArray) -> float:
    """Log of the determinant for the links alone, q, qd and qdd of shape (3, n, N)."""
    base = base_parameters(arm, drives=False).matrix.reshape(-1, 10 * arm.n_joints)
    rows = link_regressor(arm, *states).reshape(arm.n_joints, 10 * arm.n_joints, -1)
    columns = np.einsum("ipN,pk->iNk", rows, np.linalg.pinv(base)).reshape(-1, len(base))
    return float(2.0 * np.log(np.linalg.svd(columns, compute_uv=False)).sum())


def states_of(motion: gd.Trajectory) -> FloatArray:
    return np.array([motion.q.T, motion.qd.T, motion.qdd.T])


def largest_torque(arm: gd.types.RobotArm, made: gd.Plan) -> FloatArray:
    motion = made.trajectory
    return np.abs(gd.types.ArmDynamics(arm).torque(motion.q, motion.qd, motion.qdd)).max(axis=0)


def test_limits_hold_between_the_set_points(dense):
    arm, made = dense
    motion = made.trajectory
    assert (motion.q >= arm.limits("lower")).all()
    assert (motion.q <= arm.limits("upper")).all()
    assert (np.abs(motion.qd) <= arm.limits("velocity_limit")).all()
    assert (np.abs(motion.qdd) <= arm.limits("acceleration_limit")).all()
    assert made.limits.violations == ()
    # The report's instants are about 1000 to 3000, and an extreme lies half a step from one at most: of the
    # fastest harmonic, with 300 instants in its period, cos(pi / 300) = 1 - 5.5e-5 shows at least.
    for row, values in zip(made.limits.rows, motion.qd.T, strict=True):
        assert row.velocity == pytest.approx(np.abs(values).max(), rel=1e-4)


def test_every_joint_uses_a_limit(dense):
    _, made = dense
    for row in made.limits.rows:
        joint = row.joint
        used = (
            (row.highest - row.lowest) / (joint.upper - joint.lower),
            row.velocity / joint.velocity_limit,
            row.acceleration / joint.acceleration_limit,
        )
        # Of every limit cos(pi / 30) = 0.9945 is used at the instants judged.
        assert max(used) > 0.99


def test_the_motion_begins_and_ends_at_rest_at_one_place(dense):
    _, made = dense
    motion = made.trajectory
    assert not motion.qd[[0, -1]].any()
    assert not motion.qdd[[0, -1]].any()
    assert (motion.q[0] == motion.q[-1]).all()
    assert made.knot_times.tolist() == [0.0, DURATION]
    assert made.shortest_duration is None


def test_rest_is_no_jump(dense):
    """The ends are set to zero; the series has to be there by itself."""
    _, made = dense
    motion = made.trajectory
    step = DURATION / (DENSE - 1)
    fastest = 2.0 * np.pi * 12 / DURATION  # no series has more than twelve harmonics
    # By Bernstein's inequality a derivative of a trigonometric polynomial is its size times the fastest
    # frequency at most.
    assert (np.abs(motion.qdd[1]) <= step * fastest * np.abs(motion.qdd).max(axis=0)).all()
    assert (np.abs(motion.qdd[-2]) <= step * fastest * np.abs(motion.qdd).max(axis=0)).all()


def test_derivatives_are_those_of_the_positions(dense):
    _, made = dense
    motion = made.trajectory
    step, fastest = DURATION / (DENSE - 1), 2.0 * np.pi * 12 / DURATION
    for values, slope in ((motion.q, motion.qd), (motion.qd, motion.qdd)):
        central = (values[2:] - values[:-2]) / (2.0 * step)
        # Central differences leave a sixth of step^2 times the third derivative (Bernstein: fastest^2 times
        # the first), and the round-off of sums of 25 waves over a step.
        size = np.abs(slope).max(axis=0)
        left = step**2 / 6.0 * fastest**2 * size + 25 * EPS * np.abs(values).max(axis=0) / step
        assert (np.abs(central - slope[1:-1]) <= left).all()


def test_it_tells_more_than_any_random_series(dense):
    arm, made = dense
    family = FourierSeries(box_limits(arm), DURATION)
    time = np.linspace(0.0, DURATION, 201)
    drawn = family.within_limits(family.random(np.random.default_rng(1), 40).reshape(40, -1))
    chance = max(told(arm, family.motion(each, time)) for each in drawn)
    found = told(arm, states_of(made.trajectory)[:, :, :: (DENSE - 1) // 200])
    parameters = len(base_parameters(arm, drives=False))
    # On the average the variance of every parameter is less by a fifth: exp(-0.22) = 0.8. That of friction
    # and drives, which the search minimises as well, is left out here.
    assert found > chance + 0.22 * parameters


def test_any_series_keeps_within_the_limits(puma):
    limits = box_limits(puma)
    family = FourierSeries(limits, DURATION)
    rng = np.random.default_rng(2)
    x = family.random(rng, 50)
    x[..., -2], x[..., -1] = rng.uniform(size=(2, *x.shape[:2]))
    x[:10, :, -1] = 1.0
    q, qd, qdd = family.motion(family.within_limits(x.reshape(50, -1)), np.linspace(0.0, DURATION, 3001))
    # Round-off of sums of 25 waves; the limits themselves are met with a margin that theory gives.
    slack = 1.0 + 25 * EPS
    room = limits.upper - limits.lower
    assert (np.abs(q - (limits.upper + limits.lower)[:, None] / 2.0) <= slack * room[:, None] / 2.0).all()
    assert (np.abs(qd) <= slack * limits.velocity[:, None]).all()
    assert (np.abs(qdd) <= slack * limits.acceleration[:, None]).all()


def test_the_slope_of_the_determinant(two_link):
    limits = box_limits(two_link)
    equations = ExpectedEquations(two_link, limits)
    rng = np.random.default_rng(3)
    states, way = rng.uniform(-1.0, 1.0, (2, 3, 2, 12))
    step = 1e-4
    after, before = (equations.log_determinant(states + side * step * way)[0] for side in (1, -1))
    slope = float((equations.log_determinant(states)[1] * way).sum())
    # A step of 1e-6 to one side, times a curvature of a hundred or so: 1e-4 of a slope of about one.
    assert slope == pytest.approx((after - before) / (2.0 * step), abs=1e-3)


@pytest.mark.parametrize(
    ("lower", "upper"), [long([-0.2, -2.0, -1.0], [2.0, 2.0, 1.0]), ([0.5, 0.2, -1.0], [0.8, 0.5, 1.0])]
)
def test_the_end_effector_keeps_within_its_box(two_link, lower, upper):
    made = exciting_motion(two_link, DURATION, DENSE, within=Workspace(lower, upper))
    first, second = made.trajectory.q[:, 0], made.trajectory.q.sum(axis=1)
    # Two links of 1 m.
    x, y = np.cos(first) + np.cos(second), np.sin(first) + np.sin(second)
    assert lower[0] <= x.min() < x.max() <= upper[0]
    assert lower[1] <= y.min() < y.max() <= upper[1]
    assert made.limits.violations == ()


def test_a_box_out_of_reach_is_refused(two_link):
    with pytest.raises(UsageError) as refused:
        exciting_motion(two_link, DURATION, within=Workspace([5, 5, 5], [6, 6, 6]))
    assert refused.value.details["where"] == "within"


@pytest.mark.parametrize(
    ("lower", "upper"),
    [([0, 0, 0], [1, 0, 1]), ([0, 0], [1, 1]), ([0, 0, np.nan], [1, 1, 1]), ([0, 0, 0], [1, 1, np.inf])],
)
def test_a_box_that_is_none(lower, upper):
    with pytest.raises(UsageError):
        Workspace(lower, upper)


@pytest.mark.slow
def test_the_same_seed_plans_the_same_motion(two_link):
    made = [exciting_motion(two_link, DURATION, 11, seed=seed) for seed in (4, 4, 5)]
    one, again, other = (each.trajectory.q for each in made)
    assert (one == again).all()
    assert (one != other).any()
    origin = made[2].trajectory.origin
    for fact in ("exciting", "5 s", "5 harmonics", "seed 5", "condition number"):
        assert fact in origin


@pytest.mark.slow
def test_set_points_are_those_of_the_same_series(two_link):
    few, many = (exciting_motion(two_link, DURATION, count).trajectory for count in (11, 101))
    # Round-off of sums of 25 waves, and of instants times how fast accelerations change: below 100 rad/s^3.
    assert np.abs(states_of(few) - states_of(many)[:, :, ::10]).max() <= 25 * EPS * 100.0


@pytest.mark.slow
def test_a_long_motion_repeats_a_shorter_one(two_link):
    # Accelerations of 10 and 15 rad/s^2 at velocities of 3 and 4 rad/s belong to 0.56 Hz, 39 periods in 70 s:
    # three times twelve harmonics.
    motion = exciting_motion(two_link, 70.0, 1 + 3 * 50).trajectory
    first, second, third = (states_of(motion)[:, :, k : k + 51] for k in (0, 50, 100))
    # Round-off of instants up to 70 s, times how fast accelerations change: below 100 rad/s^3.
    assert np.abs(first - second).max() <= 70.0 * 10 * EPS * 100.0
    assert np.abs(first - third).max() <= 70.0 * 10 * EPS * 100.0


def test_an_arm_without_gravity_or_limits(two_link):
    joints = tuple(dataclasses.replace(joint, acceleration_limit=None) for joint in two_link.joints)
    floating = dataclasses.replace(two_link, gravity_vector=np.zeros(3), joints=joints)
    with pytest.warns(GdAnalyzeWarning, match="acceleration"):
        made = exciting_motion(floating, DURATION)
    # Fewer numbers act then, and those that do are told.
    assert float(made.trajectory.origin.rpartition(" ")[2]) < 1e4


@pytest.mark.parametrize(
    ("duration", "count"), [(1e-9, None), (np.nan, None), (5.0, 1), (5.0, 10), (1e9, None)]
)
def test_impossible_schedules(two_link, duration, count):
    with pytest.raises(TrajectoryError):
        exciting_motion(two_link, duration, count)


@pytest.mark.slow
def test_drives_can_give_its_torque(two_link):
    """As large as the torque limits allow; a warning where even the arm's weight is too much."""
    limits = np.array([45.0, 10.0])
    arm = dataclasses.replace(two_link, drives=tuple(Drive(torque_limit=limit) for limit in limits))
    free = largest_torque(two_link, exciting_motion(two_link, DURATION))
    assert (free > limits).all()
    limited = largest_torque(arm, exciting_motion(arm, DURATION, DENSE))
    # Instants looked at are some 3 ms apart: a peak between them is missed by less than a thousandth.
    assert (limited <= 1.001 * limits).all()
    # Sizes are tried in steps of a hundredth.
    assert (limited / limits).max() > 0.95
    weak = dataclasses.replace(two_link, drives=(Drive(torque_limit=1.0),) * 2)
    with pytest.warns(TorqueLimitWarning, match="limit of 1 N m"):
        exciting_motion(weak, DURATION)


def test_a_motion_too_short_to_tell_anything_is_refused(two_link):
    """Joints that move by 0.2 degrees: the condition number is 1e7, where 1 % of noise leaves nothing."""
    with pytest.raises(UsageError, match="too short"):
        exciting_motion(two_link, 0.1)
