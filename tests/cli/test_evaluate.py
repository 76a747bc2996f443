"""`gd-analyze evaluate`: over drawn states, with a payload, and what it says it held the model against."""

from __future__ import annotations

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.robots.payload import with_payload
from gd_analyze.simplification.evaluation import evaluate, payload_effect
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.model_file import save_model
from gd_analyze.simplification.simplify import simplify
from made_models import by_elements


@pytest.fixture(params=LEVELS)
def model(request, here, swing):
    """A model of the two-link arm at each level, made for one trajectory with drops worth showing."""
    made = simplify(load_arm("two_link"), swing, gd.Budget.parse("2%"), level=request.param)
    save_model(made, here / "model.json")
    return made


def within_80(result) -> str:
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    return " ".join(result.out.split())


def test_over_drawn_states(run, model):
    told = run("evaluate", "model.json", "--states", 300, "--seed", 7, "--json").json
    expected = evaluate(model, states_in_box(model.arm, 300, 7)).errors
    for key, values in (("largest_error", expected.largest), ("peak_torque", expected.peak_torque)):
        # The same programs at the same states, so the same bits.
        assert [row[key] for row in told["joints"]] == values.tolist()
    assert (told["states"], told["seed"], told["trajectory"], told["set_points"]) == (300, 7, None, None)
    assert told["held_against"] == {"arm": "two_link", "drives": False, "payload": None}
    assert told["level"] == model.level.name
    within_80(run("evaluate", "model.json", "--states", 300, "--seed", 7))


def test_a_seed_repeats_the_states(run, model):
    first, same, other = (
        run("evaluate", "model.json", "--states", 50, "--seed", seed, "--json").json["joints"]
        for seed in (1, 1, 2)
    )
    assert first == same
    assert first != other


def test_with_a_payload_along_a_trajectory(run, model, swing, here):
    words = ("evaluate", "model.json", "two-link-swing", "--payload", "0.5,0.01,0,0,0.001,0.001,0.001")
    told = run(*words, "-o", "torque.csv", "--json").json
    loaded = with_payload(model.arm, 0.5, [0.01, 0.0, 0.0], [0.001] * 3)
    here_, without = evaluate(model, swing, loaded).errors, evaluate(model, swing).errors
    assert [row["largest_error"] for row in told["joints"]] == here_.largest.tolist()
    assert [row["peak_torque"] for row in told["joints"]] == here_.peak_torque.tolist()
    assert [row["largest_error_without_payload"] for row in told["joints"]] == without.largest.tolist()
    assert told["held_against"] == {
        "arm": "two_link+0.5kg,0.01,0,0,0.001,0.001,0.001",
        "drives": False,
        "payload": {
            "mass": 0.5,
            "position": [0.01, 0.0, 0.0],
            "inertia": [[0.001, 0.0, 0.0], [0.0, 0.001, 0.0], [0.0, 0.0, 0.001]],
        },
    }
    assert told["arm"] == "two_link"
    assert (told["trajectory"], told["set_points"], told["states"]) == ("two-link-swing", len(swing.q), None)
    assert told["largest_losses"] == []
    rows = np.loadtxt(here / "torque.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(rows[:, 1:3], evaluate(model, swing, loaded).dynamics.torque)
    shown = within_80(run(*words))
    assert "Two-link planar arm carrying 0.5 kg" in shown
    assert "unloaded" in shown


def test_what_may_be_carried(run, model, swing):
    told = run("evaluate", "model.json", "two-link-swing", "--json").json
    effect = payload_effect(model, states_of(swing))
    assert told["mass_within_budget"] == effect.largest_mass > 0
    assert [row["mass_within_budget"] for row in told["joints"]] == effect.mass_within_budget.tolist()
    assert told["limiting_joint"] == effect.limiting_joint
    assert [row["torque_per_kg"] for row in told["joints"]] == effect.torque_per_kg.tolist()
    assert f"(joint {effect.limiting_joint} first)" in within_80(
        run("evaluate", "model.json", "two-link-swing")
    )
    # Just as much, put into the hand, and a hundredth more.
    for factor, within in ((0.99, True), (1.01, False)):
        payload = f"{factor * effect.largest_mass},0,0,0"
        rows = run("evaluate", "model.json", "two-link-swing", "--payload", payload, "--json").json["joints"]
        assert all(row["largest_error"] <= row["allowed_error"] for row in rows) == within


def test_beyond_the_budget_without_a_payload(run, here, motion):
    """Gentle, so that velocity terms may go, which are large elsewhere."""
    arm = load_arm("two_link")
    made = by_elements(arm, gd.read_trajectory(motion, arm), gd.Budget.parse("2%"))
    wide = evaluate(made, states_in_box(made.arm, 500))
    assert not wide.within(made.accuracy.allowed).all()
    save_model(made, here / "model.json")
    shown = within_80(run("evaluate", "model.json", "--states", 500))
    assert "Point mass" not in shown


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("-o", "torque.csv"), "needs a trajectory"),
        (("--payload", "1,0,0"), "payload is not 4, 7 or 10 numbers"),
        (("--payload", "-1,0,0,0"), "negative"),
        (("--states", "0"), "--states"),
        (("--seed", "-1"), "--seed"),
    ],
)
def test_refused(run, here, swing, listing, words, told):
    save_model(by_elements(load_arm("two_link"), swing), here / "model.json")
    result = run("evaluate", "model.json", *words)
    assert (result.code, result.out) == (2, "")
    assert told in result.err
    assert listing() == {"model.json"}


def test_limits_that_are_not_stated_are_stood_in_for(run, here):
    (here / "own.toml").write_text(
        'format = "gd-analyze arm 1"\nname = "own"\n[[joints]]\n[[links]]\nmass = 1.0\n'
        "com = [0.0, 0.0, 0.0]\ninertia = { xx = 0.1, yy = 0.1, zz = 0.1 }\n"
    )
    arm = load_arm(here / "own.toml")
    q = np.linspace(0.0, 1.0, 5)[:, None]
    save_model(by_elements(arm, States(q, q, q)), here / "model.json")
    result = run("evaluate", "model.json")
    assert result.code == 0
    for where in (result.err, result.out):
        assert "a velocity of 2 rad/s of every joint" in " ".join(where.split())


def test_errors_stand_beside_what_is_allowed_and_no_share_of_another_peak(run, here, swing, motion):
    """A share of the peak here would look small beside "no", as the peak of the budget is another one."""
    arm = load_arm("two_link")
    made = by_elements(arm, gd.read_trajectory(motion, arm), gd.Budget.parse("2%"))
    save_model(made, here / "model.json")
    words = ("evaluate", "model.json", "two-link-swing")
    told = run(*words, "--json").json
    exact = evaluate(made, swing)
    for i, row in enumerate(told["joints"]):
        allowed, error = made.accuracy.allowed[i], exact.errors.largest[i]
        assert row["allowed_error"] == allowed
        assert row["within_allowed"] == (row["largest_of_allowed"] <= 1.0) == (error <= allowed)
        assert row["largest_share_of_peak_here"] == error / exact.errors.peak_torque[i]
        assert row["largest_share_of_peak_fitted_on"] == error / made.accuracy.errors.peak_torque[i]
        assert (row["largest_share_of_peak_fitted_on"] <= 0.02) == row["within_allowed"]
        assert row["promised_of_allowed"] <= 1.0
    assert not all(row["within_allowed"] for row in told["joints"])
    shown = within_80(run(*words))
    for row in told["joints"]:
        assert f"{row['largest_of_allowed']:.3g} times" in shown
