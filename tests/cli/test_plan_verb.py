"""`gd-analyze plan`: what is planned, written and refused."""

from __future__ import annotations

import math
import shlex

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.cli.plan import PROFILE_NAMES
from gd_analyze.motions.profiles import PROFILES
from gd_analyze.motions.trajectory import recorded_command

PLAN = ("plan", "two_link", "--from", "0,0", "--to", "60,-45", "--duration", "2")


def test_the_profiles_are_those_of_the_library():
    assert tuple(PROFILES) == PROFILE_NAMES


@pytest.mark.parametrize("profile", PROFILE_NAMES)
def test_a_plan_starts_and_ends_where_it_was_told_to(run, here, profile):
    result = run(*PLAN, "--points", 17, "--profile", profile, "-o", "my swing.csv")
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    assert result.out.endswith("wrote my swing.csv\n")
    motion = gd.read_trajectory("my swing.csv", gd.load_arm("two_link"))
    assert motion.n_set_points == 17
    # Typed degrees become radians by one rounding each.
    np.testing.assert_allclose(np.rad2deg(motion.q[[0, -1]]), [[0, 0], [60, -45]], rtol=4e-16, atol=0)


def test_a_plan_records_the_command_that_repeats_it(run, here):
    assert run(*PLAN, "-o", "my swing.csv").code == 0
    text = (here / "my swing.csv").read_text(encoding="utf-8")
    assert text.splitlines()[0] == "# " + shlex.join(["gd-analyze", *PLAN, "-o", "my swing.csv"])
    command = recorded_command(text.splitlines())
    assert command is not None
    (here / "my swing.csv").unlink()
    assert run(*shlex.split(command)[1:]).code == 0
    assert (here / "my swing.csv").read_text(encoding="utf-8") == text


def test_a_plan_goes_to_standard_output_without_a_file(run, listing):
    result = run(*PLAN)
    assert (result.code, result.err) == (0, "")
    lines = result.out.splitlines()
    assert lines[0] == "# " + shlex.join(["gd-analyze", *PLAN])
    assert lines[1] == "time,q1,q2,qd1,qd2,qdd1,qdd2"
    assert len(lines) == 2 + 31
    assert listing() == set()
    assert run(*PLAN, "--quiet").out.splitlines()[1:] == lines[1:]


def test_a_plan_as_json_holds_the_set_points(run, here):
    told = run(*PLAN, "--json").json
    assert told["q"][-1] == [math.radians(60), math.radians(-45)]
    assert len(told["time"]) == told["set_points"] == 31
    assert run(*PLAN, "--json", "-o", "x.csv").json["files"] == ["x.csv"]
    motion = gd.read_trajectory("x.csv", gd.load_arm("two_link"))
    assert motion.qdd.tolist() == told["qdd"]


def test_a_plan_over_the_limits_is_a_warning_when_allowed(run, here):
    words = [*PLAN[:-1], "0.3", "-o", "fast.csv"]
    assert run(*words).code == 2
    assert not (here / "fast.csv").exists()
    result = run(*words, "--allow-violations")
    assert result.code == 0
    assert "warning: the motion is too fast" in result.err
    assert (here / "fast.csv").exists()
