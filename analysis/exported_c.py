"""How fast is exported C? Nanoseconds per torque beside CasADi's C, and Pinocchio's rnea compiled and from Python.

Everybody computes the torque of the same states in one process, by turns; the compiler and its flags are the same.
Writes `exported_c.md` beside this file, in some two minutes: `python analysis/exported_c.py`. UR10 and Panda come
from example-robot-data, which `pip install example-robot-data` brings.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import warnings
from collections.abc import Iterator, Mapping
from contextlib import suppress
from ctypes import CDLL
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import numpy as np

import gd_analyze as gd
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.operations.program import OperationCount
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.candidates import TooManyTermsError
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from peers.exported import exported
from peers.newton_euler_in_casadi import in_casadi
from peers.rnea_compiled import compiled_rnea, rnea_from_python, rnea_library
from peers.timed import Way, library, nanoseconds, way
from psdm_measure import machine, made_with, told

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))  # makers that tests share

from published_arms import arm_of

FLAGS = ("-O2", "-O3", "-O3 -march=native")
HOW = ("one", "many", "C++")
FAST = FLAGS[-1]
MODELS = ("exact", "simplified")
# States that are timed; they and all results stay in the second cache.
TIMED = 1000
# What the study takes to simplify: states, a share of the usual effort, and budgets until the torque takes less.
STATES, EFFORT, BUDGETS = 2000, 0.25, ("1%", "5%", "20%")
_FILES = {
    "UR10": ("ur_description/urdf/ur10_robot.urdf", None),
    "Panda": ("panda_description/urdf/panda.urdf", "panda_link8"),
}
NAMES = ("PUMA 560 with drives", "KR6", "LBR7", *_FILES)


def arm_named(name: str) -> RobotArm | None:
    """Load one of the arms; None where example-robot-data, which it is in, is not installed."""
    if name.startswith("PUMA"):
        return gd.load_arm("puma560")
    if name not in _FILES:
        return arm_of(name)
    path, tip = _FILES[name]
    with suppress(PackageNotFoundError):
        folder = distribution("example-robot-data").locate_file(
            "cmeel.prefix/share/example-robot-data/robots"
        )
        return gd.load_arm(Path(str(folder)) / path, tip=tip)
    return None


def simplified(arm: RobotArm, states: int = STATES, effort: float = EFFORT) -> SimplifiedModel:
    """Simplify over states drawn from the arm's limits, at the first budget at which that saves operations."""
    with warnings.catch_warnings():
        # That a file states no largest acceleration, and one is assumed.
        warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
        drawn = states_in_box(arm, states)
        for budget in BUDGETS:
            with suppress(TooManyTermsError):
                model = simplify_exact(ExactDynamics.of(arm, drawn), budget, SearchOptions(effort=effort))
                if model.saves_torque:
                    return model
    raise ValueError(f"no model of {arm.name} takes fewer operations than its exact torque")


@dataclass(frozen=True, eq=False)
class Timed:
    """An arm's figures.

    Parameters
    ----------
    name
        The arm.
    counts
        Operations of the exact torque and of the model.
    casadi
        Multiplications and additions of CasADi's C.
    nanoseconds
        Per torque, by way: "simplified, many, -O2", "CasADi, -O2", "rnea C++", "rnea Python".
    """

    name: str
    counts: Mapping[str, OperationCount]
    casadi: int
    nanoseconds: Mapping[str, float]

    def faster(self, what: str, than: str) -> float | None:
        """How many times."""
        return self.nanoseconds[than] / self.nanoseconds[what] if than in self.nanoseconds else None

    @cached_property
    def slower_than_exact(self) -> list[str]:
        """Ways to the simplified torque that take longer than the same way to an exact one, ours or CasADi's."""
        ways = [(how, flags) for how in HOW for flags in FLAGS]
        pairs = [(f"simplified, {how}, {flags}", f"exact, {how}, {flags}") for how, flags in ways]
        pairs += [(f"simplified, {how}, {flags}", f"CasADi, {flags}") for how, flags in ways if how != "C++"]
        return [f"{a} than {b}" for a, b in pairs if self.nanoseconds[a] > self.nanoseconds[b]]


def timed(
    name: str, arm: RobotArm, model: SimplifiedModel, folder: Path, rnea: CDLL | str, rounds: int
) -> Timed:
    """Time all ways to one arm's torque, after a look at what they give."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
        states = states_in_box(arm, TIMED, seed=1)
    exact = ExportInput.of_exact(ExactForm(arm, model.drives), "arm")
    simple = ExportInput.of_model(model, "arm")
    casadi = in_casadi(arm, model.drives)
    ways: list[Way] = []
    for flags in FLAGS:
        inside = folder / name / flags.replace(" ", "")
        for what, subject in zip(MODELS, (exact, simple), strict=True):
            ways += exported(what, subject, states, inside / what, flags)
        sources = {"exact.c": casadi.source, "driver.c": casadi.driver}
        made = library(inside / "CasADi", sources, "gcc", *flags.split())
        ways.append(way(f"CasADi, {flags}", made.all, states))
    ways.append(rnea_from_python(arm, model.drives, states))
    if not isinstance(rnea, str):
        ways.append(compiled_rnea(rnea, arm, model.drives, states))
    least = nanoseconds(ways, rounds)
    _require_equal(ways, arm, exact, model, states)
    counts = {"exact": exact.functions[0].count, "simplified": model.operations}
    return Timed(name, counts, casadi.operations, least)


def _require_equal(
    ways: list[Way], arm: RobotArm, exact: ExportInput, model: SimplifiedModel, states: States
) -> None:
    """All exact torques are one, to round-off, and those of the model are the model's."""
    inputs = {
        f"{k}{j + 1}": x[:, j]
        for k, x in zip(("q", "qd", "qdd"), states.arrays, strict=True)
        for j in range(arm.n_joints)
    }
    expected = {True: model.torque(*states.arrays), False: exact.functions[0].program.run(inputs).T}
    # A rotor's torque is one more product and sum.
    bound = 2 * round_off_bounds(arm, *states.arrays)["torque"]
    for each in ways:
        found = np.abs(each.torque - expected[each.name.startswith("simplified")]).max()
        if not found <= bound:
            raise ValueError(f"{each.name} of {arm.name} is off by {found:.1e} N m, not {bound:.1e}")


def block(row: Timed) -> str:
    """Show an arm's figures in some lines of a terminal."""
    ns = row.nanoseconds
    lines = [
        f"{row.name}: ns per torque",
        f"{'':26}{'exact':>8}{'simpler':>8}{'CasADi':>8}{'rnea C++':>10}{'Python':>8}",
    ]
    totals = [row.counts[what].total for what in MODELS]
    lines.append(f"  {'operations':24}" + "".join(f"{x:8d}" for x in (*totals, row.casadi)))
    for how, flags in ((how, flags) for flags in FLAGS for how in HOW):
        cells = [ns.get(f"{what}, {how}, {flags}") for what in MODELS]
        if how == "one":
            cells += [ns[f"CasADi, {flags}"]]
        if (how, flags) == ("one", FAST):
            cells += [ns.get("rnea C++"), ns["rnea Python"]]
        widths = (8, 8, 8, 10, 8)
        label = f"  {how:5}{flags:19}"
        lines.append(label + "".join(f"{_rounded(x):>{w}}" for x, w in zip(cells, widths, strict=False)))
    best = [f"{what} {row.faster(f'{what}, many, {FAST}', f'CasADi, {FAST}'):.1f}" for what in MODELS]
    lines.append(f"  many, times faster than CasADi's C: {', '.join(best)}")
    simpler = [
        f"{how} {row.faster(f'simplified, {how}, {FAST}', f'exact, {how}, {FAST}'):.1f}" for how in HOW[:2]
    ]
    lines.append(f"  simplified, times faster than exact: {', '.join(simpler)}")
    return "\n".join(lines)


def _rounded(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}" if value < 100 else f"{value:.0f}"


def rows(folder: Path, rounds: int, rnea: CDLL | str) -> Iterator[Timed]:
    """Figures of every arm that is at hand."""
    for name in NAMES:
        arm = arm_named(name)
        if arm is not None:
            yield timed(name, arm, simplified(arm), folder, rnea, rounds)
            continue
        told(f"{name} is left out: example-robot-data is not installed")


def report(found: list[Timed], rnea: CDLL | str) -> str:
    """Write the study as Markdown."""
    lines = [
        "# Exported C: nanoseconds per torque",
        "",
        made_with(),
        "",
        "Generated by `python analysis/exported_c.py`; do not edit. Times vary with the machine; ratios less.",
        "",
        f"{machine()}, {_compiler()}, double precision, one thread. {TIMED} states drawn from the arm's limits; the time is "
        "per state, the least of many rounds in which everybody has a turn of a millisecond. Models are those of the first of "
        f"{', '.join(BUDGETS)} of every joint's peak torque whose torque takes fewer operations than the exact one, made over "
        f"{STATES} states at {EFFORT:g} of the usual effort.",
        "",
        "- `one`: `NAME_torque` in a loop of C, from another file. `many`: `NAME_torque_many`, structure of arrays. `C++`: the "
        "exported template for double, in a loop of C++, which compilers may put in line.",
        "- CasADi: C that CasADi generates of the exact torque, in a loop of C. Pinocchio's wheel has no `pinocchio.casadi`, so "
        "the recursion of Newton and Euler is written by hand in CasADi's symbols, as a textbook has it, zeros and ones "
        "folded, common expressions shared (`cse`). With the same flags as ours.",
        "- rnea C++: Pinocchio's `rnea` by the headers of its wheel, `g++ -O3 -march=native -DNDEBUG`, in a loop of C++"
        + (f"; left out here: {rnea}." if isinstance(rnea, str) else ".")
        + " rnea Python: `pinocchio.rnea` called from Python per state.",
        "",
        "## Nanoseconds",
        "",
        "| arm | torque | operations | sin, cos | "
        + " | ".join(f"{how} {flags}" for flags in FLAGS for how in HOW)
        + " |",
        "|" + "---|" * (4 + len(FLAGS) * len(HOW)),
    ]
    for row in found:
        for what in MODELS:
            count = row.counts[what]
            cells = [_rounded(row.nanoseconds[f"{what}, {how}, {flags}"]) for flags in FLAGS for how in HOW]
            lines.append(
                f"| {row.name} | {what} | {count.total} | {count.sines_cosines} | {' | '.join(cells)} |"
            )
    lines += [
        "",
        "| arm | operations of CasADi | "
        + " | ".join(f"CasADi {flags}" for flags in FLAGS)
        + " | rnea C++ | rnea Python |",
        "|" + "---|" * (4 + len(FLAGS)),
    ]
    for row in found:
        peers = [
            row.nanoseconds.get(each)
            for each in (*(f"CasADi, {flags}" for flags in FLAGS), "rnea C++", "rnea Python")
        ]
        lines.append(f"| {row.name} | {row.casadi} | {' | '.join(map(_rounded, peers))} |")
    lines += [
        "",
        "## Times faster",
        "",
        "| arm | torque | how | than CasADi | than rnea C++ | than rnea Python |",
        "|" + "---|" * 6,
    ]
    for row in found:
        for what in MODELS:
            for how, flags in (("one", FLAGS[0]), ("one", FAST), ("many", FAST)):
                ours = f"{what}, {how}, {flags}"
                times = [row.faster(ours, than) for than in (f"CasADi, {flags}", "rnea C++", "rnea Python")]
                lines.append(f"| {row.name} | {what} | {how} {flags} | {' | '.join(map(_rounded, times))} |")
    return "\n".join([*lines, "", *in_short(found), ""])


def in_short(found: list[Timed]) -> Iterator[str]:
    """Say what the tables add up to."""
    puma = found[0]
    many, one = (puma.faster(f"simplified, {how}, {FAST}", f"CasADi, {FAST}") for how in ("many", "one"))
    yield "## In short"
    yield ""
    yield f"- The simplified PUMA is {many:.1f} times faster than CasADi's exact C at once, {one:.1f} times one by one."
    slower = [f"{row.name}: {what}" for row in found for what in row.slower_than_exact]
    yield "- Simplified models slower than an exact one, called in the same way or CasADi's: " + (
        "; ".join(slower) + "." if slower else "none."
    )
    gains = [
        row.nanoseconds[f"{what}, one, {FAST}"] / row.nanoseconds[f"{what}, many, {FAST}"]
        for row in found
        for what in MODELS
    ]
    yield f"- Many at once are {min(gains):.1f} to {max(gains):.1f} times faster than one by one, with {FAST}."


def _compiler() -> str:
    told = subprocess.run(["gcc", "-dumpfullversion"], capture_output=True, text=True, check=True).stdout
    return f"gcc {told.strip()}"


def main(rounds: int = 1000) -> None:
    """Measure everything and write the study."""
    with tempfile.TemporaryDirectory() as folder:
        rnea = rnea_library(Path(folder) / "rnea")
        found = []
        for row in rows(Path(folder), rounds, rnea):
            found.append(row)
            told("\n" + block(row))
        Path(__file__).with_suffix(".md").write_text(report(found, rnea), encoding="utf-8")


if __name__ == "__main__":
    main()
