"""Python hears what the terminal hears: the same warnings, job by job, at the line of the call."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from test_bad_input import ARM

import gd_analyze as gd
from gd_analyze.tables import rank_terms
from gd_analyze.types import ExactDynamics

HEADER = "time,q1,q2"
TIME = np.linspace(0.0, 2.0, 41)
SWING = np.column_stack([TIME, 0.5 * np.sin(TIME), -0.4 * np.cos(TIME)])
# The drives of the second joint are too weak for its weight.
WEAK = ARM + "[[drives]]\ntorque_limit = 200.0\n[[drives]]\ntorque_limit = 0.1\n"
HEAVY = ARM.replace("[[joints]]", "gravity = [0.0, -981.0, 0.0]\n[[joints]]", 1)
# What is suspicious: the robot's file, and the motion.
SUSPICIONS = {
    "degrees for radians": (ARM, np.column_stack([TIME, 100.0 * SWING[:, 1:]])),
    "milliseconds for seconds": (ARM, np.column_stack([TIME / 100.0, SWING[:, 1:]])),
    "gravity a hundred times too large": (HEAVY, SWING),
    "drives too weak": (WEAK, SWING),
    "one set point": (ARM, SWING[:1]),
    "nothing": (ARM, SWING),
}


def exact(arm: str, motion: str) -> ExactDynamics:
    loaded = gd.load_arm(arm)
    return ExactDynamics.of(loaded, gd.read_trajectory(motion, loaded))


def saved(arm: str, motion: str) -> gd.types.SimplifiedModel:
    return gd.load_model("model.json")


# Words of the terminal, and the same in Python; {} stands for nothing that either needs.
JOBS: dict[str, tuple[str, Callable[[str, str], Any]]] = {
    "analyze": ("a.toml m.csv --format json --overwrite", lambda arm, motion: gd.analyze(arm, motion)),
    "analyze into a folder": (
        "a.toml m.csv --format json --out there --overwrite",
        lambda arm, motion: gd.analyze(arm, motion, "there", formats=["json"], overwrite=True),
    ),
    "simplify": ("simplify a.toml m.csv", lambda arm, motion: gd.simplify(arm, motion)),
    "simplify within the limits": (
        "simplify a.toml --states 20 --at-set-points",
        lambda arm, _: gd.simplify(arm, gd.tables.states_in_box(arm, 20)),
    ),
    "rank-terms": ("rank-terms a.toml m.csv", lambda arm, motion: rank_terms(exact(arm, motion))),
    "trade-off": (
        "trade-off a.toml m.csv --quick",
        lambda arm, motion: gd.trade_off(exact(arm, motion), thorough=False),
    ),
    "evaluate": (
        "evaluate model.json m.csv --arm a.toml --fail-over none",
        lambda arm, motion: gd.evaluate(saved(arm, motion), motion, gd.load_arm(arm), fail_over=None),
    ),
    "certify": (
        "certify model.json --along m.csv --effort 1",
        lambda arm, motion: gd.certify(
            saved(arm, motion), gd.types.Tube.along(saved(arm, motion).arm, gd.read_trajectory(motion, arm))
        ),
    ),
    "decompose": ("formulations a.toml m.csv", lambda arm, motion: gd.decompose(arm, motion)),
    "plan": (
        "plan a.toml --from 0,0 --to 1rad,1rad --duration 2 -o made.csv",
        lambda arm, _: gd.plan(arm, [0.0, 0.0], [1.0, 1.0], 2.0),
    ),
    "equations": ("equations a.toml", lambda arm, _: gd.equations(arm)),
    "export": ("export a.toml --to c --overwrite", lambda arm, _: gd.export(arm, "c")),
}


def heard(function: Callable[[], Any]) -> list[warnings.WarningMessage]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        function()
    return caught


@pytest.mark.parametrize("suspicion", SUSPICIONS)
@pytest.mark.parametrize("job", JOBS)
def test_python_hears_what_the_terminal_hears(run, here, job, suspicion):
    arm, table = SUSPICIONS[suspicion]
    (here / "a.toml").write_text(arm)
    np.savetxt(here / "m.csv", table, delimiter=",", header=HEADER, comments="")
    words, call = JOBS[job]
    if "model.json" in words:
        with warnings.catch_warnings(action="ignore"):
            gd.save_model(gd.simplify("a.toml", gd.tables.states_in_box("a.toml", 9)), here / "model.json")
    try:
        caught = heard(lambda: call("a.toml", "m.csv"))
    except gd.GdAnalyzeError:
        assert run(words).code == 2
        return
    told = run(words)
    assert told.code == 0
    lines = [line.removeprefix("warning: ") for line in told.err.splitlines() if line.startswith("warning")]
    assert all(issubclass(entry.category, gd.GdAnalyzeWarning) for entry in caught)
    assert {str(entry.message) for entry in caught} == set(lines)
    assert len(lines) == len(set(lines))


def test_a_motion_in_memory_is_heard_once_at_the_callers_line(two_link):
    q = 100.0 * SWING[:, 1:]
    motion = gd.Trajectory(TIME, q, np.gradient(q, TIME, axis=0), 0.0 * q, "made")
    found: list[gd.types.Findings] = []
    caught = heard(lambda: found.append(gd.analyze(two_link, motion)))
    texts = [str(entry.message) for entry in caught]
    assert any("degrees" in text for text in texts)
    assert len(texts) == len(set(texts))
    assert [*found[0].warnings] == texts
    assert {entry.filename for entry in caught} == {__file__}


def test_a_filter_that_makes_errors_of_warnings_ends_the_job(two_link, here):
    np.savetxt(here / "m.csv", 100.0 * SWING, delimiter=",", header=HEADER, comments="")
    with pytest.raises(gd.GdAnalyzeWarning), warnings.catch_warnings(action="error"):
        gd.analyze(two_link, "m.csv", "there")
    assert not (here / "there").exists()
