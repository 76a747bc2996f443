"""What is suspicious is told once, by every verb, and stands in the results."""

from __future__ import annotations

import numpy as np
import pytest
from bad_files import ARM, HEADER, ROWS, csv

from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.motions.read import read_trajectory
from gd_analyze.results.store import load_findings
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.studies.main_job import find


def test_positions_outside_limits_are_a_warning(run, here):
    rows = [f"{k},{0.05 * k},{0.4 * k}" for k in range(9)]
    (here / "far.csv").write_text(csv(*rows))
    result = run("two_link", "far.csv", "--format", "json", "--json")
    assert result.code == 0
    assert "warning: trajectory far: joint 2 (elbow)" in result.err
    assert any("elbow" in warning for warning in result.json["warnings"])
    assert run("two_link", "far.csv", "--format", "json", "--quiet").err == ""


def test_degrees_taken_for_radians_are_a_warning(run, here):
    rows = [f"{k},{10 * k},{-5 * k}" for k in range(9)]
    (here / "degrees.csv").write_text(csv(*rows))
    result = run("two_link", "degrees.csv", "--format", "json", "--json")
    assert result.code == 0
    assert "looks like degrees" in result.err
    assert len(result.json["warnings"]) == len(result.err.strip().splitlines())


def test_an_inertia_off_by_a_measurements_error_is_a_warning(run, here, motion):
    # 0.2 + 0.001 < 0.21: broken by 4 % of the largest moment, less than the 10 % of a measurement.
    (here / "own.toml").write_text(
        ARM.replace("xx = 0.0, yy = 0.2, zz = 0.2", "xx = 0.001, yy = 0.2, zz = 0.21")
    )
    result = run("own.toml", motion, "--format", "json")
    assert result.code == 0
    assert "as_measured = true" in result.err


LIMITS = "a = 1.0\nrange = [-3.0, 3.0]\nvelocity_limit = 5.0\nacceleration_limit = 9.0"
SLIPS = ARM.replace("[[joints]]", "gravity = [0.0, -981.0, 0.0]\n[[joints]]", 1).replace("a = 1.0", LIMITS)


@pytest.mark.parametrize(
    "line",
    [
        "own.toml x.csv --format h5,html",
        "equations own.toml",
        "arms own.toml",
        "plan own.toml --from 0,0 --to 60,-45 --duration 2 -o made.csv",
        "simplify own.toml x.csv -o model.json && evaluate model.json x.csv",
        "simplify own.toml x.csv -o model.json && certify model.json",
    ],
)
def test_a_suspicion_is_a_warning_once_in_every_verb(run, here, line):
    """In the arm and, where the verb reads it, in the trajectory."""
    (here / "own.toml").write_text(SLIPS)
    time = 1000 * np.linspace(0.0, 1.0, 20)
    motion = np.column_stack(
        [time, np.sin(time / 1e3), np.cos(time / 1e3), np.cos(time / 1e3), -np.sin(time / 1e3)]
    )
    rows = [",".join(map(str, row)) for row in motion.tolist()]
    (here / "x.csv").write_text(csv(*rows, header=HEADER + ",qd1,qd2"))
    for verb in line.split(" && "):
        done = run(*verb.split())
        assert done.code == 0
    # To inspect an arm is to be told of it in the first place.
    told = done.out if verb.startswith("arms") else done.err
    assert " ".join(told.split()).count("gravity is 981 m/s^2") == 1
    assert (done.err == "") == verb.startswith("arms")
    assert done.err.count("1000 times the derivative of q") == ("x.csv" in verb)
    if verb.startswith("own.toml"):
        findings = load_findings(here / "reports" / "own-x" / "analysis.h5")
        assert sum("gravity is 981 m/s^2" in told for told in findings.warnings) == 1
        assert sum("1000 times" in told for told in findings.warnings) == 1
        assert "gravity is 981" in (here / "reports" / "own-x" / "report.html").read_text()


def test_findings_have_the_warnings_of_what_python_read(here):
    (here / "own.toml").write_text(SLIPS)
    with pytest.warns(GdAnalyzeWarning, match="gravity is 981"):
        read = load_arm(here / "own.toml")
    (here / "x.csv").write_text(csv(*ROWS))
    findings = find(read, read_trajectory(here / "x.csv", read))
    assert sum("gravity is 981 m/s^2" in told for told in findings.warnings) == 1
