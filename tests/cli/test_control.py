"""`gd-analyze control`: what it prints, writes and refuses."""

from __future__ import annotations

import math

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.robots.payload import with_payload
from gd_analyze.simplification.model_file import save_model
from gd_analyze.studies.control_law import CONTROLLERS
from gd_analyze.studies.control_result import control_result

FEW = ("--loop-rate", "continuous,200", "--speeds", "1,2")


@pytest.fixture(scope="module")
def made(two_link, swing):
    return gd.simplify(two_link, swing, "20%")


@pytest.fixture
def model(here, made):
    save_model(made, here / "model.json")
    return made


def shown_by(result) -> str:
    assert (result.code, result.err) == (0, "")
    return " ".join(result.out.split())


def test_what_it_prints(run, model, swing):
    shown = shown_by(run("control", "model.json", "two-link-swing", *FEW))
    settings = gd.ControlSettings(rates=(math.inf, 200.0), speeds=(1.0, 2.0))
    study = gd.control(gd.load_model("model.json"), swing, settings)
    result = control_result(study)
    assert result.headline in shown
    for fact in result.facts:
        assert not fact.label or fact.written in shown
    for controller in CONTROLLERS:
        assert shown.count(controller.title) >= 3
    assert "wrote" not in shown


def test_json_is_the_study(run, model, swing):
    told = run("control", "model.json", "two-link-swing", *FEW, "--bandwidth", 30, "--json").json
    settings = gd.ControlSettings(bandwidth=30.0, rates=(math.inf, 200.0), speeds=(1.0, 2.0))
    study = gd.control(gd.load_model("model.json"), swing, settings)
    assert len(told["loops"]) == len(study.loops) == 2 * 2 * len(CONTROLLERS)
    for row, loop in zip(told["loops"], study.loops, strict=True):
        assert row["controller"] == loop.controller.title
        assert row["rate"] == (None if loop.rate == math.inf else loop.rate)
        for name in ("peak_error", "rms_error", "peak_torque", "saturated"):
            # The same operations in the same order.
            assert row[name] == getattr(loop, name).tolist()
    assert (told["bandwidth"], told["damping"], told["speeds"]) == (30.0, 1.0, [1.0, 2.0])
    assert told["files"] == []
    assert told["joints"][0]["torque_limit"] is None
    # Margins that hold what a fifth of the torque can do do not close.
    assert told["joints"][0]["certified"] == []


def test_what_is_certified(run, here, two_link, swing):
    save_model(gd.simplify(two_link, swing, "2%"), here / "near.json")
    words = ("control", "near.json", "two-link-swing", "--loop-rate", "200", "--speeds", "1")
    told = run(*words, "--json").json
    study = gd.control(gd.load_model("near.json"), swing, gd.ControlSettings(rates=(200.0,), speeds=(1.0,)))
    for row, error in zip(told["joints"], study.certified[1.0].error, strict=True):
        assert row["certified"] == [
            {"speed": 1.0, "torque_error": pytest.approx(row["certified"][0]["torque_error"]), "error": error}
        ]
    assert "by the model error, proven" in shown_by(run(*words))


def test_a_payload_and_a_tolerance(run, model, swing):
    words = ("--payload", "0.5,0,0,0", "--within", "20mrad", "--loop-rate", "200", "--speeds", "1")
    told = run("control", "model.json", "two-link-swing", *words, "--json").json
    loaded = with_payload(model.arm, 0.5, [0.0, 0.0, 0.0])
    settings = gd.ControlSettings(rates=(200.0,), speeds=(1.0,))
    study = gd.control(gd.load_model("model.json"), swing, settings, loaded)
    assert told["moved"] == "two_link+0.5kg"
    assert told["joints"][0]["tolerance"] == 0.02
    assert told["joints"][0]["certified"] == []
    np.testing.assert_array_equal(told["loops"][0]["peak_error"], study.loops[0].peak_error)
    shown = shown_by(run("control", "model.json", "two-link-swing", *words))
    assert "the payload unknown to every controller" in shown


def test_a_report_is_written_and_not_over_another(run, model, here):
    words = ("control", "model.json", "two-link-swing", "--loop-rate", "200", "--speeds", "1", "--out", "r")
    told = run(*words, "--json").json
    assert sorted(path.name for path in (here / "r").iterdir()) == [
        "control.html",
        "control.json",
        "control.pdf",
    ]
    assert told["files"] == ["r/control.html", "r/control.pdf", "r/control.json"]
    assert run(*words, "--quiet").code == 0
    other = run(*words, "--bandwidth", "25")
    assert other.code == 2
    assert "holds files of another run" in other.err
    assert run(*words, "--bandwidth", "25", "--overwrite").code == 0


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--loop-rate", "fast"), "entry 1, 'fast', is not a number above 0, or continuous"),
        (("--loop-rate", "10"), "too slow for its bandwidth"),
        (("--loop-rate", "500,500"), "1 to 8 different ones"),
        (("--speeds", "1,-1"), "entry 2, '-1', is not a number above 0"),
        (("--speeds", "0.01", "--loop-rate", "100000"), "too many steps"),
        (("--damping", "0.01"), "damping is out of range"),
        (("--within", "1parsec"), "the tolerance is not understood"),
        (("--friction",), "describes no friction"),
        (("--payload", "1"), "4, 7 or 10"),
    ],
)
def test_what_it_refuses(run, model, listing, words, says):
    before = listing()
    result = run("control", "model.json", "two-link-swing", *words, "--out", "r")
    assert result.code == 2
    assert says in " ".join(result.err.split())
    assert result.out == ""
    assert listing() == before


def test_a_motion_of_another_arm(run, model):
    result = run("control", "model.json", "pick-and-place")
    assert result.code == 2
    assert "where:" in result.err
