"""`gd-analyze rank` and `gd-analyze trade-off`: what they print, and what they refuse."""

from __future__ import annotations

import dataclasses

import pytest

from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_toml import toml_of
from gd_analyze.studies.comparison_costs import generic_chain
from parallel_axes import arm_of

RANK = ("rank", "two_link", "two-link-swing")
CURVE = ("trade-off", "two_link", "two-link-swing")


def test_the_ranking_on_80_columns(run):
    result = run("rank", "puma560", "pick-and-place", "--top", 8)
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    told = run("rank", "puma560", "pick-and-place", "--json").json
    shown = [term["term"] for term in told["terms"] if term["term"] in result.out]
    assert shown[:8] == [term["term"] for term in told["terms"][:8]]
    assert told["terms"][8]["term"] not in result.out
    assert 0 < told["needed_for_0.01"] < told["needed_for_0.001"]
    assert len(told["torque_uncertainty"]) == 6


def test_an_arm_without_stated_uncertainty_says_so(run):
    assert run(*RANK, "--json").json["torque_uncertainty"] is None


def test_terms_of_the_energies(run):
    told = run(*RANK, "--level", "energy", "--json").json
    assert {term["label"] for term in told["terms"]} == {"D'11", "D'12", "D'22", "U"}
    assert told["states"]["trajectory"] == "two-link-swing"
    with_drives = run("rank", "puma560", "--drives", "--states", 50, "--seed", 2, "--json").json
    assert with_drives["drives"]
    assert with_drives["states"]["seed"] == 2


@pytest.mark.parametrize("quick", [(), ("--quick",)])
def test_the_curve_on_80_columns(run, quick):
    result = run(*CURVE, *quick)
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    told = run(*CURVE, *quick, "--json").json
    assert len(told["points"]) == 6 * 7
    for point in told["points"]:
        assert point["largest_share"] <= float(point["budget"].rstrip("%")) / 100 * (1 + 1e-9)
        assert str(point["operations"]["total"]) in result.out
    assert [point["budget"] for point in told["points"]][:3] == ["0.1%", "0.2%", "0.5%"]


REFUSED = {
    "rank an unknown level": ((*RANK, "--level", "element"), "--level"),
    "rank without drives": ((*RANK, "--drives"), "describes no drives"),
    "curve of a strange budget": ((*CURVE, "--budget", "some"), "--budget"),
    "curve without states": (("trade-off", "puma560", "--states", 0), "--states"),
}


@pytest.mark.parametrize(("words", "told"), REFUSED.values(), ids=REFUSED.keys())
def test_refused(run, words, told):
    result = run(*words)
    assert (result.code, result.out) == (2, "")
    assert told in result.err
    assert "Traceback" not in result.err


def file_of(arm: RobotArm) -> str:
    """An arm with limits to draw states from."""
    limits = {"lower": -2.0, "upper": 2.0, "velocity_limit": 2.0, "acceleration_limit": 5.0}
    return toml_of(
        dataclasses.replace(arm, joints=tuple(dataclasses.replace(j, **limits) for j in arm.joints))
    )


def test_of_many_terms_no_more_is_said_than_holds(run, here):
    """Terms that are not ranked count, too: with them the listed ones may not keep to any share."""
    (here / "own.toml").write_text(file_of(generic_chain(5)), encoding="utf-8")
    words = ("rank", "own.toml", "--states", 40, "--top", 1)
    told = run(*words, "--json").json
    assert told["unlisted_share"] > 0.001
    assert told["unlisted"] == 2435
    assert "needed_for_0.001" not in told


def test_far_too_many_terms_are_refused_with_what_to_do_instead(run, here, rng):
    (here / "own.toml").write_text(file_of(arm_of(["askew"] * 7, rng)), encoding="utf-8")
    result = run("rank", "own.toml", "--states", 40)
    assert (result.code, result.out) == (2, "")
    said = " ".join(result.err.split())
    assert "has too many terms to look at them one by one" in said
    assert "expected: at most 60000 torque terms" in said
    assert "next: `gd-analyze simplify ROBOT --level recursive` simplifies such an arm" in said
