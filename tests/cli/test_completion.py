from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gd_analyze.motions.csv_file import shipped_trajectories
from gd_analyze.robots.catalogue import builtin_arms

VERBS = [
    "report",
    "arms",
    "columns",
    "plan",
    "simplify",
    "rank",
    "trade-off",
    "evaluate",
    "validate",
    "equations",
    "compare",
    "certify",
    "control",
    "export",
]
VERBS += ["completion"]


@pytest.fixture
def complete(process, monkeypatch):
    """What the program offers for the last word, by the protocol of the fish script."""

    def offer(*words: str) -> list[str]:
        *before, last = words
        monkeypatch.setenv("_GD_ANALYZE_COMPLETE", "fish_complete")
        monkeypatch.setenv("COMP_WORDS", " ".join(["gd-analyze", *before]))
        monkeypatch.setenv("COMP_CWORD", last)
        result = process()
        assert result.err == ""
        kinds = [entry.split(",", 1) for entry in result.out.split("\n") if "," in entry]
        return [value.split("\t")[0] for kind, value in kinds if kind == "plain"]

    return offer


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_script_for_every_shell(run, shell):
    result = run("completion", shell)
    assert (result.code, result.err) == (0, "")
    assert f"_GD_ANALYZE_COMPLETE={shell}_complete" in result.out


def test_the_first_word_is_an_arm_or_a_verb(complete):
    assert complete("") == [*builtin_arms(), *VERBS]
    assert complete("pu") == ["puma560"]
    assert complete("pl") == ["plan"]
    assert "--out" in complete("--o")


def test_what_comes_next(complete):
    assert complete("puma560", "") == list(shipped_trajectories())
    assert complete("puma560", "pick-and-place", "--no-c") == ["--no-christoffel", "--no-cache"]
    assert complete("--out", "x", "two_link", "two") == ["two-link-swing"]
    assert complete("plan", "two") == ["two_link"]
    assert complete("plan", "two_link", "--profile", "c") == ["cubic"]
    assert complete("evaluate", "model.json", "wr") == ["wrist-move"]
    assert complete("two_link", "x.csv", "--format", "h") == ["h5", "html"]
    assert complete("two_link", "x.csv", "--format", "h5,h") == ["h5,html"]
    assert complete("arms", "") == list(builtin_arms())


@pytest.mark.skipif(shutil.which("bash") is None, reason="runs the script in bash, which is not installed")
def test_the_script_works_in_bash(here: Path):
    program = here / "bin" / "gd-analyze"
    program.parent.mkdir()
    program.write_text(f"#!{sys.executable}\nfrom gd_analyze.cli import main\nmain()\n")
    program.chmod(0o755)
    script = """
eval "$(gd-analyze completion bash)"
compopt() { :; }  # works during a completion only
offer() {
  COMPREPLY=()
  _gd_analyze_completion gd-analyze
  echo "${COMPREPLY[*]}"
}
COMP_WORDS=(gd-analyze pu) COMP_CWORD=1
offer
COMP_WORDS=(gd-analyze puma560 pi) COMP_CWORD=2
offer
"""
    done = subprocess.run(
        ["bash", "-euc", script],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PATH": f"{program.parent}:{os.environ['PATH']}"},
    )
    assert (done.stdout, done.stderr) == ("puma560\npick-and-place\n", "")
