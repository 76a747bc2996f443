"""Gaps of a trajectory in files, in derived rates and in the comparison of rates."""

from __future__ import annotations

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.csv_writing import trajectory_csv
from gd_analyze.motions.derived_rates import complete_rates
from gd_analyze.motions.rate_slips import rate_slips
from gd_analyze.motions.trajectory import Trajectory
from recordings import Motion

TIME = np.concatenate([np.arange(40), np.arange(40) + 60]) / 40


@pytest.fixture
def torn() -> Trajectory:
    """Two stretches, the second somewhere else."""
    motion = Motion.of(1)
    q, qd, qdd = (0.2 * motion.at(TIME, order) for order in range(3))
    q[40:] += 1.0
    return Trajectory(TIME, q, qd, qdd, name="torn", gaps=(40,))


def test_a_file_keeps_gaps(torn, two_link, tmp_path):
    path = tmp_path / "torn.csv"
    gd.write_trajectory(torn, path, ["two stretches"])
    assert path.read_text().split("\n")[42] == "# gap"
    read = gd.read_trajectory(path, two_link)
    assert read.gaps == (40,)
    assert read.fingerprint == torn.fingerprint


def test_rates_are_derived_stretch_by_stretch(torn, two_link, tmp_path):
    qd, qdd, _ = complete_rates(torn.time, torn.q, None, None, torn.gaps)
    for stretch in torn.stretches:
        alone = complete_rates(torn.time[stretch], torn.q[stretch], None, None)
        np.testing.assert_array_equal(qd[stretch], alone[0])
        np.testing.assert_array_equal(qdd[stretch], alone[1])
    lines = trajectory_csv(torn).split("\n")
    path = tmp_path / "positions.csv"
    path.write_text("\n".join(line if line == "# gap" else ",".join(line.split(",")[:3]) for line in lines))
    np.testing.assert_allclose(gd.read_trajectory(path, two_link).qdd, qdd, atol=1e-9)


def test_too_few_set_points_between_gaps_are_refused(two_link, tmp_path):
    rows = [f"{k / 10},{k / 10},0" for k in range(20)]
    path = tmp_path / "few.csv"
    path.write_text("\n".join(["time,q1,q2", *rows[:17], "# gap", *rows[17:]]))
    with pytest.raises(TrajectoryError, match="too few set points to derive qd and qdd") as error:
        gd.read_trajectory(path, two_link)
    assert error.value.details["expected"].startswith("at least 6 set points between gaps")
    assert error.value.details["found"] == "3 set points"


@pytest.mark.parametrize("at", [0, 1, 81])
def test_gaps_before_the_first_or_after_the_last_set_point_mean_nothing(torn, two_link, tmp_path, at):
    lines = trajectory_csv(Trajectory(torn.time, torn.q, torn.qd, torn.qdd)).strip().split("\n")
    path = tmp_path / "odd.csv"
    path.write_text("\n".join([*lines[:at], "# gap", *lines[at:]]))
    assert gd.read_trajectory(path, two_link).gaps == ()


def test_a_jump_across_a_gap_is_no_contradiction_of_rates(torn):
    assert rate_slips(torn) == []
    many = np.arange(8, 80, 8)
    q = torn.q + np.repeat(np.arange(10), 8)[:, None]
    parts = Trajectory(torn.time, q, torn.qd, torn.qdd, gaps=tuple(many.tolist()))
    assert rate_slips(parts) == []
    assert rate_slips(Trajectory(torn.time, q, torn.qd, torn.qdd))


def test_wrong_rates_are_still_found_beside_gaps(torn):
    wrong = Trajectory(torn.time, torn.q, np.degrees(torn.qd), torn.qdd, gaps=torn.gaps)
    assert "57.3 times" in rate_slips(wrong)[0]
