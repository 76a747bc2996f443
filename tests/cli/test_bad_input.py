"""Every kind of bad input, through the real entry point: exit code 2, a full message, nothing written."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from bad_files import ARM, HEADER, ROWS, csv


@dataclass(frozen=True)
class Case:
    """Files to make, words to type, and what the message must say."""

    name: str
    words: tuple[str, ...]
    says: tuple[str, ...]
    files: dict[str, str | bytes] = field(default_factory=dict)


def trajectory(name: str, content: str | bytes, *says: str, robot: str = "two_link") -> Case:
    return Case(name, (robot, "x.csv"), ("where: x.csv", *says), {"x.csv": content})


def arm(name: str, content: str | bytes, *says: str) -> Case:
    files: dict[str, str | bytes] = {"own.toml": content, "x.csv": csv(*ROWS)}
    return Case(name, ("own.toml", "x.csv"), ("where: own.toml", *says), files)


def words(name: str, line: str, *says: str) -> Case:
    files: dict[str, str | bytes] = {"x.csv": csv(*ROWS), "arm.urdf": '<?xml version="1.0"?>\n<robot/>\n'}
    return Case(name, tuple(line.split()), says, files)


def replaced(k: int, row: str) -> str:
    return csv(*ROWS[:k], row, *ROWS[k + 1 :])


PLAN = "plan two_link --from 0,0 --to 60,-45 --duration 2 -o made.csv"

CASES = (
    words(
        "missing trajectory",
        "two_link nowhere.csv",
        "there is no trajectory 'nowhere.csv'",
        "expected:",
        "next:",
    ),
    words("mistyped trajectory", "puma560 pick-and-plaze", "did you mean the shipped 'pick-and-place'?"),
    words("a folder where one motion is meant", "compare two_link .", "found: Is a directory", "next:"),
    trajectory("empty file", "", "is empty", "expected: the header time,q1,q2", "found: 0 bytes", "next:"),
    trajectory("comments only", "# nothing\n\n", "is empty"),
    trajectory("header only", HEADER + "\n", "holds a header only"),
    trajectory("no header", "\n".join(ROWS), "line 1", "no header line", "--columns time,q1"),
    trajectory(
        "wrong column", csv(*ROWS, header="time,q1,shoulder"), "line 1", "no position of joint", "shoulder"
    ),
    trajectory("duplicate column", csv(*ROWS, header="time,q1,q1"), "line 1, column 3", "q1 is given twice"),
    trajectory("no time", csv(*ROWS, header="q3,q1,q2"), "line 1", "time is missing", "found: q3, q1, q2"),
    trajectory(
        "non-numeric cell",
        replaced(4, "1.0,abc,0.0"),
        "line 6, column 2",
        "q1 is not a number",
        "expected: a number",
        "found: 'abc'",
        "next:",
    ),
    trajectory("empty cell", replaced(4, "1.0,,0.0"), "line 6, column 2", "found: an empty cell"),
    trajectory("short line", replaced(8, "2.0,0.1"), "line 10", "too few columns", "expected: 3", "found: 2"),
    trajectory("NaN", replaced(2, "0.5,nan,0.0"), "line 4, column 2", "not a finite number", "found: nan"),
    trajectory("underscore", replaced(2, "0.5,1_000,0.0"), "line 4, column 2", "found: '1_000'"),
    trajectory("far too early", replaced(0, "-1e308,0,0"), "line 2, column 1", "time is too large"),
    trajectory(
        "huge rates",
        csv("0,0,0,1e150,0", "1,1,1,1e150,0", header=HEADER + ",qd1,qd2"),
        "line 2, column 4",
        "qd1 is too large",
        "up to 1e+12",
    ),
    trajectory(
        "instants too near",
        csv(*(f"{k}e-200,0.{k},0" for k in range(9))),
        "qd cannot be derived",
        "time steps of 1e-200 s",
    ),
    trajectory("infinity", replaced(2, "0.5,0.0,-inf"), "line 4, column 3", "found: -inf"),
    trajectory(
        "fewer than needed rows", csv(*ROWS[:3]), "too few set points", "found: 3 set points", "next:"
    ),
    trajectory("time repeats", replaced(3, "0.5,0.1,0.1"), "line 5, column 1", "time does not increase"),
    trajectory("time goes back", replaced(3, "0.1,0.1,0.1"), "line 5, column 1", "found: 0.1 s"),
    trajectory(
        "wrong number of joints",
        csv(*ROWS),
        "line 1",
        "expected: 6 joints",
        "found: 2 joints",
        robot="puma560",
    ),
    trajectory("a surplus joint", csv("0,0,0,0", header=HEADER + ",q3"), "found: 3 joints"),
    trajectory("UTF-16", csv(*ROWS).encode("utf-16"), "found: UTF-16"),
    trajectory("binary", b"\x89HDF\r\n\x1a\n\0\0", "binary"),
    words(
        "unknown arm", "puma506 x.csv", "there is no arm 'puma506'", "expected:", "did you mean 'puma560'?"
    ),
    words(
        "log and arm exchanged",
        "x.csv two_link",
        "this is no robot's file",
        "a .csv file, as logs and set points are",
        "name the robot first, then the log",
    ),
    words(
        "arm for a log",
        "two_link arm.urdf",
        "this is no log",
        "where: arm.urdf",
        "found: XML",
        "name the robot first, then the log",
    ),
    words("folder for an arm", ". x.csv", "this is no robot's file", "a folder", "name the file in it"),
    words("missing arm file", "nowhere.toml x.csv", "there is no arm 'nowhere.toml'", "gd-analyze arms"),
    arm("malformed TOML", ARM.replace("mass = 2.0", "mass = = 2.0"), "line 8, column 8", "not valid TOML"),
    arm("unknown key", ARM.replace("mass = 2.0", "mas = 2.0"), "links[1]"),
    arm("missing key", ARM.replace("mass = 2.0\n", ""), "line 7", "links[1].mass", "found: nothing"),
    arm("word for a number", ARM.replace("2.0", '"heavy"', 1), "line 8", "found: 'heavy'"),
    arm(
        "huge mass",
        ARM.replace("mass = 2.0", "mass = 1e300"),
        "line 8",
        "less than or equal to 1000000000000",
    ),
    arm("huge gravity", ARM.replace("[[joints]]", "gravity = [0.0, 0.0, -1e308]\n[[joints]]", 1), "line 3"),
    arm("huge length", ARM.replace("a = 1.0", "a = 1e300", 1), "line 4", "joints[1].a"),
    arm("negative mass", ARM.replace("mass = 2.0", "mass = -2.0"), "line 7", "mass of link 1 is negative"),
    arm(
        "a joint that moves no mass",
        ARM.replace("mass = 1.0", "mass = 0.0").replace(
            "xx = 0.0, yy = 0.1, zz = 0.1", "xx = 0, yy = 0, zz = 0"
        ),
        "D is singular: joint 2 (2) moves no mass",
        "set point 1 of 9 set points of x",
        "smallest eigenvalue 0",
        "line 11",
    ),
    arm("infinite mass", ARM.replace("mass = 2.0", "mass = inf"), "line 8", "finite"),
    arm("a link too few", ARM[: ARM.rindex("[[links]]")], "expected: 2 [[links]] tables", "found: 1"),
    arm("binary arm", b"\xff\xfe\0\0", "not text"),
    arm("other TOML", 'name = "x"\n', "format"),
    words("no drives", "two_link x.csv --drives", "describes no drives", "next:"),
    words(
        "unknown format",
        "two_link x.csv --format html,doc",
        "'--format'",
        "'doc'",
        "h5, json, csv, html, pdf",
    ),
    words("no format", "two_link x.csv --format ,", "'--format'"),
    words("negative budget", "two_link x.csv --budget -1", "--budget, entry 1", "found: '-1'"),
    words("NaN budget", "two_link x.csv --budget nan", "--budget, entry 1", "found: 'nan'"),
    words("wordy budget", "two_link x.csv --budget small", "--budget, entry 1", "expected: a share"),
    Case(
        "mixed norm budget",
        ("simplify", "two_link", "--budget", "1% norm or 2%"),
        ("--budget", "expected: a share of the norm of all joints", "next: it is one for all joints"),
    ),
    Case(
        "norm budget of the main job",
        ("two_link", "x.csv", "--budget", "1% norm at 95%"),
        ("the main job's results", 'found: "1% norm at 95% of states"', "next: gd-analyze simplify"),
        {"x.csv": csv(*ROWS)},
    ),
    Case(
        "certified norm budget",
        ("simplify", "two_link", "--states", "20", "--budget", "1% norm", "--certified"),
        ("a certified model cannot be had with a budget of the norm", "next: leave --certified away"),
    ),
    words("too many budgets", "two_link x.csv --budget 1%,1%,1%", "--budget", "expected: 1 or 2", "found: 3"),
    words("negative top", "two_link x.csv --top -1", "'--top'"),
    words("unwritable folder", "two_link x.csv --out x.csv/results", "x.csv is not a folder", "next:"),
    words("unmakeable folder", "two_link x.csv --out /proc/results", "where: /proc/results", "next:"),
    words(
        "no trajectory",
        "two_link",
        "missing argument 'TRAJECTORY...'",
        "ROBOT TRAJECTORY...",
        "gd-analyze --help",
    ),
    words("unknown option", "two_link x.csv --fromat csv", "no such option '--fromat'", "--format"),
    words("surplus argument", "two_link x.csv y.csv", "y.csv"),
    words(
        "mistyped verb",
        "pln two_link --from 0,0",
        "there is no verb 'pln'",
        "did you mean `gd-analyze plan`?",
    ),
    words("missing option of a verb", "plan two_link --from 0,0", "--to", "`gd-analyze plan --help`"),
    words("wrong number of knot values", PLAN.replace("0,0", "0,0,0"), "where: --from", "expected: 2 values"),
    words("knot not a number", PLAN.replace("60,-45", "60,x"), "where: --to, value 2", "found: 'x'"),
    words("knot out of range", PLAN.replace("60,-45", "60,700"), "where: --to", "found: 12.22 rad (700 deg)"),
    words("via out of range", PLAN + " --profile quintic --via 0,300", "where: --via", "outside the range"),
    words("NaN duration", PLAN.replace("duration 2", "duration nan"), "'--duration'", "'nan'"),
    words("endless duration", PLAN.replace("duration 2", "duration 1e308"), "'--duration'", "up to 1e+12"),
    words("short duration", PLAN.replace("duration 2", "duration 1e-300"), "where: duration", "1e-06 s to"),
    words("a huge knot", PLAN.replace("60,-45", "60,1e300"), "where: --to"),
    words("an underscore in a knot", PLAN.replace("60,-45", "60,4_5"), "where: --to, value 2", "'4_5'"),
    words("margin without a kind", "two_link x.csv --margin 2%", "--margin, entry 1", "qd=2%", "found: '2%'"),
    words("negative margin", "two_link x.csv --margin 1deg,-1mm", "--margin, entry 2", "found: '-1mm'"),
    words("two margins", "two_link x.csv --margin qd=1%,qd=2%", "--margin, entry 2", "given twice"),
    words("huge margin", "two_link x.csv --margin 1e308rad", "Margin, turning", "up to 1e+12"),
    words("huge budget", "two_link x.csv --budget 1e308", "--budget, entry 1", "up to 1e+12"),
    words("huge payload", "rank two_link x.csv --payload 1e300,0,0,0", "mass of link payload is too large"),
    words(
        "payload far away", "rank two_link x.csv --payload 1,1e200,0,0", "com of link payload is too large"
    ),
    words("an endless trajectory", "two_link /dev/zero", "where: /dev/zero", "a binary file"),
    words("an endless model", "evaluate /dev/zero x.csv", "where: /dev/zero"),
    words("negative duration", PLAN.replace("duration 2", "duration -2"), "'--duration'", "'-2'"),
    words("one point", PLAN + " --points 1", "'--points'"),
    words("unknown profile", PLAN + " --profile quintc", "'--profile'", "quintic"),
    words("vias the profile cannot take", PLAN + " --via 1,1", "where: --via", "found: 1"),
    words("too fast", PLAN.replace("duration 2", "duration 0.1"), "too fast", "--allow-violations"),
    words("plan into a file's inside", PLAN.replace("made.csv", "x.csv/made.csv"), "where: x.csv/made.csv"),
    words("--to without an arm", "arms --to toml", "--to needs a ROBOT"),
    words("missing model", "evaluate nowhere.json x.csv", "where: nowhere.json"),
    words("a foreign model", "evaluate x.csv x.csv", "where: x.csv", "not valid JSON"),
    words("a foreign model of a verdict", "validate x.csv x.csv x.csv", "where: x.csv", "not valid JSON"),
    words("a verdict on nothing", "validate x.csv", "missing argument 'TRAJECTORY...'", "MODEL TRAJECTORY"),
    words("JUnit into a file's inside", "validate x.csv x.csv --junit x.csv/j.xml", "with --junit"),
    Case("other JSON", ("evaluate", "m.json", "x.csv"), ("not a gd-analyze model",), {"m.json": "{}"}),
    Case(
        "a binary model",
        ("evaluate", "m.json", "x.csv"),
        ("found: a file that is not text",),
        {"m.json": b"\xff"},
    ),
    words("a shell without a script", "completion tcsh", "'tcsh'", "bash"),
)


@pytest.mark.parametrize("as_json", [False, True], ids=["text", "json"])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_bad_input(run, here: Path, listing: Callable[[], set[str]], case: Case, as_json: bool):
    for name, content in case.files.items():
        (here / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    before = listing()
    flags = ("--json",) if as_json and case.words[0] != "completion" and "toml" not in case.words else ()
    result = run(*case.words, *flags)
    assert result.code == 2, result
    assert result.out == ""
    assert result.err.startswith("error: ")
    for text in case.says:
        assert text in result.err
    assert "Traceback" not in result.err
    assert not re.search(r"\bNone\b|<class|object at 0x", result.err)
    assert listing() == before


def test_an_inertia_that_makes_d_indefinite_is_told_and_refused(run, here):
    (here / "own.toml").write_text(ARM.replace("zz = 0.1", "zz = -1.0"))
    (here / "x.csv").write_text(csv(*ROWS))
    for words in (
        "own.toml x.csv",
        "simplify own.toml x.csv",
        "rank own.toml x.csv",
        "compare own.toml x.csv",
    ):
        result = run(*words.split())
        assert (result.code, result.out) == (2, "")
        told, error = result.err.split("error: ")
        assert "line 11: the inertia of link 2 is physically inconsistent" in told
        assert "D is not positive definite, by the inertia of link 2" in error
        assert "where: own.toml, line 11" in error
        assert "at set point " in error
        assert "next: mend that inertia" in error


def test_a_damaged_model_is_refused(run, here, motion):
    assert run("two_link", motion, "--out", "r", "--format", "json").code == 0
    path = here / "r/model.json"
    sound = path.read_text(encoding="utf-8")
    document = json.loads(sound)
    damaged = {
        "cut off": sound[: len(sound) // 2],
        "other version": json.dumps(document | {"version": 99}),
        "a term less": json.dumps(document | {"terms": document["terms"][1:]}),
        "of version 1": json.dumps(document | {"version": 1}),
        "mass changed": sound.replace('"mass": 2.0', '"mass": 2.5'),
        "arm gone": json.dumps(document | {"arm": {}}),
        "word for a number": sound.replace('"mass": 2.0', '"mass": "heavy"'),
        "unknown key": json.dumps(document | {"surplus": 1}),
    }
    for name, text in damaged.items():
        assert text != sound, name
        path.write_text(text, encoding="utf-8")
        result = run("evaluate", path, motion, "-o", "torque.csv")
        assert (result.code, result.out) == (2, ""), name
        assert result.err.startswith("error: "), name
        assert "model.json" in result.err, name
        assert not (here / "torque.csv").exists(), name


def test_a_failed_run_leaves_earlier_results_alone(run, here, motion):
    assert run("two_link", motion, "--out", "r").code == 0
    before = {path.name: path.read_bytes() for path in (here / "r").iterdir()}
    assert run("two_link", motion, "--out", "r", "--budget", "1%,1%,1%").code == 2
    assert {path.name: path.read_bytes() for path in (here / "r").iterdir()} == before
