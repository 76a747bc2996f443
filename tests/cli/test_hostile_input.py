"""Input that nobody types by mistake: a named error and exit code 2, never a traceback or "a bug"."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from bad_files import ARM

import gd_analyze as gd

ACTING = "\x1b[2J\u202e\x9b\x07"
MOTION = "time,q1,q2\n" + "".join(f"{0.25 * k},{0.02 * k * k},{-0.01 * k * k}\n" for k in range(9))


def toml_with(**changes: str) -> str:
    """The plain arm with a line in front of its first joint's or link's keys, or of the file's."""
    text = ARM
    for place, line in changes.items():
        mark = {"top": 'name = "own"', "joint": "[[joints]]", "link": "[[links]]"}[place]
        text = text.replace(mark, f"{mark}\n{line}", 1)
    return text


DEEP = "[" * 5000 + "]" * 5000
TOML = {
    "integer of thousands of digits": (toml_with(joint="d = " + "7" * 5000), "line 4", "thousands of digits"),
    "hexadecimal integer": (toml_with(joint="d = 0x" + "f" * 5000), "joints[1].d", "too large to be shown"),
    "integer no float holds": (toml_with(joint="d_mm = 1" + "0" * 400), "joints[1].d", "a valid number"),
    "nested lists": (toml_with(top=f"sources = {DEEP}"), "nests", "own.toml"),
    "nested tables": (toml_with(top=".".join("a" * 5000) + " = 1"), "own.toml", "too large to be shown"),
    "list as a name": (toml_with(joint="name = [1]"), "joints[1].name", "a valid string"),
    "strings as limits": (toml_with(joint='range_deg = ["a", "b"]'), "joints[1].range", "'a'"),
    "escape sequence in a name": (
        toml_with(joint='name = "\\u001b[2J\\u202e"'),
        "joint's name",
        "\\x1b[2J\\u202e",
    ),
    "newline in a title": (toml_with(top='title = "a\\nerror: b"'), "title", "a\\nerror: b"),
    "escape sequence in a source": (toml_with(top='sources = ["\\u001b[2J"]'), "source", "\\x1b[2J"),
    "long value": (toml_with(joint='d = "' + "x" * 100_000 + '"'), "joints[1].d", "characters) ..."),
}


@pytest.mark.parametrize("name", TOML)
def test_arm_files(run, here, name):
    content, *says = TOML[name]
    (here / "own.toml").write_text(content)
    result = run("arms", "own.toml")
    assert (result.code, result.out) == (2, "")
    assert all(text in result.err for text in says), result.err
    assert_is_a_message(result.err)


def assert_is_a_message(err: str) -> None:
    assert "this is a bug" not in err
    assert "Traceback" not in err
    assert all(line.isprintable() and len(line) < 1100 for line in err.splitlines())


@pytest.fixture
def document(here):
    """A model file's content; its digest is made anew by the caller that changes it."""
    arm = gd.load_arm("two_link")
    model = gd.simplify(arm, gd.read_trajectory("two-link-swing", arm))
    gd.save_model(model, here / "m.json")
    return json.loads((here / "m.json").read_text())


def _set(document, path, value):
    *keys, last = path
    for key in keys:
        document = document[key]
    document[last] = value


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("arm", "joints", 0, "name"), [1]),
        (("arm", "joints", 0, "name"), "\x1b[2J"),
        (("arm", "joints", 0, "upper"), "3.1"),
        (("arm", "joints", 0, "velocity_limit"), [3]),
        (("arm", "links", 0, "mass"), "1.0"),
        (("arm", "links", 0, "name"), {"a": 1}),
        (("arm", "title"), None),
        (("arm", "name"), 7),
        (("arm", "gravity"), ["0", "0", "1"]),
        (("arm",), []),
        (("terms", 0), []),
        (("version",), "\x1b" * 10_000),
        (("level",), {"term": 1}),
    ],
)
def test_wrong_kinds_in_model_files(run, here, document, path, value):
    from gd_analyze.simplification.model_file import _digest

    _set(document, path, value)
    document["digest"] = _digest(document)
    (here / "m.json").write_text(json.dumps(document))
    result = run("evaluate", "m.json", "two-link-swing")
    assert result.code == 2
    assert "m.json" in result.err
    assert_is_a_message(result.err)


def test_a_factor_of_more_joints_than_the_arm_has(run, here, document):
    from gd_analyze.simplification.model_file import _digest

    text, count = re.subn(r'\["(cos|sin)", \[\d, \d\]', r'["\1", [0, 0, 1]', json.dumps(document), count=1)
    assert count == 1
    changed = json.loads(text)
    changed["digest"] = _digest(changed)
    (here / "m.json").write_text(json.dumps(changed))
    result = run("evaluate", "m.json", "two-link-swing")
    assert result.code == 2
    assert "no factor of the arm's equations" in result.err
    assert_is_a_message(result.err)


@pytest.mark.parametrize("text", ["[" * 100_000, '{"a":' * 100_000, '{"format": ' + "7" * 5000 + "}"])
def test_json_that_python_does_not_read(run, here, text):
    (here / "m.json").write_text(text)
    result = run("evaluate", "m.json")
    assert result.code == 2
    assert "where: m.json" in result.err
    assert_is_a_message(result.err)


@pytest.mark.parametrize(
    "words",
    ["{} x.csv", "two_link {}", "evaluate {}", "report {}", "equations two_link -o {}", "arms {}.toml"],
)
def test_a_name_longer_than_names_can_be(run, words):
    result = run(*words.format("x" * 300).split())
    assert (result.code, result.out) == (2, "")
    assert "xxx" in result.err
    assert_is_a_message(result.err)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows allows no control characters in file names")
def test_a_file_name_does_not_act(run, here):
    name = f"a{ACTING}\nerror: b.csv"
    (here / name).write_text(MOTION.replace("0.08", "x"))
    assert_is_a_message(run("two_link", name).err)
    (here / name).write_text(MOTION)
    result = run("two_link", name, "--format", "json")
    assert result.code == 0
    assert all(line.isprintable() for line in result.out.replace("\u00a0", " ").splitlines())
    assert "\\x1b[2J\\u202e" in result.out


def test_a_header_does_not_act(run, here):
    (here / "x.csv").write_text(MOTION.replace("q2", ACTING * 1000))
    result = run("two_link", "x.csv")
    assert result.code == 2
    assert "x.csv" in result.err
    assert_is_a_message(result.err)


@pytest.mark.skipif(sys.platform == "win32", reason="`>&-` closes streams in POSIX shells only")
@pytest.mark.parametrize(
    ("words", "closed", "code", "says"),
    [
        ("arms", ">&-", 1, "standard output is closed"),
        ("arms puma560 --json", ">&-", 1, "standard output is closed"),
        ("arms puma560 --to toml", ">&-", 1, "standard output is closed"),
        ("two_link gentle.csv --format json --quiet", ">&-", 0, ""),
        ("two_link -", "<&-", 2, "standard input is closed"),
        ("two_link nowhere.csv", "2>&-", 2, ""),
        ("two_link gentle.csv --format json --quiet", "<&- >&- 2>&-", 0, ""),
    ],
)
def test_closed_streams(motion, words, closed, code, says):
    program = f"{shlex.quote(sys.executable)} -c 'from gd_analyze.cli import main; main()'"
    done = subprocess.run(
        f"{program} {words} {closed}", shell=True, capture_output=True, text=True, check=False
    )
    assert done.returncode == code
    assert says in done.stderr
    assert_is_a_message(done.stderr)
    if code == 0:
        assert gd.load_model(Path("reports/two_link-gentle/model.json")).arm.name == "two_link"


def chain(n: int) -> str:
    """An arm of n joints in general position."""
    joint = "[[joints]]\na = 0.3\nd = 0.1\nalpha_deg = 70.0\n"
    inertia = "{ xx = 0.1, yy = 0.12, zz = 0.13, xy = 0.01 }"
    link = f"[[links]]\nmass = 1.0\ncom = [-0.1, 0.02, 0.03]\ninertia = {inertia}\n"
    return f'format = "gd-analyze arm 1"\nname = "chain"\n{joint * n}{link * n}'


@pytest.mark.parametrize("n", [12, 30, 70])
def test_exact_equations_of_long_arms_are_refused_before_the_work(run, here, n):
    (here / "chain.toml").write_text(chain(n))
    result = run("equations", "chain.toml")
    assert (result.code, result.out) == (2, "")
    assert f"found: {n} joints" in result.err
    assert "GB" in result.err
    assert "--level element" in result.err
    assert "--no-christoffel" not in result.err
    assert_is_a_message(result.err)


def test_out_of_memory_advises_only_what_the_verb_has(process):
    before = (
        "import gd_analyze.harmonics.transform as t\n"
        "def refuse(arm): raise MemoryError('7 TiB')\nt._cut = refuse"
    )
    result = process("equations", "two_link", before=before)
    assert result.code == 1
    assert "out of memory" in result.err
    assert "--no-christoffel" not in result.err


NO_INERTIA = "inertia = { xx = 0.0, yy = 0.0, zz = 0.0 }"
STILL = "time,q1,q2,qd1,qd2,qdd1,qdd2\n"
HANGING = STILL + "".join(f"{0.1 * k},{-1.5707963267948966},0,0,0,0,0\n" for k in range(9))
RESTING = "time,q1,q2\n" + "".join(f"{0.1 * k},0.3,0.2\n" for k in range(9))


@pytest.mark.parametrize(("robot", "motion"), [("two_link", HANGING), ("own.toml", RESTING)])
@pytest.mark.parametrize("flags", [("--json",), ("--format", "html,pdf,json,csv")])
def test_a_motion_that_needs_no_torque_is_told_so(run, here, robot, motion, flags):
    """Round-off is neither ranked nor a peak that errors are shares of."""
    (here / "own.toml").write_text(ARM)
    (here / "m.csv").write_text(motion)
    result = run(robot, "m.csv", *flags)
    assert result.code == 0
    assert result.err.count("needs torque here beyond round-off") == 1
    assert len(result.err.splitlines()) == 1
    if "--json" in flags:
        assert result.json["headline"].startswith("No joint needs torque along this trajectory")
        assert all(joint["peak_torque"] == 0.0 for joint in result.json["joints"])
        assert all(row["torque_peak"] == 0.0 for row in result.json["dominance"])
        assert all(row["certified_share"] is None for row in result.json["beyond"])
        assert result.json["terms"] == []
    else:
        assert "No joint needs torque along this trajectory" in result.out
        assert "Certified" not in result.out


@pytest.mark.parametrize("verb", ["", "simplify", "rank", "compare"])
def test_an_arm_without_mass_is_refused(run, here, verb):
    links = f"[[links]]\nmass = 0.0\ncom = [0.0, 0.0, 0.0]\n{NO_INERTIA}\n"
    joints = "[[joints]]\na = 1.0\n"
    (here / "own.toml").write_text(f'format = "gd-analyze arm 1"\nname = "own"\n{joints * 2}{links * 2}')
    (here / "m.csv").write_text(MOTION)
    result = run(*verb.split(), "own.toml", "m.csv")
    assert (result.code, result.out) == (2, "")
    assert "error: the mass matrix D is singular: joint 1 (1) moves no mass" in result.err
    assert "where: own.toml, line 7" in result.err
