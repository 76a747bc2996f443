"""`gd-analyze identify`: a log becomes an arm's file and a report, and what cannot be is told."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.simplification.candidates import TooManyTermsError
from logs_of_arms import TrueArm, fourier


def csv(true: TrueArm, seed: int, seconds: float = 8.0, name: str = "log.csv") -> None:
    """Write a log of a moving arm into the folder at hand."""
    time, states = fourier(true.arm, seconds, 100.0, seed)
    log = true.log(time, states, seed=seed)
    names = [f"{role}{i}" for role in ("q", "torque") for i in range(1, true.arm.n_joints + 1)]
    table = np.column_stack([time, log.recording.q, log.recording.torque])
    np.savetxt(name, table, delimiter=",", header=",".join(["time", *names]), comments="", fmt="%.10g")


@pytest.fixture
def true(two_link) -> TrueArm:
    return TrueArm.near(two_link, 3)


def test_from_a_log_to_an_arm_that_every_verb_takes(run, here, true):
    csv(true, 1)
    csv(true, 2, name="other.csv")
    result = run("identify two_link log.csv --held-out other.csv -o found.toml --report r --json")
    assert (result.code, result.err) == (0, "")
    answer = result.json
    assert answer["logs"] == ["log"]
    assert answer["held_out"] == ["other"]
    assert answer["files"] == [
        "found.toml",
        "r/identification.html",
        "r/identification.pdf",
        "r/identification.json",
    ]
    assert all(row["identified"] < 0.05 * row["file"] for row in answer["joints"])
    off = [
        (row["value"] - one) / row["error"] for row, one in zip(answer["parameters"], true.base, strict=True)
    ]
    # Six numbers within five standard errors, bias of noisy positions included.
    assert np.abs(off).max() < 5.0
    assert 0 < answer["supported_operations"] <= 30
    assert json.loads((here / "r/identification.json").read_text())["headline"] == answer["headline"]
    arm = gd.load_arm("found.toml")
    (source,) = (text for text in arm.sources if "gd-analyze" in text)
    assert run("simplify found.toml log.csv --budget uncertainty --at-set-points").code == 0
    assert source in run("arms found.toml").words
    # Drives and friction are in it: the log's torque follows with friction alone.
    again = run("rank-terms found.toml log.csv --json")
    assert again.code == 0


def test_terminal_tells_the_answer_first(run, here, true):
    csv(true, 1)
    result = run("identify two_link log.csv")
    assert result.code == 0
    answer = run("identify two_link log.csv --json").json
    counted = f"supports {answer['supported_operations']} operations and "
    assert counted in " ".join(result.out.splitlines()[:3])
    assert max(map(len, result.out.splitlines())) <= 90
    assert "supports" not in run("identify two_link log.csv --no-model --plain").out


def test_the_last_line_is_a_command_that_agrees(run, here, true):
    """With names and signs that only options tell, of logs with a blank in their names."""
    for seed, name in enumerate(["my log.csv", "other.csv"], start=1):
        csv(true, seed, name=name)
        table = np.loadtxt(name, delimiter=",", skiprows=1) * [1, 1, 1, -1, -1]
        np.savetxt(name, table, delimiter=",", header="clock,a1,a2,t1,t2", comments="", fmt="%.10g")
    maps = ["--map", "time=clock", "--map", "q=a*", "--map", "torque=t*"]
    options = [*maps, "--torque-sign", "-1", "--measured", "--cutoff", "6Hz"]
    words = ["my log.csv", "other.csv", *options, "--no-model"]
    result = run("identify two_link", *words, "-o", "its arm.toml")
    assert result.code == 0, result.err
    next_line = result.out.splitlines()[-1]
    command = next_line.removeprefix("next: gd-analyze ")
    assert command != next_line
    typed = run("", *shlex.split(command), "--level", "element", "--format", "html", "--json")
    assert typed.code == 0, typed.err
    answer = run("identify two_link", *words, "-o", "its arm.toml", "--json").json
    assert answer["next"] == f"gd-analyze {command}"
    # Beside the friction the fitted arm leaves no more of the torque than the identification says.
    measured = typed.json["measured_torque"]
    assert measured["verdict"] == "agrees"
    for row, joint in zip(answer["joints"], measured["joints"], strict=True):
        assert joint["rms_beside_friction"] <= row["identified"]
    # Without a file of the arm there is nothing to type.
    assert "next" not in run("identify two_link", *words, "--json").json


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("identify two_link plan.csv", "trajectory plan"),
        ("identify two_link still.csv", "--exciting"),
        ("identify two_link log.csv --held-out none.csv", "none.csv"),
        ("identify puma560 log.csv", "joint"),
        ("identify two_link", "LOG"),
    ],
)
def test_what_is_refused(run, here, true, line, says):
    csv(true, 1)
    time, states = fourier(true.arm, 4.0, 100.0, 1)
    np.savetxt("plan.csv", np.column_stack([time, states.q]), delimiter=",", header="time,q1,q2", comments="")
    rng = np.random.default_rng(0)
    still = np.column_stack(
        [time, 0.3 + 1e-4 * rng.normal(size=(len(time), 2)), rng.normal(size=(len(time), 2))]
    )
    np.savetxt("still.csv", still, delimiter=",", header="time,q1,q2,torque1,torque2", comments="")
    result = run(line)
    assert (result.code, result.out) == (2, "")
    assert says in result.err
    assert "Traceback" not in result.err
    assert len(result.err.strip().splitlines()) <= 8


def failing(error: BaseException) -> Callable[..., None]:
    def search(*_: object, **__: object) -> None:
        raise error

    return search


@pytest.mark.parametrize("error", [TooManyTermsError("too many of the 5438 terms matter"), MemoryError()])
def test_the_arm_is_written_whatever_comes_of_the_search_for_a_model(run, here, true, monkeypatch, error):
    csv(true, 1)
    monkeypatch.setattr("gd_analyze.studies.identification_result.simplify_exact", failing(error))
    result = run("identify two_link log.csv -o found.toml --report r")
    assert result.code == 0
    assert gd.load_arm("found.toml").spread is not None
    assert (here / "r/identification.html").exists()
    text = " ".join(result.out.split())
    assert (str(error) or "out of memory") in text
    assert "supports" not in text.split("Base parameters")[0]
    assert run("identify two_link log.csv -o again.toml --json").json["files"] == ["again.toml"]


def test_the_arm_is_written_before_a_search_that_is_interrupted(run, here, true, monkeypatch):
    csv(true, 1)
    monkeypatch.setattr(
        "gd_analyze.studies.identification_result.simplify_exact", failing(KeyboardInterrupt())
    )
    assert run("identify two_link log.csv -o found.toml").code == 130
    assert gd.load_arm("found.toml").n == 2
