"""Tables of models and bounds: computed, and written into `documented_tables.md` and docs/three_minutes.md.

A table follows a line `<!-- table: NAME -->`, and ends with the next empty line. Some minutes in all:
`python analysis/documented_tables.py [NAME ...]`
"""

from __future__ import annotations

import re
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

import numpy as np

import gd_analyze as gd
from gd_analyze.certification.holding import simplify_held
from gd_analyze.files import write_text
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.text import number

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))  # makers that tests share

from published_arms import arm_of

PAGES = [
    Path(__file__).parents[1] / name for name in ("analysis/documented_tables.md", "docs/three_minutes.md")
]
MOTIONS = ("pick-and-place", "large-slew", "wrist-move")
Row = Iterable[object]


def timed(work: Callable[[], Any]) -> tuple[Any, str]:
    """Do something; its result, and the processor's seconds."""
    start = time.process_time()
    result = work()
    return result, number(time.process_time() - start)


def percent(shares: Any) -> str:
    """Show the largest share."""
    return f"{number(100 * float(np.max(shares)))} %"


def held_models() -> Iterator[Row]:
    """Models that keep their budget near a motion, at states that no search uses."""
    yield "states", "level", "D, h and c", "torque", "proven", "100 000 others", "s"
    puma = gd.load_arm("puma560")
    cases = [(puma, motion, level) for motion in MOTIONS for level in ("term", "energy")]
    for arm, where, level in cases:
        exact = gd.types.ExactDynamics.of(arm, where)
        region = gd.types.Tube.along(arm, gd.read_trajectory(where, arm))
        how = SearchOptions(LEVELS[level])
        held, seconds = timed(partial(simplify_held, exact, "1%", region, how))
        rng, model = np.random.default_rng(20_261_124), held.model
        lower, upper, _ = region.pieces(100_000, rng)
        others = States(*rng.uniform(lower, upper))
        errors = exact.at(others).errors_of(model.torque(*others.arrays)).largest
        allowed, proof = model.accuracy.allowed, held.certificate
        proven = "" if proof is None else f"{(proof.certified / allowed).max():.2f}"
        yield (
            f"{arm.name} near {where}",
            level,
            sum(function.count.total for function in model.functions),
            f"{model.operations.total} of {model.operations_full.total}",
            proven,
            f"{(errors / allowed).max():.2f}",
            seconds,
        )


def box_models() -> Iterator[Row]:
    """Models of terms within the limits, and errors over the budget: stated, sampled, and found by `certify`."""
    yield "arm", "level", "terms", "D, h and c", "torque", "stated", "100 000 states", "`certify` finds", "s"
    puma = gd.load_arm("puma560")
    cases = [(puma, "term"), (puma, "energy"), (gd.load_arm("stanford"), "term"), (arm_of("SCARA"), "term")]
    for arm, level in cases:
        exact, box = gd.types.ExactDynamics.of(arm, states_in_box(arm, 4000)), gd.types.Box.of(arm)
        held, seconds = timed(partial(simplify_held, exact, "1%", box, SearchOptions(LEVELS[level])))
        model, others = held.model, exact.at(states_in_box(arm, 100_000, 20_261_124))
        torque, allowed = model.torque(*others.states.arrays), model.accuracy.allowed
        apart, torques = (f"{of(model)} of {of(model.form)}" for of in (_of_functions, _of_torque))
        errors = (
            held.found,
            others.errors_of(torque).largest,
            gd.certify(model, box, effort=10_000).worst_found,
        )
        shares = ("" if error is None else f"{(error / allowed).max():.2f}" for error in errors)
        yield arm.name, level, f"{model.size[0]} of {model.size[1]}", apart, torques, *shares, seconds


def _of_functions(of: Any) -> int:
    return int(of.functions.operations.total)


def _of_torque(of: Any) -> int:
    return int(of.operations.total)


def panda() -> RobotArm:
    """Franka's arm as frax ships it, with the limits of acceleration that its maker states."""
    path = distribution("frax").locate_file("frax/assets/franka_panda/panda.urdf")
    return gd.load_arm(str(path), tip="panda_link7", limits="15,7.5,10,12.5,15,20,20")


def tubes() -> Iterator[Row]:
    """What is proven near the shipped motions of models that keep their budget at the set points."""
    yield "motion", "sampled", "tube, certified", "ratio", "extremes", "operations", "`--certified`"
    arm = gd.load_arm("puma560")
    for name in MOTIONS:
        motion = gd.read_trajectory(name, arm)
        exact, tube = gd.types.ExactDynamics.of(arm, motion), gd.types.Tube.along(arm, motion)
        term = LEVELS["term"]
        model = simplify_exact(exact, "1%", SearchOptions(term))
        proof = gd.certify(model, tube)
        held, _ = simplify_held(exact, "1%", tube, SearchOptions(term), certified=True)[:2]
        peak = model.accuracy.errors.peak_torque
        yield (
            name,
            percent(model.accuracy.errors.largest / peak),
            percent(proof.certified / peak),
            between(proof.ratio, 3),
            percent(gd.certify(model, tube.enclosing).certified / peak),
            model.operations.total,
            held.operations.total,
        )


def between(values: Any, digits: int = 2) -> str:
    """Show the range of some values."""
    return f"{min(values):.{digits}f} to {max(values):.{digits}f}"


def boxes() -> Iterator[Row]:
    """How tight bounds over the arm's limits are."""
    yield "model", "operations", "effort", "seconds", "found", "certified", "ratio"
    puma, stanford = gd.load_arm("puma560"), gd.load_arm("stanford")
    for name, arm, level, budget, efforts in (
        ("PUMA 560 with drives", puma, "term", "1%", (1_000, 250_000)),
        ("PUMA 560 with drives", puma, "energy", "1%", (250_000,)),
        ("Stanford arm with drives", stanford, "term", "5%", (250_000,)),
    ):
        model = gd.simplify(arm, states_in_box(arm, 4000), budget, level=level)
        peak = model.accuracy.errors.peak_torque
        for effort in efforts:
            proof, seconds = timed(partial(gd.certify, model, effort=effort))
            shares = percent(proof.worst_found / peak), percent(proof.certified / peak)
            which = f"{name}, {level}, {budget.replace('%', ' %')}"
            yield (
                which,
                model.operations.total,
                f"{effort:,}".replace(",", " "),
                seconds,
                *shares,
                between(proof.ratio),
            )


def elbow() -> Iterator[Row]:
    """What makes the torque of the PUMA 560's elbow along a motion, at most."""
    yield "part", "what it is", "at most, N m", "of peak"
    exact = gd.decompose("puma560", "pick-and-place")
    joint = 2
    peak = float(np.abs(exact.torque.values[:, joint]).max())
    by_acceleration = exact.inertia.sum("effect").values[:, joint] * exact.qdd.values
    drive = exact.drive_torque.values[:, joint]
    velocities = exact.coriolis_centrifugal.sum("effect").values[:, joint]
    others = by_acceleration[:, joint + 1 :].sum(axis=1)
    for part, meaning, torque in (
        ("c3", "gravity", exact.gravity_loading.values[:, joint]),
        ("J3 qdd3", "the elbow's motor", drive),
        ("D23 qdd2", "acceleration of the shoulder", by_acceleration[:, 1]),
        ("h3", "velocities", velocities),
        ("D33 qdd3", "acceleration of the elbow", by_acceleration[:, joint]),
        ("D13 qdd1", "acceleration of the waist", by_acceleration[:, 0]),
        ("D34 qdd4 + D35 qdd5 + D36 qdd6", "accelerations of the wrist", others),
        ("tau3", "all together", exact.torque.values[:, joint]),
    ):
        largest = float(np.abs(torque).max())
        yield part, meaning, f"{largest:.3g}", percent(largest / peak)


TABLES = {
    "elbow": elbow,
    "held models": held_models,
    "box models": box_models,
    "tubes": tubes,
    "boxes": boxes,
}


def table(rows: Iterable[Row]) -> str:
    """Write rows, the first of which are headings, as Markdown."""
    heading, *others = [[str(cell) for cell in row] for row in rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in (heading, ["---"] * len(heading), *others))


def main() -> None:
    """Write the tables named, or all."""
    warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
    wanted = sys.argv[1:] or list(TABLES)
    for name in wanted:
        text = f"<!-- table: {name} -->\n{table(TABLES[name]())}"
        print(text, flush=True)
        for page in PAGES:
            old = page.read_text(encoding="utf-8")
            new = re.sub(rf"<!-- table: {name} -->\n(\|.*\n)*", text, old)
            if new != old:
                write_text(page, new)


if __name__ == "__main__":
    main()
