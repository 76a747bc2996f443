"""Verbs about what is read: arms and what is picked of them, columns of logs, plans, and exact equations."""

from __future__ import annotations

import math
import re
import shlex
import tomllib
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import gd_analyze as gd
from chains import generic_chain
from gd_analyze.cli.motions import PROFILE_NAMES
from gd_analyze.formulas.languages import Plain
from gd_analyze.formulas.writing import element_formula
from gd_analyze.motions.profiles import PROFILES
from gd_analyze.robots.description import fingerprint
from long_cases import long
from robot_files import TWO_ARMS, fingers, link, two_joints

# The moments are 0.03, 0.04 and 0.05 but for products; 0.15 is more than the others by half of itself.
ODD = two_joints().replace(link("upper"), link("upper", izz=0.15))


@pytest.mark.parametrize("name", list(gd.builtin_arms()))
def test_one_arm_in_full(run, name):
    flowing, document, arm = run(f"arms {name}").words, run(f"arms {name} --json").json, gd.load_arm(name)
    for text in (*(part.name for part in (*arm.joints, *arm.links)), *arm.sources, *arm.assumptions):
        assert text in flowing
    assert document["suspicious"] == []
    assert [link["mass"] for link in document["links"]] == arm.mass.tolist()
    assert name in run("arms").words
    assert name in [row["name"] for row in run("arms --json").json["arms"]]


def test_suspicious_numbers_stand_first_with_their_line(run, here):
    (here / "odd.urdf").write_text(ODD)
    result = run("arms odd.urdf")
    line = ODD[: ODD.index('izz="0.15"')].count("\n") + 1
    assert f"Suspicious - line {line}" in result.words
    assert result.out.index("Suspicious") < result.out.index("Chain") < result.out.index("Links")
    [text] = run("arms odd.urdf --json").json["suspicious"]
    assert "link upper" in text
    assert re.search(r"by 5\d? %", text)


def test_any_arm_becomes_toml(run, here):
    (here / "odd.urdf").write_text(ODD)
    result = run("arms odd.urdf --limits all=90deg --to toml")
    assert result.code == 0
    assert "link upper" in result.err
    (here / "own.toml").write_text(result.out, encoding="utf-8")
    with pytest.warns(gd.GdAnalyzeWarning):
        before, after = gd.load_arm("odd.urdf", limits=["all=90deg"]), gd.load_arm("own.toml")
    assert fingerprint(after, drives=True) == fingerprint(before, drives=True)
    assert after.joints[0].acceleration_limit == math.pi / 2
    # A file that is TOML already keeps its comments; with something added it is written anew.
    assert run("arms own.toml --to toml").out == result.out
    changed = tomllib.loads(run("arms puma560 --limits all=7 --to toml").out)
    assert changed["joints"][3]["acceleration_limit"] == 7.0
    assert changed["convention"] == "standard"


LOCKS = "--lock left_finger=0 --lock right_finger=10mm"


TIP = "--tip lower --gravity 0,0,-1.6 --drive-inertia 0.1,0.2"


PICKING = [
    "arms robot.urdf",
    "rank-terms robot.urdf swing.csv",
    "simplify robot.urdf swing.csv",
    "equations robot.urdf",
    "plan robot.urdf --from 0,0 --to 10,20 --duration 3",
    "robot.urdf swing.csv --out out --format json,html",
]
# Of those that take a second, one way to pick is tried at once.
SEARCHING = (PICKING[2], PICKING[5])


@pytest.mark.parametrize(
    ("verb", "picked"),
    [
        *((verb, LOCKS) for verb in PICKING),
        *(long(verb, TIP) if verb in SEARCHING else (verb, TIP) for verb in PICKING),
    ],
)
def test_every_verb_takes_what_is_picked(run, here, verb, picked):
    (here / "robot.urdf").write_text(two_joints(*fingers()))
    rows = "".join(f"\n{0.1 * i},{0.01 * i**2},{-0.02 * i**2}" for i in range(8))
    (here / "swing.csv").write_text("time,q1,q2" + rows)
    result = run(f"{verb} {picked} --json")
    assert result.code == 0, result.err
    assert result.json
    if "html" in verb and picked == LOCKS:
        page = (here / "out" / "report.html").read_text(encoding="utf-8")
        assert all(held in page for held in ("left_finger at 0 m", "right_finger at 0.01 m"))
        assert "--lock left_finger=0" in re.sub(r"<[^>]*>", "", page)  # the command


LOG = "timestamp,actual_q_0,actual_q_1,target_q_0,target_q_1,temp_0\n" + "".join(
    f"{0.01 * k:.2f},{0.2 * np.sin(0.02 * k):.9f},{0.3 * np.cos(0.02 * k):.9f},0,{k},21\n" for k in range(200)
)


def test_columns_that_share_a_name_and_nobody_needs(run, here):
    head, *rows = LOG.splitlines()
    (here / "log.csv").write_text("\n".join([f"{head},temp_0", *(f"{row},22" for row in rows)]))
    result = run("two_link log.csv --format json,h5 --out out")
    assert result.code == 0, result.err
    assert [*gd.load_findings("out/analysis.h5").tables["recording"].column.values[-2:]] == [
        "temp_0",
        "temp_0 (7)",
    ]


def test_files_put_side_by_side_have_two_times(run, here):
    (here / "log.csv").write_text("\n".join(f"{row},{row.split(',')[0]}" for row in LOG.splitlines()))
    refused = run("columns two_link log.csv")
    assert all(option in refused.err for option in ("--map 'time=#1'", "--map 'time=#7'"))
    assert run("columns two_link log.csv --map time=#1").code == 0


def test_columns_of_a_log(run, here):
    (here / "log.csv").write_text(LOG)
    shown, told = run("columns two_link log.csv").words, run("columns two_link log.csv --json").json
    *_, second = (row for row in told["columns"] if row["column"] == "actual_q_1")
    assert f"actual_q_1 q elbow rad {second['why']}" in shown
    assert (told["measured"], told["rows"], told["seconds"]) == (True, 200, 1.99)
    first = told["columns"][1]
    assert [first[key] for key in ("column", "role", "joint", "unit")] == [
        "actual_q_0",
        "q",
        "shoulder",
        "rad",
    ]
    assert "number" in first["why"]
    assert "Kind plan" in run("columns two_link two-link-swing").words


FINGERS = two_joints(*fingers())


@pytest.mark.parametrize(
    ("robot", "heading", "arm"),
    [
        long(TWO_ARMS, "t,right_0,right_1,right_2", ["right_0", "right_1", "right_2"]),
        long(TWO_ARMS, "t,pos.left_0,pos.left_1,pos.left_2,gripper", ["left_0", "left_1", "left_2"]),
        long(TWO_ARMS, "t,right_0_position,right_1_position", ["right_0", "right_1"]),
        (FINGERS, "t,shoulder,elbow", ["shoulder", "elbow"]),
        (TWO_ARMS, "t,left_0,left_1,left_2,right_0,right_1,right_2", None),
        (TWO_ARMS, "t,q1,q2,q3", None),
        (TWO_ARMS, "t,bright_0,right_01,right_2x", None),
    ],
)
def test_of_a_robot_that_branches_the_arm_that_the_log_names(run, here, robot, heading, arm):
    (here / "robot.urdf").write_text(robot)
    n = heading.count(",")
    rows = (",".join([f"{0.1 * k:.1f}", *n * [f"{0.1 * np.sin(0.2 * k):.6f}"]]) for k in range(60))
    (here / "log.csv").write_text("\n".join([heading, *rows]))
    for verb in (
        "columns robot.urdf log.csv",
        "rank-terms robot.urdf log.csv",
        "robot.urdf log.csv --format json",
    ):
        result = run(f"{verb} --json")
        assert result.code == (2 if arm is None else 0), verb
        warned = [line for line in result.err.splitlines() if line.startswith("warning: ")]
        assert "branches" in result.err
        assert any("--tip" in line for line in warned) == (arm is not None)
    if arm is not None:
        columns = run("columns robot.urdf log.csv --json").json["columns"]
        assert [row["joint"] for row in columns if row["role"] == "q"] == arm
        tip = "lower" if robot is FINGERS else "left1"
        assert "branches" not in run(f"columns robot.urdf log.csv --tip {tip}").err


@pytest.mark.parametrize(
    ("factor", "speed", "limit", "cause"),
    [
        long(1.0, 50.0, 5.0, "velocities"),
        (100.0, 1.0, 5.0, "degrees"),
        long(1.0, 1.0, 0.02, "masses"),
    ],
)
def test_a_torque_above_the_limit_is_the_first_warning_of_its_step(run, here, factor, speed, limit, cause):
    time = np.linspace(0.0, 2.0, 201)
    q = factor * np.column_stack([0.3 * np.sin(3.0 * time), 0.2 * np.cos(2.0 * time)])
    rows = np.column_stack([time / speed, q])
    np.savetxt("motion.csv", rows, delimiter=",", header="time,q1,q2", comments="")
    (here / "arm.urdf").write_text(re.sub('effort="[^"]*"', f'effort="{limit}"', two_joints()))
    for verb in ("columns", "", "simplify"):
        lines = run(f"{verb} arm.urdf motion.csv{' --format json' * (not verb)}").err.splitlines()
        # The main job has told what it read, and the limits that this exceeds, before it knows torques.
        of_reading = ("read as radians", "above the limit")
        first = next(line for line in lines if verb or not any(words in line for words in of_reading))
        assert re.match(rf"warning: joint \d.* limit of {limit:g} N m; .*{cause}", first)
    (here / "strong.urdf").write_text(re.sub('effort="[^"]*"', 'effort="1e9"', two_joints()))
    assert "its limit" not in run("columns strong.urdf motion.csv").err


def test_every_verb_takes_noise_for_a_recording(run, here):
    time = np.arange(400) * 1e-3
    q = np.sin(np.outer(time, [3.0, 5.0])) + np.random.default_rng(0).normal(0, 1e-4, (400, 2))
    rows = "".join(f"{t:.3f},{a:.5f},{b:.5f}\n" for t, (a, b) in zip(time, q, strict=True))
    (here / "raw.csv").write_text("time,q1,q2\n" + rows)
    shown = run("columns two_link raw.csv --json")
    assert "noise" in shown.err
    assert shown.json["measured"] is True
    done = run("two_link raw.csv --format json --json")
    assert "noise" in done.err
    taken = run("columns two_link raw.csv --planned --json")
    assert taken.json["measured"] is False


def test_a_plan_of_many_set_points_is_no_noise(run):
    run("plan puma560 --from 0,0,0,0,0,0 --to 40,-30,60,50,40,90 --duration 2 --points 400 -o plan.csv")
    assert "Kind plan" in run("columns puma560 plan.csv").words


@pytest.mark.parametrize("verb", ["columns two_link", "evaluate model.toml", "two_link"])
def test_every_verb_refuses_nan_in_a_plan(run, here, verb):
    model = gd.analyze("two_link", "two-link-swing").model
    gd.save_model(model, here / "model.toml")
    lines = run("plan two_link --from 0,0 --to 60,-45 --duration 2").out.splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("0"))
    lines[first + 4] = ",".join([*lines[first + 4].split(",")[:-1], "nan"])
    (here / "plan.csv").write_text("\n".join(lines) + "\n")
    refused = run(f"{verb} plan.csv")
    assert refused.code == 2
    assert f"line {first + 5}" in refused.err
    assert "nan" in refused.err


def test_options_reach_the_reader_in_every_verb(run, here):
    (here / "log.csv").write_text(LOG)
    assert run("columns two_link log.csv --planned --map q=target_q_* --json").json["measured"] is False
    words = "--map q:1=#3:deg --map q:elbow=actual_q_0:deg --map time=:ms"
    told = run(f"columns two_link log.csv {words} --json").json
    used = [("timestamp", "", "ms"), ("actual_q_0", "elbow", "deg"), ("actual_q_1", "shoulder", "deg")]
    assert [(use["column"], use["joint"], use["unit"]) for use in told["columns"][:3]] == used
    assert run("two_link log.csv --out r --format json --cutoff 5").code == 0
    told = run("rank-terms two_link log.csv --map time=:ms --planned --json").json
    assert told["states"]["trajectory"] == "log"
    assert run("evaluate r/model.json log.csv --map time=100Hz").code == 0


def test_quantities_may_have_units(run, here):
    (here / "log.csv").write_text(LOG)
    words = "columns two_link log.csv --json --map time=:ms --measured"
    plain = run(f"{words} --cutoff 5 --largest-gap 0.2").json
    assert run(f"{words} --cutoff 5Hz --largest-gap 200ms").json == plain
    plan = "plan two_link --to 0,0 --duration 2 --json"
    assert run(f"{plan} --from 180,0").json["q"] == run(f"{plan} --from 0.5rev,0rad").json["q"]
    refused = run(f"{plan} --from 1m,0")
    assert (refused.code, "value 1" in refused.err) == (2, True)


@pytest.mark.parametrize("option", ["--budget 5mm", "--margin 1kg", "--payload 1,0", "--dominance 1mm"])
def test_a_wrong_option_is_told_before_files_are_read(run, here, option):
    told = run(f"puma560 nowhere.csv {option}")
    assert told.code == 2
    assert "nowhere" not in told.err


def test_standard_input(process, run):
    told = process("columns two_link - --json", input=LOG).json
    assert (told["log"], told["rows"]) == ("stdin", 200)
    planned = run("plan two_link --from 0,0 --to 60,-45 --duration 2")
    told = process("rank-terms two_link - --json", input=planned.out).json
    assert told["states"]["trajectory"] == "stdin"


PLAN = "plan two_link --from 0,0 --to 60,-45 --duration 2"


@pytest.mark.parametrize("profile", PROFILES)
def test_a_plan_is_repeated_by_the_command_in_its_file(run, here, profile):
    assert tuple(PROFILES) == PROFILE_NAMES
    words = (*PLAN.split(), "--points", "17", "--profile", profile, "-o", "my swing.csv")
    result = run("", *words)
    assert result.words.endswith("wrote my swing.csv")
    motion = gd.read_trajectory("my swing.csv", gd.load_arm("two_link"))
    assert motion.n_set_points == 17
    # Typed degrees become radians by one rounding each.
    np.testing.assert_allclose(np.rad2deg(motion.q[[0, -1]]), [[0, 0], [60, -45]], rtol=4e-16, atol=0)
    text = (here / "my swing.csv").read_text(encoding="utf-8")
    assert text.splitlines()[0] == "# " + shlex.join(["gd-analyze", *words])


def test_a_plan_on_standard_output_as_json_and_too_fast(run, listing, here):
    lines, told = run(PLAN).out.splitlines(), run(f"{PLAN} --json").json
    assert lines[:2] == [f"# gd-analyze {PLAN}", "time,q1,q2,qd1,qd2,qdd1,qdd2"]
    assert len(lines) - 2 == len(told["time"]) == told["set_points"] == 31
    assert told["q"][-1] == [math.radians(60), math.radians(-45)]
    assert listing() == set()
    result = run(f"{PLAN[:-1]}0.3 --allow-violations -o fast.csv")
    assert result.code == 0
    assert result.err.startswith("warning: ")
    assert "too fast" in result.err
    assert (here / "fast.csv").exists()


def body(text: str) -> str:
    """What follows the header."""
    return text.partition("\n\n")[2]


def test_equations_in_symbols(run, here):
    words = "equations scara --symbolic --element D14 --element c3"
    text = run(words).out
    assert "\nD14^rot = -I4zz\nc3 = -m4 g - m3 g\n" in text
    assert "\nI4zz = 0.0025 kg m^2\n" in text
    assert run(f"{words} --quiet").out == text.partition("\n\n")[2]
    told = run(f"{words} --json").json
    arm = gd.load_arm("scara")
    numbers = {symbol["symbol"]: symbol["number"] for symbol in told["symbols"]}
    assert numbers["m4"] == arm.mass[3]
    assert numbers["I4zz"] == arm.inertia_com[3, 2, 2]
    assert [(part["label"], part["effect"]) for part in told["equations"]] == [
        ("D14", "translation"),
        ("D14", "rotation"),
        ("c3", ""),
    ]
    # As close to the numeric decomposition as round-off lets it be.
    assert 0.0 <= told["error"] <= 1.0
    assert r"I_{4zz} = 0.0025 \, \mathrm{kg \, m^{2}}" in run(f"{words} --format latex").out.splitlines()
    page = ET.fromstring(f"<page>{run(words + ' --format mathml --quiet').out}</page>")
    assert len(page) == len(told["equations"]) + len(told["symbols"])
    assert run(f"{words} --format sympy -o scara.py").words.endswith("wrote scara.py")
    assert (here / "scara.py").read_text(encoding="utf-8") == run(f"{words} --format sympy").out
    run(f"{words} -o by_its_ending.py")
    assert (here / "by_its_ending.py").read_bytes() == (here / "scara.py").read_bytes()


@pytest.mark.parametrize("name", ["puma560", "stanford", "two_link"])
def test_all_equations(run, name):
    result, found = run(f"equations {name}"), gd.equations(gd.load_arm(name))
    lines = (Plain().wrapped(element_formula(equation), 80) for equation in found)
    assert body(result.out) == "".join(f"{line}\n" for line in lines)
    assert f"{sum(len(equation.terms) for equation in found)} terms" in result.words


def test_elements_shares_digits_and_terms(run):
    words = "equations puma560 --element D12 --element c3 --min-share 1%"
    assert body(run(words).out) == "D12 = 0.687 S2 - 0.133 C23 + 0.0237 C2\nc3 = -8.45 S23 + 0.25 C23\n"
    assert run(f"{words} --quiet").out == body(run(words).out)
    out = run(f"{words[:-2]}0.01 --digits 1 --quiet").out
    assert out == "D12 = 0.7 S2 - 0.1 C23 + 0.02 C2\nc3 = -8 S23 + 0.3 C23\n"
    assert run("equations puma560 --element D45 --quiet").out == "D45 = 0\n"
    (told,) = run("equations puma560 --element D11 --json").json["equations"]
    (equation,) = gd.equations(gd.load_arm("puma560"), ["D11"])
    assert [t["coefficient"] for t in told["terms"]] == [t.coefficient for t in equation.terms]
    assert told["terms"][1]["factors"] == [{"kind": "cos", "multiples": [0, 1, 0, 0, 0, 0], "exponent": 2}]
    assert "1 1.84 both 1-6 100 %" in run("equations puma560 --element D11 --terms").words


def test_other_forms_and_files(run, here, listing):
    lines = run("equations two_link --format latex").out.splitlines()
    assert next(line for line in lines if line and not line.startswith("% ")) == "D_{11} = 2 + C_{2}"
    text = run("arms two_link --to toml").out
    # Neither ends a title the comment it stands in, nor needs an arm weight.
    text = re.sub(r'title = ".*"', 'title = "two --> <b>"', text)
    (here / "own.toml").write_text(re.sub(r"gravity = .*", "gravity = [0, 0, 0]", text))
    page = ET.fromstring(f"<page>{run('equations own.toml --format mathml').out}</page>")
    told = run("equations own.toml --json").json
    assert len(page) == len(told["equations"])
    assert not [equation for equation in told["equations"] if equation["symbol"].startswith("c")]
    (here / "own.toml").unlink()
    assert run("equations two_link -o out/two.txt").words.endswith("wrote out/two.txt")
    assert body((here / "out/two.txt").read_text(encoding="utf-8")) == body(run("equations two_link").out)
    assert listing() == {"out", "out/two.txt"}


def test_the_sympy_form_is_a_script(run):
    sympy = pytest.importorskip("sympy", reason="needs SymPy: pip install sympy")
    scope: dict[str, object] = {}
    exec(run("equations stanford --format sympy").out, scope)
    q = np.linspace(0.1, 0.6, 6)
    values = {sympy.Symbol(f"q{j + 1}", real=True): q[j] for j in range(6)}
    exact = gd.tables.decompose_states(gd.load_arm("stanford"), gd.types.States(q, q, q))
    # Some ten terms of at most the arm's largest inertia, each rounded.
    assert float(sympy.sympify(scope["D11"]).subs(values)) == pytest.approx(
        exact["inertia"][:, 0, 0].sum(), rel=1e-12
    )


def test_outer_elements_of_an_arm_of_many_joints(run, here):
    """All of this arm's equations would take 19 GB."""
    gd.save_arm(generic_chain(11), here / "long.toml")
    assert run("equations long.toml --element D10,11 --quiet").out.startswith("D10,11 = ")
    refused = run("equations long.toml --element D1,2")
    assert refused.code == 2
    assert "D22" in refused.err


def test_base_parameters(run, here):
    result, told = run("equations puma560 --parameters"), run("equations puma560 --parameters --json").json
    base = gd.base_parameters("puma560")
    assert f"{len(base)} (of {len(base.original)} parameters)" in result.words
    row, combination = (line for line in result.out.splitlines() if line.startswith("MX2"))
    assert row.split() == ["MX2", "3.8", "3.8", "0", "0", "kg", "m"]
    assert combination.split("   ")[0] == "MX2 = mx2 + 0.432 m3..6"
    assert [one["number"] for one in told["parameters"]] == [one.number for one in base]
    assert told["parameters"][1]["combination"][1] == {"coefficient": 0.4318, "kind": "m", "link": 3}
    assert told["never_acting"][0] == {"kind": "m", "link": 1}
    latex = run("equations two_link --parameters --format latex").out.splitlines()
    assert latex[0] == r"MX_{1} = mx_{1} + m_{2} = 2 \; \mathrm{kg~m}"
    plain = run("equations two_link --parameters --quiet").out
    assert plain.splitlines()[2] == "PXX1 = Pxx1 + Pyy1 + m2 = 1.67 kg m^2"
    assert run("equations two_link --parameters -o base.txt").words.endswith("wrote base.txt")
    assert (here / "base.txt").read_text(encoding="utf-8") == plain
