"""Arms that a verb cannot treat are named: without masses, of more than eight joints, of too many terms."""

from __future__ import annotations

import resource
import subprocess
import sys

import numpy as np
import pytest

import gd_analyze as gd
from chains import generic_chain
from gd_analyze.errors import ArmError, GdAnalyzeWarning
from gd_analyze.types import ExactForm, Joint, Link, RobotArm, States
from parallel_axes import arm_of
from program import PROGRAM
from robot_files import joint, link, mjcf, urdf

BARE = mjcf('<body name="a"><joint name="j"/><body name="b"><joint name="k" axis="0 1 0"/></body></body>')
STRIPPED = urdf(link("base", None), link("a", None), joint("j", "base", "a"))
NOTHING = RobotArm("nothing", (Joint("j"),), (Link("a", 0.0, np.zeros(3), np.zeros((3, 3))),))
MOTION = "time,q1,q2\n" + "\n".join(f"{0.1 * k},{0.01 * k * k},{0.02 * k * k}" for k in range(9))

NEEDS_MASSES = (
    "{} x.csv", "simplify {} x.csv -o m.json", "rank-terms {} x.csv", "trade-off {} x.csv", "equations {}",
    "equations {} --parameters", "equations {} --symbolic", "formulations {}", "export {} --to c -o x.c",
    "compare {0} {0}", "equations {} --at 0", "equations {} --parameters --symbolic",
    "figures {} x.csv -o drawn", "diagnose {} x.csv",
    "simplify {} --states 9 -o m.json", "{} x.csv --payload 1,0,0,0",
)  # fmt: skip


@pytest.mark.parametrize("verb", NEEDS_MASSES)
@pytest.mark.parametrize("name", ["bare.xml", "stripped.urdf", "nothing.toml"])
def test_a_robot_without_masses_is_named_by_every_verb_that_needs_them(run, here, listing, verb, name):
    (here / "bare.xml").write_text(BARE)
    (here / "stripped.urdf").write_text(STRIPPED)
    gd.save_arm(NOTHING, here / "nothing.toml")
    before = listing()
    # There is no x.csv: the arm is refused before anything else is read.
    result = run(verb.format(name))
    assert (result.code, result.out) == (2, "")
    assert "has mass or inertia" in result.err
    assert "`gd-analyze identify ROBOT LOG`" in result.err
    assert name in result.err
    assert listing() == before


@pytest.mark.parametrize("name", ["bare.xml", "stripped.urdf", "nothing.toml"])
def test_what_needs_no_masses_goes_on(run, here, name):
    (here / "bare.xml").write_text(BARE)
    (here / "stripped.urdf").write_text(STRIPPED)
    gd.save_arm(NOTHING, here / "nothing.toml")
    n = gd.load_arm(here / "nothing.toml").n_joints if name == "nothing.toml" else 2 - (name != "bare.xml")
    zeros, ends = ",".join("0" * n), ",".join(["20"] * n)
    assert run(f"arms {name}").code == 0
    assert run(f"plan {name} --from {zeros} --to {ends} --duration 2 -o made.csv").code == 0
    assert run(f"columns {name} made.csv").code == 0


@pytest.mark.parametrize(
    "job",
    [
        gd.equations,
        lambda arm: gd.export(arm, "c"),
        lambda arm: gd.simplify(arm, States(*np.ones((3, 4, 1)))),
        lambda arm: gd.analyze(arm, "x.csv"),
        lambda arm: gd.diagnose(arm, "x.csv"),
    ],
)
def test_python_hears_it_too(job):
    with pytest.raises(ArmError, match="has mass or inertia"):
        job(NOTHING)


def test_inertia_without_mass_and_mass_without_inertia_are_masses():
    for mass, moment in ((0.0, 0.1), (1.0, 0.0)):
        arm = RobotArm("some", (Joint("j"),), (Link("a", mass, np.array([0.1, 0, 0]), moment * np.eye(3)),))
        (equation,) = gd.equations(arm, ["D11"])
        assert len(equation.terms) == 1


@pytest.mark.parametrize(
    ("verb", "code"),
    [
        ("arms ten.toml", 0),
        ("equations ten.toml", 2),
        ("plan ten.toml --from 0,0,0,0,0,0,0,0,0,0 --to 9,9,9,9,9,9,9,9,9,9 --duration 2 -o made.csv", 0),
        ("simplify ten.toml --states 9 --limits all=1 -o m.json", 2),
        ("rank-terms ten.toml --states 9 --limits all=1", 2),
    ],
)
def test_the_limit_of_eight_joints_is_named_at_once(run, here, verb, code):
    gd.save_arm(generic_chain(10), here / "ten.toml")
    result = run(verb)
    assert result.code == code
    # `arms` shows what is suspicious first.
    told = " ".join((result.err or result.out).split())
    assert told.index("10 joints, but") < (150 if verb.startswith("arms") else 80)
    assert "up to 8 joints" in told


@pytest.mark.slow
def test_eight_joints_with_axes_askew_are_answered_or_refused_in_little_memory(here, rng):
    """Their terms would take gigabytes and minutes: nothing expands them, whoever asks for D, h and c."""
    gd.save_arm(arm_of(["askew"] * 8, rng), here / "askew.toml")
    zeros, ends = ",".join("0" * 8), ",".join(["40"] * 8)
    plan = (
        f"plan askew.toml --from {zeros} --to {ends} --duration 3 --limits all=5 --allow-violations -o x.csv"
    )
    verbs = [
        (plan, 0),
        ("askew.toml x.csv -o found --format json", 0),
        ("simplify askew.toml x.csv -o m.json", 2),
        ("export askew.toml --to c -o x.c", 0),
        ("equations askew.toml", 2),
        ("rank-terms askew.toml x.csv", 2),
    ]
    for verb, code in verbs:
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM, *verb.split()],
            capture_output=True,
            text=True,
            check=False,
            preexec_fn=_limit_memory,
        )
        assert done.returncode == code, (verb, done.stderr)
        assert "Traceback" not in done.stderr
    functions = ExactForm(gd.load_arm(here / "askew.toml")).functions
    assert [program.count.total > 0 for program in functions] == [True] * 3


def _limit_memory() -> None:
    """Threads and libraries reserve more than the tenths of a gigabyte that are used."""
    resource.setrlimit(resource.RLIMIT_AS, (3_000_000_000, 3_000_000_000))


def test_eight_joints_are_not_warned_of(tmp_path):
    gd.save_arm(generic_chain(8), tmp_path / "eight.toml")
    gd.load_arm(tmp_path / "eight.toml")
    gd.save_arm(generic_chain(9), tmp_path / "nine.toml")
    with pytest.warns(GdAnalyzeWarning, match="9 joints"):
        gd.load_arm(tmp_path / "nine.toml")
