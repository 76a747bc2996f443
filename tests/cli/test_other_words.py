"""What is said where people type other words than verbs, functions and languages, or name another format."""

from __future__ import annotations

import re

import pytest

from gd_analyze.cli.app import app
from gd_analyze.cli.other_words import _OF_VERBS, OF_FUNCTIONS, OF_LANGUAGES
from gd_analyze.exporting.names import LANGUAGES
from gd_analyze.robots.other_formats import _BY_SUFFIX

WORDS = [word for words in _OF_VERBS for word in words.split()]


def commands_in(text: str) -> list[str]:
    return re.findall(r"`gd-analyze ([^`]*)`", text)


@pytest.mark.parametrize("word", WORDS)
def test_a_word_in_place_of_a_verb_is_answered_by_a_command(run, word):
    result = run(word)
    assert (result.code, result.out) == (2, "")
    assert result.err.startswith(f"error: there is no verb '{word}'")
    assert "\n  next: " in result.err


@pytest.mark.parametrize("said", _OF_VERBS.values())
def test_the_commands_named_exist(said):
    for command in commands_in(said):
        verb, *rest = command.split()
        parameters = app.commands[verb if verb in app.commands else "analyze"].params
        options = {name for parameter in parameters for name in parameter.opts} | {"--help", "--version"}
        assert verb in app.commands or verb in ("ROBOT", "VERB", "--help", "--version"), command
        assert {word for word in rest if word.startswith("--")} <= options, command


def test_every_word_is_answered_once():
    assert len(set(WORDS)) == len(WORDS)
    assert not {*WORDS} & {*app.commands}


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("torque my.urdf log.csv", ("`gd-analyze my.urdf log.csv`", "equations my.urdf --at")),
        ("gravity my.urdf", ("equations my.urdf --element c",)),
        ("regressor my.urdf", ("export my.urdf --to python --what regressor",)),
        ("inverse-dynamics my.urdf --json", ("`gd-analyze my.urdf TRAJECTORY`",)),
        ("jacobain my.urdf", ("computeJointJacobians",)),
        ("identification my.urdf log.csv", ("identify my.urdf log.csv",)),
        ("pln two_link", ("did you mean `gd-analyze plan`?",)),
        ("export two_link --to c++", ("error: --to: ", "next: give cpp")),
        ("export two_link --to matlb", ("did you mean matlab?",)),
        ("export two_link --to c --what inertia", ("error: --what: ", "always written")),
        ("export two_link --to c --what forward-dynamics", ("next: give forward\n",)),
        ("export two_link --to c --what regresor", ("did you mean regressor?",)),
        ("export two_link --to c --what nothing", ("see `gd-analyze export --help`",)),
    ],
)
def test_what_the_user_typed_stands_in_the_answer(run, words, says):
    result = run(words)
    assert (result.code, result.out) == (2, "")
    for text in says:
        assert text in result.err


def test_a_file_of_that_name_is_taken_as_the_arm(run, here):
    (here / "torque").write_text("format = 'gd-analyze arm 1'\n")
    assert "error: torque: name is missing" in run("torque x.csv").err


@pytest.mark.parametrize("table", [OF_FUNCTIONS, OF_LANGUAGES])
def test_what_to_give_in_place_can_be_given(table):
    what = next(option for option in app.commands["export"].params if option.name == "functions")
    names = what.type.names if table is OF_FUNCTIONS else LANGUAGES
    given = [match[1] for said in table.values() if (match := re.match(r"give (\w+)", said))]
    assert given
    assert {*given} <= {*names}
    assert not {*table} & {*names}


@pytest.mark.parametrize("suffix", _BY_SUFFIX)
def test_another_format_says_what_makes_a_file_that_is_read(run, here, suffix):
    (here / f"robot{suffix}").write_text("whatever {\n")
    for words in (f"arms robot{suffix}", f"equations robot{suffix}", f"robot{suffix} x.csv"):
        result = run(words)
        assert (result.code, result.out) == (2, "")
        assert f"error: robot{suffix}: robots of this format are not read" in result.err
        assert "\n  next: " in result.err
