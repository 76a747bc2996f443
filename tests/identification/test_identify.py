"""What logs of known arms tell: the numbers, their errors, what is not identifiable, and what is refused."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze import Trajectory
from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.base_parameters import link_regressor, parameters_of
from gd_analyze.errors import GdAnalyzeWarning, UsageError
from gd_analyze.identification.consistent import pseudo_inertias
from gd_analyze.identification.doubts import scale_error
from gd_analyze.identification.identified_arm import base_matrix
from gd_analyze.identification.rows import Unknowns, identification_rows
from gd_analyze.robots.parts import pseudo_inertia
from gd_analyze.tables import states_in_box, with_payload
from gd_analyze.types import Identification, States
from logs_of_arms import TrueArm, fourier, with_torque
from long_cases import long

EPS = float(np.finfo(float).eps)


@pytest.fixture(scope="module")
def motion(puma):
    return fourier(puma, 12.0, 100.0, 0)


@pytest.fixture(scope="module")
def true(puma):
    return TrueArm.near(puma, 1)


@pytest.fixture(scope="module")
def found(puma, true, motion) -> Identification:
    return gd.identify(puma, true.log(*motion))


def massless(arm: gd.types.RobotArm) -> gd.types.RobotArm:
    nothing = [replace(link, mass=0.0, com=np.zeros(3), inertia_com=np.zeros((3, 3))) for link in arm.links]
    return replace(arm, links=tuple(nothing), drives=())


def values(found: Identification, name: str = "value") -> FloatArray:
    return np.array([getattr(one, name) for one in found.parameters])


def identifiable(found: Identification) -> np.ndarray:
    return np.array([one.identifiable for one in found.parameters])


def test_rows_are_torque_by_what_it_is_linear_in(true, motion):
    """Columns times the true numbers are the measured torque, window by window."""
    unknowns = Unknowns(6)
    time, states = motion
    rows = identification_rows(
        true.arm, true.exact_log(time, states), unknowns, np.abs(states.qd).max(axis=0)
    )
    numbers = np.concatenate([parameters_of(true.arm).ravel(), true.drives, true.friction.ravel()])
    for each in rows:
        assert len(each.time) > 0.5 * len(time) / 5  # windows of five readings, but for those of reversals
        sizes = np.abs(each.columns) @ np.abs(numbers)
        # Some hundred roundings of what a row adds up.
        assert (np.abs(each.columns @ numbers - each.torque) <= 500 * EPS * sizes).all()


def test_columns_of_links_are_pinocchios(puma, motion):
    """An independent regressor: Pinocchio's, about the same frames."""
    pin = pytest.importorskip("pinocchio", reason="needs Pinocchio")
    from gd_analyze.dynamics.pinocchio_check import pinocchio_model

    model = pinocchio_model(puma)
    data, states = model.createData(), motion[1]
    # Pinocchio's order is m, mc, Ixx, Ixy, Iyy, Ixz, Iyz, Izz, about the joint's own frame.
    for row in range(0, len(states.q), 400):
        q, qd, qdd = (x[row] for x in states.arrays)
        theirs = pin.computeJointTorqueRegressor(model, data, q, qd, qdd)
        parameters = np.concatenate([inertia.toDynamicParameters() for inertia in model.inertias[1:]])
        ours = link_regressor(puma, q[:, None], qd[:, None], qdd[:, None])[..., 0].reshape(6, -1)
        torque = ours @ parameters_of(puma).ravel()
        # Both sum the same torques in another order: a thousand roundings of the largest.
        np.testing.assert_allclose(torque, theirs @ parameters, rtol=0, atol=1e3 * EPS * np.abs(torque).max())


@pytest.mark.parametrize("physical", [False, True])
def test_an_exact_log_tells_the_exact_numbers(puma, true, motion, physical):
    exact = gd.identify(puma, true.exact_log(*motion), physical=physical)
    assert identifiable(exact).all()
    # The semidefinite program weighs by 1e5 at most, and so leaves some 1e-5 of plausible sizes; signs cost
    # nothing here, and round-off grows with the condition number.
    close = 1e-5 if physical else 1e-9
    sizes = np.abs(base_matrix(puma)[1]) @ exact.estimate.sizes[:66]
    assert (np.abs(values(exact) - true.base) <= close * sizes).all()
    np.testing.assert_allclose(exact.friction, true.friction, rtol=0, atol=1e-4 * np.abs(true.friction).max())


def test_noise_is_stated_by_standard_errors(puma, true, motion, found):
    # Twelve seconds tell two thirds of forty to a ninth of a link's size, and from zero.
    assert identifiable(found).sum() >= 20
    for which in ("value", "least_squares"):
        off = ((values(found, which) - true.base) / values(found, "error"))[identifiable(found)]
        # Normal, but for some thirty-six draws of it: 1 with a standard deviation of 0.12, and the bias of
        # noise in positions, which the errors do not hold.
        assert 0.5 < np.sqrt((off**2).mean()) < 1.5
        assert np.abs(off).max() < 4.0
    assert (np.abs((found.friction - true.friction) / found.friction_error) < 4.0).all()


def test_torques_of_another_motion_are_met_to_the_noise(puma, true, found, motion):
    """Within 1.2 times what noise of 1 % alone leaves."""
    _, fresh = fourier(puma, 12.0, 50.0, 7)
    noise = 0.01 * np.sqrt((true.torque(motion[1]) ** 2).mean(axis=0))
    coulomb, viscous, offset = found.friction.T
    ours = gd.types.ExactDynamics.of(found.arm, fresh, drives=True).torque
    ours = ours + coulomb * np.sign(fresh.qd) + viscous * fresh.qd + offset
    off = np.sqrt(((ours - true.torque(fresh)) ** 2).mean(axis=0))
    assert (np.hypot(off, noise) <= 1.2 * noise).all()


def test_the_arm_is_the_parameters_stated(puma, found):
    """Base parameters of the arm written are those identified: to round-off."""
    stated = np.array([one.number for one in gd.base_parameters(found.arm, drives=True)])
    sizes = np.abs(base_matrix(puma)[1]) @ found.estimate.sizes[:66]
    assert (np.abs(stated - values(found)) <= 1e3 * EPS * sizes).all()


@pytest.mark.parametrize("seed", range(1, 5))
def test_bodies_are_possible_where_least_squares_are_not(puma, seed):
    """A short, noisy log: plain least squares keep signs, but give bodies that cannot be."""
    true = TrueArm.near(puma, seed)
    log = true.log(*fourier(puma, 4.0, 100.0, seed), noise=(3e-4, 0.05), seed=seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        physical = gd.identify(puma, log)
        plain = gd.identify(puma, log, physical=False)
    assert min(_least(link) for link in physical.arm.links) > 0.0
    assert min(_least(link) for link in plain.arm.links) < 0.0
    assert (plain.arm.mass >= 0.0).all()
    assert (physical.drive_inertia >= 0.0).all()
    assert (physical.friction[:, :2] >= 0.0).all()


def _least(link) -> float:
    return float(np.linalg.eigvalsh(pseudo_inertia(link.mass, link.com, link.inertia_com))[0])


def test_pseudo_inertias_are_linear_in_the_parameters(puma):
    for link, row in zip(puma.links, parameters_of(puma), strict=True):
        matrix = pseudo_inertia(link.mass, link.com, link.inertia_com)
        # A few roundings.
        np.testing.assert_allclose(np.tensordot(row, pseudo_inertias(), 1), matrix, rtol=0, atol=1e-14)


def test_what_one_moving_joint_does_not_tell_keeps_the_files_values(puma, true, motion):
    time, states = motion
    moves = np.arange(6) == 2
    states = States(
        *(np.where(moves, x, 0.0 * x + k) for x, k in zip(states.arrays, (0.3, 0, 0), strict=True))
    )
    with pytest.warns(GdAnalyzeWarning, match=r"joints 1, 2, 4, 5 and 6 do"):
        found = gd.identify(puma, true.exact_log(time, states), physical=False)
    assert found.silent == (1, 2, 4, 5, 6)
    # Inertia about the third axis with its drive, and the first moments that gravity acts on.
    assert 1 <= identifiable(found).sum() <= 6
    names = {one.symbol for one in found.parameters if one.identifiable}
    assert not {name for name in names if name.endswith(("1", "2"))}
    # Directions of which the log has nothing: exactly the file's values, but for round-off.
    file, plain, sizes = values(found, "file"), values(found, "least_squares"), found.estimate.sizes
    untouched = np.abs(
        base_matrix(puma)[1] @ (found.estimate.directions[: found.estimate.identifiable, :66] * sizes[:66]).T
    )
    silent = untouched.max(axis=1) <= 1e-9 * (np.abs(base_matrix(puma)[1]) @ sizes[:66])
    assert silent.sum() >= 10
    np.testing.assert_allclose(plain[silent], file[silent], rtol=1e-6, atol=1e-9)
    assert not identifiable(found)[silent].any()
    assert np.isnan(found.friction_error[~moves]).all()


def test_the_last_third_is_predicted(found, motion):
    for each in found.residuals:
        begin = each.time[~each.held_out].max()
        assert begin < 8.0 - 1e-9 <= each.time[each.held_out].min()
        assert each.share("identified") < 0.1
        assert each.rms("identified") < 0.2 * each.rms("friction") < each.rms("file")


def test_a_log_held_out_is_not_fitted(puma, true, motion, found):
    other = true.log(*fourier(puma, 12.0, 100.0, 3), seed=3)
    log = true.log(*motion)
    apart = gd.identify(puma, log, held_out=other)
    assert apart.held_out == (other.name,) or apart.held_out[0].startswith(other.name)
    third = true.log(*fourier(puma, 6.0, 100.0, 4), seed=4)
    everything = gd.identify(puma, [log, other], held_out=third)
    # More rows tell more.
    assert np.median(values(everything, "error")) < np.median(values(apart, "error"))
    assert np.median(values(apart, "error")) < np.median(values(found, "error"))


def test_an_unknown_payload_is_found(puma, true, motion):
    payload = (2.0, np.array([0.05, -0.02, 0.12]))
    loaded = replace(true, arm=with_payload(true.arm, *payload))
    log, other = true.log(*motion), loaded.log(*fourier(puma, 12.0, 100.0, 5), seed=5)
    found = gd.identify(puma, log, loaded=other)
    assert found.payload is not None
    off = (found.payload[0] - np.concatenate([[payload[0]], payload[1]])) / found.payload[1]
    # Four numbers within four standard errors of them: one in four thousand draws is beyond.
    assert (np.abs(off) < 4.0).all()
    # Noise leaves less than 0.1 kg; the error of the scale, from gravity torques beside the file's, is more.
    scale = scale_error(puma, found.arm, [log])
    assert scale * found.payload[0][0] <= found.payload[1][0] < np.hypot(0.1, scale * found.payload[0][0])
    # Known to be bare, the arm's own last link stays what it is.
    assert np.abs((values(found) - true.base) / values(found, "error"))[identifiable(found)].max() < 4.5


def test_links_that_a_file_states_nothing_of_begin_as_rods(puma, true, motion):
    found = gd.identify(massless(puma), true.exact_log(*motion))
    assert identifiable(found).sum() >= 36
    assert (found.arm.mass > 0.0).all()
    _, fresh = fourier(puma, 6.0, 20.0, 8)
    ours = gd.types.ExactDynamics.of(found.arm, fresh, drives=True).torque
    coulomb, viscous, offset = found.friction.T
    off = ours + coulomb * np.sign(fresh.qd) + viscous * fresh.qd + offset - true.torque(fresh)
    # What the log does not tell is as the rods have it, and makes up to a thousandth.
    assert np.abs(off).max() <= 1e-3 * np.abs(true.torque(fresh)).max()


def test_uncertainty_is_that_of_the_base_parameters(puma, found, motion):
    """The torque's standard uncertainty from the arm's spread is that from the covariance, row by row."""
    _, fresh = fourier(puma, 6.0, 5.0, 2)
    stated = gd.tables.torque_uncertainty(found.arm, fresh, drives=True)
    rows = link_regressor(puma, *fresh.last).reshape(6, 60, -1)
    drives = np.einsum("ij,jn->ijn", np.eye(6), fresh.qdd.T)
    per_unit = np.concatenate([rows, drives], axis=1)
    estimate = found.estimate
    parts = np.concatenate([estimate.deviations, estimate.open])[:, :66]
    square = np.einsum("kp,ipN->ikN", parts, per_unit)
    wanted = np.sqrt((square**2).sum(axis=1)).T
    # Directions on which no torque depends drop out of both but for round-off.
    np.testing.assert_allclose(stated, wanted, rtol=1e-6, atol=1e-9 * wanted.max())


def test_the_spread_goes_with_the_arm(found, motion, tmp_path):
    from gd_analyze.robots.arm_file import arm_in
    from gd_analyze.robots.description import describe

    gd.save_arm(found.arm, tmp_path / "arm.toml")
    states = states_in_box(found.arm, 20)
    stated = gd.tables.torque_uncertainty(found.arm, states)
    for again in (gd.load_arm(tmp_path / "arm.toml"), arm_in(describe(found.arm))):
        np.testing.assert_array_equal(again.spread, found.arm.spread)
        np.testing.assert_array_equal(gd.tables.torque_uncertainty(again, states), stated)
    broken = (tmp_path / "arm.toml").read_text().replace("spread = [\n    [", "spread = [\n    [1.0, ", 1)
    (tmp_path / "arm.toml").write_text(broken)
    with pytest.raises(gd.GdAnalyzeError, match="spread"):
        gd.load_arm(tmp_path / "arm.toml")


@pytest.mark.slow
def test_a_model_as_exact_as_the_log(two_link, tmp_path):
    time, states = fourier(two_link, 6.0, 100.0, 4)
    true = TrueArm.near(two_link, 5)
    arm = gd.identify(two_link, true.log(time, states, noise=(1e-3, 0.2))).arm
    few = States(*(x[::10] for x in states.arrays))
    model = gd.simplify(arm, few, "uncertainty")
    assert model.operations.total < gd.simplify(arm, few, "0.01%").operations.total
    allowed = gd.tables.torque_uncertainty(arm, few).max(axis=0)
    # The budget is stated with six digits.
    np.testing.assert_allclose(model.accuracy.allowed, allowed, rtol=1e-5)
    gd.save_model(model, tmp_path / "model.json")
    np.testing.assert_array_equal(gd.load_model(tmp_path / "model.json").arm.spread, arm.spread)


def test_verdicts_are_as_sure_as_the_log(found, pick_and_place):
    sure = gd.tables.robustness(found.arm, pick_and_place, samples=500)
    assert sure.attrs["exactly_known"] == ""
    # Drawn from the covariance: elements that it knows are sure, and no probability is lost.
    np.testing.assert_allclose(sure.probability.sum("verdict"), 1.0)
    best = sure.over_motion.max("verdict")
    assert float(best.sel(element="D11")) > 0.99


def refused(arm, log: Trajectory, **more) -> UsageError:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        with pytest.raises(UsageError) as caught:
            gd.identify(arm, log, **more)
    # Options are advised in commands only: a call has arguments.
    assert "--" not in re.sub("`gd-analyze [^`]*`", "", caught.value.details.get("next", ""))
    return caught.value


@pytest.mark.slow
def test_what_cannot_be_identified(puma, true, motion):
    time, states = motion
    log = true.exact_log(time, states)
    resting = States(states.q[:1] + 0.0 * states.q, 0.0 * states.qd, 0.0 * states.qdd)
    assert "no joint moves" in refused(puma, true.exact_log(time, resting)).what
    assert "constant" in refused(puma, with_torque(log, np.full_like(log.q, 3.0))).what
    assert "no measured torques" in refused(puma, replace(log, recording=None)).what
    assert refused(puma, with_torque(log, np.random.default_rng(0).normal(size=log.q.shape))).what


@pytest.mark.slow
def test_the_log_of_another_robot_is_no_models(puma, true, motion):
    """Torques of another motion, and of the same joints in another order."""
    log = true.exact_log(*motion)
    other = true.exact_log(*fourier(puma, 12.0, 100.0, 9)).recording.torque
    assert "no model" in refused(puma, with_torque(log, other)).what
    backwards = with_torque(log, log.recording.torque[:, ::-1])
    assert "reversed order" in refused(puma, backwards).what
    assert "no model" in refused(puma, backwards, anyway=True).what


@pytest.mark.slow
@pytest.mark.parametrize("pair", [(0, 3), (0, 1), (1, 4), (2, 3), (3, 5), (4, 5)])
def test_two_columns_that_are_swapped_are_told(puma, true, motion, pair):
    """By what the identified model leaves, or as what it would take of friction."""
    log, order = true.exact_log(*motion), np.arange(6)
    order[list(pair)] = pair[::-1]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GdAnalyzeWarning)
        try:
            gd.identify(puma, with_torque(log, log.recording.torque[:, order]), physical=False)
            told = next(str(each.message) for each in caught if "gd-analyze diagnose" in str(each.message))
        except UsageError as error:
            told = error.what
    # At one of the two, or at both.
    named = told.split("joint")[1]
    assert str(pair[0] + 1) in named or str(pair[1] + 1) in named


@pytest.mark.parametrize("sign", [long(1.0), -1.0])
def test_a_mistake_of_the_file_is_no_wrong_sign_of_the_log(puma, true, motion, sign):
    """The file's last centre of mass lies on the other side, or not: the log is right, and is explained."""
    *others, last = puma.links
    at = np.array([0.2, 0.15, 0.0])
    given, is_so = (
        replace(puma, links=(*others, replace(last, mass=2.0, com=com))) for com in (sign * at, -at)
    )
    log = replace(true, arm=is_so, drives=0.1 * true.drives, friction=0.1 * true.friction).exact_log(*motion)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        found = gd.identify(given, log, physical=False)
    assert max(each.share("identified") for each in found.residuals) < 1e-6


@pytest.mark.parametrize("joint", [1, *map(long, (0, 2, 3, 4, 5))])
def test_the_other_sign_of_a_joints_torque(puma, true, motion, joint):
    log, signs = true.exact_log(*motion), np.where(np.arange(6) == joint, -1, 1)
    error = refused(puma, with_torque(log, signs * log.recording.torque))
    assert error.details["next"].startswith(f"`torque_sign='{','.join(map(str, signs))}'`;")


@pytest.mark.slow
def test_what_is_plausible_but_wrong(puma, true, motion):
    """The sign of one joint without a file, another's column, and a log that is predicted from itself."""
    log, bare = true.exact_log(*motion), massless(puma)
    signs = np.array([1, 1, 1, -1, 1, 1])
    error = refused(bare, with_torque(log, signs * log.recording.torque))
    assert "friction" in error.what
    assert "joint 4" in error.what
    assert error.details["next"].startswith("`torque_sign='1,1,1,-1,1,1'` ")
    rigid = replace(true, arm=puma, drives=0.0 * true.drives, friction=0.0 * true.friction)
    smooth = rigid.exact_log(*motion)
    exchanged = with_torque(smooth, smooth.recording.torque[:, [0, 2, 1, 3, 4, 5]])
    cause = refused(puma, exchanged).what
    assert "joints 2 and 3" in cause
    assert "exchanged" in cause
    assert "twice" in refused(puma, log, held_out=log).what
    # A commanded motion that is repeated is another log: its torques were measured anew.
    again = with_torque(log, 1.001 * log.recording.torque)
    assert len(gd.identify(puma, log, held_out=again, physical=False).residuals) == 6


def test_a_log_held_out_in_which_joints_stand_still(puma, true, motion):
    """Nothing is stated of what is not seen: a warning if some joints stand still, refused if all do."""
    time, states = motion
    log = true.exact_log(time, states)
    for moves in (np.zeros(6, dtype=bool), np.arange(6) != 1):
        still = States(*(np.where(moves, x, 0.3 * (k == 0)) for k, x in enumerate(states.arrays)))
        apart = replace(true.exact_log(time, still), name="apart")
        if not moves.any():
            assert "held-out" in refused(puma, log, held_out=apart).what
            continue
        with pytest.warns(GdAnalyzeWarning, match=r"joint 2 .*held-out"):
            found = gd.identify(puma, log, held_out=apart)
        assert [np.isnan(each.share("identified")) for each in found.residuals] == list(~moves)


def test_readings_that_are_missing_and_gaps(puma, true, motion, found):
    time, states = motion
    log = true.log(time, states)
    torque = log.recording.torque.copy()
    torque[::7, 2] = np.nan
    gappy = replace(log, recording=replace(log.recording, torque=torque), gaps=(400,))
    again = gd.identify(puma, gappy)
    # Fewer rows of joint 3: its numbers are less well known, and right all the same.
    off = ((values(again) - true.base) / values(again, "error"))[identifiable(again)]
    assert np.abs(off).max() < 4.0
