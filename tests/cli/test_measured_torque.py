"""Measured torques on the command line: tables of 80 columns, a sentence, and friction where asked for."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest

from gd_analyze.cli.findings import print_findings
from gd_analyze.cli.measured_torque import show_measured_torque
from gd_analyze.cli.output import Output
from gd_analyze.results.findings import Findings
from gd_analyze.results.torque_words import torque_sentence
from gd_analyze.robots.arm import RobotArm
from gd_analyze.studies.main_job import Settings, find
from recorded_logs import recorded


def test_tables_and_a_sentence(measured_findings: Findings, capsys: pytest.CaptureFixture[str]) -> None:
    show_measured_torque(measured_findings)
    out = capsys.readouterr().out
    assert max(map(len, out.split("\n"))) <= 80
    assert "too light by a factor 2" in out
    assert "Friction and offset fitted" in out
    said = torque_sentence(measured_findings.tables["measured_torque"])
    assert said in " ".join(out.split())


def test_six_joints_with_noise_fit_into_80_columns(
    puma: RobotArm, capsys: pytest.CaptureFixture[str]
) -> None:
    # Of elements: nothing that is shown here depends on the level, and terms take long.
    log = recorded(puma, friction=(3.0, 2.0, -1.0), noise=2.0, gain=0.5)
    found = find(puma, log, Settings(level="element"))
    show_measured_torque(found)
    out = capsys.readouterr().out
    assert max(map(len, out.split("\n"))) <= 80
    assert "Friction and offset fitted" not in out


def test_a_plan_has_nothing_to_show(puma_findings: Findings, capsys: pytest.CaptureFixture[str]) -> None:
    show_measured_torque(puma_findings)
    assert capsys.readouterr().out == ""


def test_json_has_all_of_it(
    measured_findings: Findings, puma_findings: Findings, tmp_path, capsys: pytest.CaptureFixture[str]
) -> None:
    documents = []
    for findings in (measured_findings, puma_findings):
        print_findings(findings, tmp_path, (), Output(as_json=True, quiet=True), 0)
        documents.append(json.loads(capsys.readouterr().out)["measured_torque"])
    measured, plan = documents
    assert plan is None
    assert measured["described"] is False
    assert measured["compared"] == 484
    assert measured["said"].startswith("Measured torques: ")
    second = measured["joints"][1]
    assert second["verdict"] == "too light"
    assert second["slope_beside_friction"] == pytest.approx(2.0, rel=0.01)
    assert {"correlation", "bias", "rms_difference", "explained", "coulomb", "coulomb_error"} <= second.keys()


def test_friction_needs_measured_torques(run: Callable[..., Any]) -> None:
    done = run("puma560", "pick-and-place", "--fit-friction")
    assert done.code == 2
    assert "there are no measured torques to compare with" in done.err
    for words in ("where: trajectory pick-and-place", "expected:", "found: a plan", "next: give a log"):
        assert words in " ".join(done.err.split()), words
