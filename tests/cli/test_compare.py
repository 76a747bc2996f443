from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import pytest

import gd_analyze as gd
from gd_analyze.studies import symbolic


def test_files_and_tables(run, here, motion):
    result = run("compare", "two_link", motion)
    assert (result.code, result.err) == (0, "")
    folder = here / "reports" / f"compare-two_link-{Path(motion).stem}"
    assert {path.name for path in folder.iterdir()} == {
        "comparison.html",
        "comparison.pdf",
        "comparison.json",
    }
    told = json.loads((folder / "comparison.json").read_text(encoding="utf-8"))
    for row in told["cost"]["methods"][:-1]:
        assert f"{row['executed']['multiplications']} + {row['executed']['additions']}" in result.out
        assert f"{1e6 * row['seconds']:.2f}" in result.out
    assert told["agrees"]
    assert told["provenance"]["command"].startswith("gd-analyze compare two_link")
    assert "All formulations agree" in result.out
    words = ("compare", "two_link", "--format", "json", "--out", str(folder))
    assert "holds files of another run" in run(*words).err
    assert "comparison.pdf" in run(*words[:2], motion, *words[2:]).err
    assert run(*words, "--overwrite").code == 0
    assert [path.name for path in folder.iterdir()] == ["comparison.json"]


def test_as_json_at_random_states_with_a_payload(run, here):
    result = run("compare", "two_link", "--payload", "2,0,0,0", "--json", "--out", "r", "--format", "json")
    assert (result.code, result.err) == (0, "")
    told = result.json
    assert "500 random states" in told["compared_at"]
    assert "payload of 2 kg" in told["provenance"]["payload"]
    assert told["files"] == ["r/comparison.json"]


def test_the_main_job_carries_a_payload(run, motion):
    bare = run("two_link", motion, "--out", "a", "--format", "json", "--json")
    full = run("two_link", motion, "--out", "b", "--format", "json", "--json", "--payload", "1,0,0,0")
    assert (bare.code, full.code) == (0, 0)
    assert full.json["arm"] == "two_link+1kg"
    peaks = [row["joints"][1]["peak_torque"] for row in (bare.json, full.json)]
    # At rest the second rod's weight acts at half its length, the payload's at its end.
    assert peaks[1] > peaks[0] * 1.5
    carrying = gd.load_model("b/model.json").arm
    assert carrying.mass[-1] == gd.load_arm("two_link").mass[-1] + 1


@pytest.mark.parametrize("payload", ["", "2", "2,0,0,heavy", "-1,0,0,0"])
def test_a_payload_that_is_none_is_refused(run, motion, listing, payload):
    before = listing()
    for verb in ((), ("compare",)):
        result = run(*verb, "two_link", motion, "--payload", payload)
        assert (result.code, result.out) == (2, "")
        assert "payload" in result.err
    assert listing() == before


def test_in_symbols(run, listing, monkeypatch):
    # Both outputs are of the same forms.
    monkeypatch.setattr(symbolic, "two_link_closed_forms", cache(symbolic.two_link_closed_forms))
    result = run("compare", "two_link", "--symbolic")
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    assert "D22 = l**2*m2/3" in result.out
    assert result.out.count("As in FGL87.") == 1
    assert "NOT" not in result.out
    assert listing() == set()
    told = run("compare", "two_link", "--symbolic", "--json").json
    assert all(forms["is_the_text's"] for forms in told["methods"].values())


def test_only_the_two_link_arm_is_worked_in_symbols(run):
    result = run("compare", "puma560", "--symbolic")
    assert result.code == 2
    assert "two_link" in result.err


def test_a_trajectory_of_another_arm_is_refused(run, motion, listing):
    before = listing()
    result = run("compare", "puma560", motion)
    assert result.code == 2
    assert listing() == before
