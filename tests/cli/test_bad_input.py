"""Bad and hostile input, through the real entry point: exit code 2, place and fact, nothing written."""

from __future__ import annotations

import json
import math
import re
import sys

import pytest

import gd_analyze as gd
from chains import generic_chain
from made_models import signed
from parallel_axes import arm_of
from robot_files import fingers, two_joints

HEADER = "time,q1,q2"
ROWS = tuple(f"{0.25 * k},{0.02 * k * k},{-0.01 * k * k}" for k in range(9))
ARM = """\
format = "gd-analyze arm 1"
name = "own"
[[joints]]
a = 1.0
[[joints]]
a = 1.0
[[links]]
mass = 2.0
com = [-0.5, 0.0, 0.0]
inertia = { xx = 0.0, yy = 0.2, zz = 0.2 }
[[links]]
mass = 1.0
com = [-0.5, 0.0, 0.0]
inertia = { xx = 0.0, yy = 0.1, zz = 0.1 }
"""
PLAN = "plan two_link --from 0,0 --to 60,-45 --duration 2 -o made.csv"


def csv(*rows: str, header: str = HEADER) -> str:
    return "\n".join([header, *rows]) + "\n"


def replaced(k: int, row: str) -> str:
    return csv(*ROWS[:k], row, *ROWS[k + 1 :])


def toml_with(**lines: str) -> str:
    """The plain arm with a line in front of its first joint's or link's keys, or of the file's."""
    text = ARM
    for place, line in lines.items():
        mark = {"top": 'name = "own"', "joint": "[[joints]]", "link": "[[links]]"}[place]
        text = text.replace(mark, f"{mark}\n{line}", 1)
    return text


MOTION = csv(*ROWS)
WITH_TORQUES = f"{HEADER},torque1,torque2"
TORQUES = csv(
    *(f"{0.01 * k},{math.sin(0.02 * k)},{math.cos(0.03 * k)},{k % 7},{k % 5}" for k in range(400)),
    header=WITH_TORQUES,
)
# Content of x.csv, and what the message must name; the arm is two_link. Others are tested where it is read.
MOTIONS: dict[str, tuple[str | bytes, tuple[str, ...]]] = {
    "header only": (HEADER + "\n", ("header",)),
    "no header": ("\n".join(ROWS), ("line 1", "--map")),
    "wrong column": (csv(*ROWS, header="time,q1,shoulder"), ("line 1", "shoulder")),
    "no time": (csv(*ROWS, header="q3,q1,q2"), ("line 1", "found: q3, q1, q2")),
    "a word for a number": (replaced(4, "1.0,abc,0.0"), ("line 6, column 2", "found: 'abc'")),
    "empty cell": (replaced(4, "1.0,,0.0"), ("line 6, column 2",)),
    "short line": (replaced(8, "2.0,0.1"), ("line 10", "expected: 3", "found: 2")),
    "huge velocity": (
        csv("0,0,0,1e150,0", "1,1,1,1e150,0", header=HEADER + ",qd1,qd2"),
        ("line 2, column 4", "1e+12"),
    ),
    "instants too near": (csv(*(f"{k}e-200,0.{k},0" for k in range(9))), ("1e-200 s",)),
    "too few rows": (csv(*ROWS[:3]), ("found: 3",)),
    "a joint too many": (csv("0,0,0,0", header=HEADER + ",q3"), ("line 1, column 4", "q3")),
    "UTF-16": (MOTION.encode("utf-16"), ("found: UTF-16",)),
    "binary": (b"\x89HDF\r\n\x1a\n\0\0", ("binary",)),
    "a header that acts": (MOTION.replace("q2", "\x1b[2J\u202e\x9b\x07" * 1000), ("x.csv",)),
}

MASSLESS = ARM.replace("mass = 1.0", "mass = 0.0").replace(
    "xx = 0.0, yy = 0.1, zz = 0.1", "xx = 0, yy = 0, zz = 0"
)
INDEFINITE = ARM.replace("zz = 0.1", "zz = -1.0")
# Content of own.toml, and what the message must name. Others are tested where the file is read.
ARMS: dict[str, tuple[str | bytes, tuple[str, ...]]] = {
    "malformed TOML": (ARM.replace("mass = 2.0", "mass = = 2.0"), ("line 8, column 8",)),
    "missing key": (ARM.replace("mass = 2.0\n", ""), ("line 7", "links[1].mass")),
    "too large": (ARM.replace("mass = 2.0", "mass = 1e300"), ("line 8", "1e+12")),
    "negative mass": (ARM.replace("mass = 2.0", "mass = -2.0"), ("line 8", "links[1].mass is negative")),
    "a link too few": (ARM[: ARM.rindex("[[links]]")], ("expected: 2", "found: 1")),
    "no text": (b"\xff\xfe\0\0", ("own.toml",)),
    "an integer of thousands of digits": (toml_with(joint="d = " + "7" * 5000), ("line 4",)),
    "an integer that no float holds": (toml_with(joint="d_mm = 1" + "0" * 400), ("joints[1].d",)),
    "nested lists": (toml_with(top="sources = " + "[" * 5000 + "]" * 5000), ("own.toml",)),
    "a list as a name": (toml_with(joint="name = [1]"), ("joints[1].name",)),
    "an escape sequence": (toml_with(joint='name = "\\u001b[2J\\u202e"'), ("\\x1b[2J\\u202e",)),
    "a long value": (toml_with(joint='d = "' + "x" * 100_000 + '"'), ("joints[1].d", "characters")),
}
# Content of model.json.
MODELS: list[tuple[str, tuple[str, ...]]] = [
    ("[" * 100_000, ("nested",)),
    ("{}", ("found: other JSON",)),
    ('{"format": "gd-ana', ("line 1, column 12",)),
]

# Words of the command, those behind "|" as one, and what the message must name.
WORDS: dict[str, tuple[str, ...]] = {
    # What is named
    "two_link nowhere.csv": ("nowhere.csv",),
    "puma560 pick-and-plaze": ("'pick-and-place'",),
    "puma506 x.csv": ("'puma560'",),
    "nowhere.toml x.csv": ("nowhere.toml",),
    "evaluate nowhere.json x.csv": ("error: nowhere.json",),
    "report none.h5": ("none.h5",),
    "report m.json": ("m.json",),
    "two_link /dev/zero": ("error: /dev/zero",),
    "evaluate /dev/zero x.csv": ("error: /dev/zero",),
    "formulations two_link .": ("directory",),
    ". x.csv": ("folder",),
    "two_link empty": ("empty",),
    "two_link moves": ("moves/b.csv",),
    "x.csv two_link": (".csv",),
    "evaluate x.csv x.csv": ("error: x.csv", "motion", "model.json"),
    "certify x.csv": ("motion", "`gd-analyze simplify ROBOT x.csv -o model.json`"),
    "certify pick-and-place": ("error: pick-and-place", "motion", "model.json"),
    "certify puma560": ("an arm", "`gd-analyze simplify puma560 -o model.json`"),
    "certify robot.urdf": ("error: robot.urdf", "an arm"),
    "certify .": ("model.json",),
    "two_link arm.urdf": ("arm.urdf", "XML"),
    "arms cut.urdf": ("error: cut.urdf, line 11", "<robot>", "line 1\n"),
    **{f"{words} {'x' * 300}": ("xxx",) for words in ("two_link", "evaluate", "equations two_link -o")},
    # What does not fit the arm
    "puma560 x.csv": ("line 1", "q1, q2"),
    "formulations puma560 x.csv": ("q1, q2",),
    "certify m.json --along pick-and-place": ("pick-and-place",),
    "two_link x.csv --drives": ("arm two_link", "[[drives]]"),
    "formulations puma560 --symbolic": ("two_link",),
    "compare puma560": ("OTHER", "`gd-analyze formulations puma560`"),
    "compare puma560 pick-and-place": ("OTHER", "pick-and-place", "`gd-analyze formulations puma560`"),
    "compare puma560 two_link": ("numbers of joints", "puma560: 6", "two_link: 2", "--tip"),
    "compare two_link own.urdf": ("own.urdf",),
    "compare two_link two_link x.csv y.csv": ("y.csv",),
    "equations two_link --at 0": ("error: --at", "expected: 2 values", "found: 1"),
    "equations two_link --at 0,x": ("error: --at, value 2", "degrees", "found: 'x'"),
    "equations two_link --at 0,5mm": ("error: --at, value 2", "'5mm'"),
    "equations two_link --at 0,0 --velocity 1": ("error: --velocity", "expected: 2 values"),
    "equations two_link --velocity 1,1": ("--velocity needs --at",),
    "equations two_link --at 0,0 --element D13": ("'D13'", "D11 to D22"),
    "equations two_link --at 0,0 --terms --symbolic": ("--at", "omit --terms, --symbolic"),
    "equations two_link --element D13": ("error: --element", "'D13'", "D11 to D22"),
    "robot.urdf x.csv": ("link lower", "--lock left_finger=0 --lock right_finger=0"),
    "arms robot.urdf --tip lowre": ("'lowre'", "lower?"),
    "arms robot.urdf --lock left_finger": ("--lock", "found: left_finger", "joint=value"),
    "arms robot.urdf --tip lower --limits none.yaml": ("none.yaml",),
    "two_link x.csv --payload 2,0,0,heavy": ("payload", "'heavy'"),
    "evaluate m.json --payload 1,0,0": ("'1,0,0'", "4, 7 or 10", "found: 3"),
    # Verbs and arguments
    "two_link": ("TRAJECTORY...", "gd-analyze --help"),
    "equations": ("'ROBOT'", "gd-analyze equations --help"),
    "evaluate": ("'MODEL'", "gd-analyze evaluate --help"),
    "two_link x.csv --fromat csv": ("'--fromat'", "--format"),
    "two_link x.csv y.csv": ("y.csv",),
    "pln two_link --from 0,0": ("'pln'", "gd-analyze plan"),
    "plan two_link --from 0,0": ("--duration", "gd-analyze plan --help"),
    "plan two_link --from 0,0 --duration 2": ("--to", "gd-analyze plan --help"),
    "completion tcsh": ("'tcsh'", "bash"),
    "arms --to toml": ("--to", "ROBOT"),
    "arms two_link --to urdf": ("'toml'",),
    "export two_link": ("--to",),
    # Values of options
    "two_link x.csv --format html,doc": ("--format", "'doc'"),
    "two_link x.csv --budget -1": ("--budget, entry 1", "found: '-1'"),
    "trade-off two_link x.csv --budget 1e308": ("--budget, entry 1", "1e+12"),
    "simplify two_link --budget 1%,1%,1%": ("--budget", "found: 3", "expected: 1 or 2"),
    "simplify two_link --budget|1% norm or 2%": ("--budget", "'1% norm or 2%'"),
    "two_link x.csv --budget|1% norm at 95%": ("--budget", "'1% norm at 95%'", "joint"),
    "two_link x.csv --margin 2%": ("--margin, entry 1", "found: '2%'"),
    "certify m.json --along x.csv --margin qd=1%,qd=2%": ("--margin, entry 2",),
    "simplify two_link --level atom": ("--level",),
    "rank-terms two_link x.csv --level element": ("--level",),
    "simplify two_link --seconds 0": ("--seconds",),
    "columns two_link x.csv --map time=0Hz": ("no motion is sampled so", "0 Hz"),
    "columns two_link x.csv --map time=0.008Hz": ("give 125Hz",),
    "columns two_link x.csv --map time=:furlong": ("'furlong' is no unit of time",),
    "columns two_link x.csv --map speed=v*": ("unknown role 'speed'",),
    "columns two_link x.csv --map q=none": ("a motion needs positions",),
    "columns two_link x.csv --map q=:mm": ("no joint of two_link has q in mm", "rad, mrad, deg"),
    "columns two_link x.csv --map q:1=:deg": ("no column is named", "q=:deg for all joints"),
    "columns two_link x.csv --map joints=a,b": ("no column names one of these joints", "joints=a,b"),
    "rank-terms two_link x.csv --rate 250": ("no such option '--rate'", "next: --map time=250Hz"),
    "columns two_link x.csv --largest-gap 500": ("500s",),
    "columns two_link x.csv --cutoff 5ms": ("'--cutoff'",),
    "plan two_link --from 0,0 --to 1,1 --duration 2000": ("2000s",),
    "plan two_link --exciting --duration 2 --within 0,0,0,500,500,500": ("--within",),
    "equations two_link --min-share 2": ("'--min-share'", "'2'", "0 to 1"),
    "equations two_link --digits 0": ("1<=x<=17",),
    PLAN.replace("0,0", "0,0,0"): ("error: --from", "expected: 2"),
    PLAN.replace("60,-45", "60,x"): ("error: --to, value 2", "found: 'x'"),
    PLAN.replace("60,-45", "60,700"): ("error: --to", "700 deg"),
    PLAN.replace("duration 2", "duration nan"): ("--duration", "'nan'"),
    PLAN.replace("duration 2", "duration 1e-300"): ("duration", "1e-06 s"),
    PLAN.replace("duration 2", "duration 0.1"): ("--allow-violations",),
    PLAN + " --profile quintc": ("--profile", "quintic"),
    PLAN + " --via 1,1": ("error: --via",),
    "simplify two_link --budget|tracking 0.1deg": ("error: --budget, entry 1", "'tracking 0.1deg'"),
    "columns two_link x.csv --map torque=tau": ("--map", "found: torque=tau", "torque:shoulder"),
    "export two_link --to fortran": ("fortran", "casadi, cpp"),
    "export two_link --to c --name|a b": ("found: a b", "a_b"),
    "export two_link --to c --name double": ("found: double", "arm_double"),
    "export two_link --to c --name ../up": ("found: ../up", ": up "),
    "evaluate m.json x.csv --fail-over|1% frction": ("--fail-over, entry 1", "'1% frction'", "friction?"),
    "evaluate m.json x.csv --fail-over 1,2,3": ("--fail-over", "expected: 1 or 2", "found: 3"),
    "evaluate m.json x.csv --fail-over|10% friction": ("--fail-over, joint 1, shoulder, of two_link",),
    # What a diagnosis needs
    "diagnose two_link": ("'LOG...'", "`gd-analyze diagnose --help`"),
    "diagnose two_link x.csv": ("trajectory x", "found: a plan", "torque"),
    "diagnose two_link nowhere.csv": ("nowhere.csv",),
    "diagnose puma560 t.csv": ("t.csv, line 1", "q1, q2"),
    "diagnose two_link rest.csv --measured": ("error: arm two_link", "--exciting"),
    "identify two_link t.csv --measured -o arm.urdf": ("error: arm.urdf", ".toml"),
    "diagnose massless.toml t.csv --measured": ("massless.toml, line 7", "no link", "gd-analyze identify"),
    "diagnose two_link t.csv --torque-sign 1,2": ("--torque-sign", "1 or -1"),
    "diagnose two_link t.csv --position-sign 1,1,1": ("--position-sign", "found: 3"),
    "diagnose two_link t.csv --offset 9=90deg": ("--offset", "'9'"),
    "diagnose two_link t.csv --couple q2=q1": ("--couple", "'q2=q1'", "q3=q3-q2"),
    "diagnose two_link t.csv --lag late": ("--lag", "'late'"),
    "diagnose two_link x.csv --torque-sign -1": ("error: --torque-sign", "torque", "--torque-constant"),
    "diagnose two_link t.csv --payload 1,0": ("'1,0'", "4, 7 or 10", "found: 2"),
    "diagnose two_link t.csv --measured --report x.csv/below": ("x.csv",),
    "diagnose two_link t.csv --report r --format doc": ("--format", "'doc'"),
    # Options that do not go together
    "simplify two_link --seconds nan": ("--seconds", "'nan'"),
    "puma560 pick-and-place --seconds -1s": ("--seconds", "'-1s'"),
    "simplify two_link --seconds 1e6": ("--seconds", "86400"),
    "simplify two_link --certified --at-set-points": ("--certified",),
    "simplify two_link --margin 1deg": ("--margin", "trajectory"),
    "simplify two_link x.csv --margin 1deg --at-set-points": ("--margin", "states only"),
    "simplify two_link --verdicts text": ("--verdicts", "element"),
    "simplify two_link --level element --certified": ("--level", "certified"),
    "simplify two_link --level element --velocities joint": ("--velocities joint", "--level term"),
    "two_link x.csv --verdicts text": ("--verdicts", "element"),
    "two_link x.csv --level element --at-set-points": ("--level", "at_set_points"),
    "two_link x.csv --fit-friction": ("trajectory x", "torque"),
    "certify m.json --margin 1deg": ("--margin needs --along",),
    "certify m.json --along x.csv --check --margin 1deg": ("--check", "omit --margin"),
    "certify m.json --check --effort 5": ("--check", "omit --effort"),
    "certify m.json --check --along x.csv": ("error: --along", "found: x", "name its file with --along"),
    "evaluate m.json -o torque.csv": ("-o ", "trajectory"),
    "evaluate m.json x.csv two-link-swing -o torque.csv": ("-o ", "one motion"),
    "evaluate m.json x.csv --fail-over none --strict": ("error: --strict", "give --fail-over"),
    "identify two_link t.csv --measured --anyway --mass 2": ("error: --mass", "--loaded", "no log with"),
    "equations two_link --terms --format latex": ("--terms", "omit --format"),
    "equations two_link --terms -o terms.txt": ("--terms", "omit --out"),
    "equations two_link --parameters --terms": ("--parameters", "omit --terms"),
    "equations two_link --parameters --element D11": ("--parameters", "omit --element"),
    "equations two_link --symbolic --terms": ("--symbolic", "omit --terms"),
    "equations two_link --symbolic --parameters --min-share 1%": ("--symbolic", "omit --min-share"),
    "equations puma560 --symbolic": ("6 joints", "--element D12"),
    "equations puma560 --symbolic --element D17": ("'D17'", "D11 to D66"),
    "equations two_link --parameters --format sympy": ("--parameters", "latex", "sympy"),
    "arms two_link --to toml --json": ("--to", "omit --json"),
    "export two_link --to c,python --float": ("error: --float", "python", "double"),
    "export m.json --to c --drives": ("--drives, --tip", "arms"),
    "export m.json --to c --tip x": ("--drives, --tip", "arms"),
    "export m.json --to c --what decomposition": ("--what decomposition", "arm"),
    "export two_link --to c --what decomposition --drives": ("--what decomposition", "--drives"),
    "export two_link --to c --what decomposition,regressor": ("--what decomposition", "other functions"),
    "export two_link --to c,latex --what decomposition": ("latex", "gd-analyze equations"),
    "export two_link --to c,latex --what regressor": ("LaTeX", "regressor"),
    # Outputs
    "two_link x.csv --out x.csv/results": ("error: x.csv/results", "found: x.csv "),
    "two_link x.csv --out /proc/results": (
        "error: /proc/results/analysis.h5",
        "found: /proc ",
        "--out",
    ),
    PLAN.replace("made.csv", "x.csv/made.csv"): ("error: x.csv/made.csv", "found: x.csv "),
    "evaluate m.json x.csv --junit x.csv/j.xml": ("error: x.csv/j.xml", "--junit"),
    "export two_link --to c --out x.csv/below": ("x.csv",),
}
FILES: dict[str, str | bytes] = {
    "x.csv": MOTION,
    "arm.urdf": '<?xml version="1.0"?>\n<robot/>\n',
    "cut.urdf": two_joints(*fingers()).replace("</robot>", ""),
    "robot.urdf": two_joints(*fingers()),
    "moves/a.csv": MOTION,
    "moves/b.csv": "time,q1\n0,1\n",
    "t.csv": TORQUES,
    "rest.csv": csv(*(f"{0.01 * k},0,0,1,1" for k in range(400)), header=WITH_TORQUES),
    "massless.toml": MASSLESS.replace("mass = 2.0", "mass = 0.0").replace(
        "xx = 0.0, yy = 0.2, zz = 0.2", "xx = 0, yy = 0, zz = 0"
    ),
}
CASES = [
    *(("two_link x.csv", {"x.csv": text}, ("error: x.csv", *says)) for text, says in MOTIONS.values()),
    *(
        ("own.toml x.csv", {"own.toml": text, "x.csv": MOTION}, ("own.toml", *says))
        for text, says in ARMS.values()
    ),
    *(("evaluate model.json", {"model.json": text}, ("model.json", *says)) for text, says in MODELS),
    *(
        (f"{verb} own.toml x.csv".strip(), {"own.toml": text, "x.csv": MOTION}, ("own.toml, line 11", says))
        for verb in ("", "simplify", "rank-terms", "formulations")
        for text, says in ((MASSLESS, "joint 2"), (INDEFINITE, "link 2"))
    ),
    *((words, FILES, says) for words, says in WORDS.items()),
]
NAMES = [*MOTIONS, *ARMS, *(f"model {text[:9]}" for text, _ in MODELS), *(8 * ["mass matrix"]), *WORDS]


def assert_is_a_message(err: str) -> None:
    assert "this is a bug" not in err
    assert "Traceback" not in err
    # Place and fact, what was expected, what to do; warnings may precede them.
    assert len(err[err.find("error: ") :].splitlines()) <= 3
    assert not re.search(r"\bNone\b|<class|object at 0x", err)
    assert all(line.isprintable() and len(line) < 1100 for line in err.splitlines())


@pytest.mark.parametrize(("words", "files", "says"), CASES, ids=[name[:60] for name in NAMES])
def test_bad_input(run, here, listing, swing_model, words, files, says):
    (here / "moves").mkdir()
    (here / "empty").mkdir()
    for name, content in files.items():
        (here / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    if "m.json" in words:
        gd.save_model(swing_model, here / "m.json")
    before = listing()
    line, _, whole = words.partition("|")
    result = run(line, *([whole] if whole else []))
    assert (result.code, result.out) == (2, ""), result
    assert "error: " in result.err
    for text in says:
        assert text in result.err
    assert_is_a_message(result.err)
    assert listing() == before


def test_figures_of_a_model_file_that_do_not_hold(run, here):
    """A consistent file states errors of a motion nobody else has; given that motion, they are measured."""
    assert run("plan two_link --from 0,0 --to 1,1 --duration 1 -o mine.csv").code == 0
    assert run("simplify two_link mine.csv --budget 40% -o mine.json").code == 0
    assert "file" in run("certify mine.json --json").json["allowed_and_largest_error"]
    along = run("certify mine.json --along mine.csv --json").json
    assert along["allowed_and_largest_error"] == "measured"
    document = json.loads((here / "mine.json").read_text())
    (here / "mine.json").write_text(json.dumps(document).replace('"mass": 2.0', '"mass": 2.5', 1))
    assert "mine.json" in run("certify mine.json").err, "the digest is of another model"
    document["accuracy"]["budget"] = "0.001%"
    (here / "mine.json").write_text(json.dumps(signed(document)))
    assert run("certify mine.json").code == 0
    refused = run("certify mine.json --along mine.csv")
    assert refused.code == 2
    assert refused.err.startswith("error: mine.json: joint 1, ")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows allows no control characters in file names")
def test_a_file_name_does_not_act(run, here, model):
    name = "a\x1b[2J\u202e\x9b\x07<b>&'\"\nerror: b.csv"
    (here / name).write_text(MOTION.replace("0.08", "x"))
    assert_is_a_message(run("two_link", name).err)
    (here / name).write_text(MOTION)
    for result in (
        run("two_link", name, "--format", "json"),
        run("evaluate model.json", name, "--junit", "j.xml"),
    ):
        assert result.code == 0
        assert all(line.isprintable() for line in result.out.splitlines())
        assert "\\x1b[2J\\u202e" in result.out
    assert "&lt;b&gt;&amp;" in (here / "j.xml").read_text()


@pytest.mark.parametrize("n", [10, 12, 70])
def test_exact_equations_of_long_arms_are_refused_before_the_work(run, here, n):
    gd.save_arm(generic_chain(n), here / "chain.toml")
    result = run("equations chain.toml")
    assert (result.code, result.out) == (2, "")
    assert f"{n} joints" in result.err
    assert "--level element" in result.err


@pytest.mark.slow
def test_far_too_many_terms_are_refused_with_what_to_do_instead(run, here, rng):
    gd.save_arm(arm_of(["askew"] * 7, rng), here / "own.toml")
    result = run("rank-terms own.toml --states 9 --limits all=1")
    assert (result.code, result.out) == (2, "")
    assert "60000" in result.err
    assert "`gd-analyze export ROBOT --to c`" in result.err
