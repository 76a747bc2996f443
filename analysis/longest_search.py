"""How much does the main job's short search leave undone? Its model beside that of `simplify --effort 10`.

Both hold a budget of 1 % of peak torque near the same motion. Arms that are not shipped swing about the middle of
their ranges on a polynomial of degree five, as fast as their limits allow. Files named beside are tried as well.
Writes `longest_search.md` beside this file; takes an hour or two: `python analysis/longest_search.py [URDF ...]`.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import gd_analyze as gd
from exported_c import arm_named
from gd_analyze.cache import without_cache
from gd_analyze.certification.held import Held
from gd_analyze.certification.holding import simplify_held
from gd_analyze.certification.tube import Tube
from gd_analyze.motions.planning import Schedule, plan_motion
from gd_analyze.robots.limits import box_limits
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.search import SearchOptions
from psdm_measure import machine

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))  # makers that tests share

from published_arms import arm_of

SHIPPED = (
    ("puma560", "pick-and-place"),
    ("puma560", "large-slew"),
    ("puma560", "wrist-move"),
    ("stanford", "swing"),
)
OTHERS = ("UR10", "Panda", "SCARA", "KR6", "LBR7")
# Share of the range to each side of its middle, and of one that is more than a turn.
SWING, TURN = 0.3, 2.0 * np.pi
SHORT, LONG = SearchOptions(thorough=False), SearchOptions(effort=10.0)


def swing(arm: gd.types.RobotArm) -> gd.Trajectory:
    """Plan a motion about the middle of every joint's range."""
    limits = box_limits(arm)
    middle, half = (limits.upper + limits.lower) / 2.0, SWING * np.minimum(limits.upper - limits.lower, TURN)
    ends, name = (middle - half, middle + half), "swing"
    first = plan_motion(arm, *ends, schedule=Schedule(10.0, "quintic"), allow_violations=True)
    seconds = float(first.shortest_duration or 10.0)
    return gd.plan(arm, *ends, 1.01 * seconds, profile="quintic", name=name)


def found(arm: gd.types.RobotArm, motion: gd.Trajectory, how: SearchOptions) -> tuple[Held, float]:
    """Search for a model that holds near a motion, and how long that takes, s of a processor."""
    start = time.process_time()
    held = simplify_held(ExactDynamics.of(arm, motion), "1%", Tube.along(arm, motion), how)
    return held, time.process_time() - start


def rows(files: list[str]) -> Iterator[str]:
    """One line of the table for each motion."""
    cases = [(gd.load_arm(name), motion) for name, motion in SHIPPED]
    cases += [
        (arm, "swing") for name in OTHERS if (arm := arm_of(name) if name == "SCARA" else arm_named(name))
    ]
    cases += [(gd.load_arm(file), "swing") for file in files]
    for arm, name in cases:
        motion = swing(arm) if name == "swing" else gd.read_trajectory(name, arm)
        (short, quick), (long, slow) = (found(arm, motion, how) for how in (SHORT, LONG))
        taken = [held.model.operations.total for held in (short, long)]
        proof = ["proven" if held.tried == 0 and held.certificate else "tried" for held in (short, long)]
        yield (
            f"| {arm.name} | {name} | {short.model.operations_full.total} | {taken[0]}, {proof[0]} | {quick:.0f} "
            f"| {taken[1]}, {proof[1]} | {slow:.0f} | {100.0 * (taken[0] / taken[1] - 1.0):+.0f} % |"
        )


def main() -> None:
    """Write the study, line by line, as some take long."""
    head = (__doc__ or "").partition("?")[0]
    lines = [f"# {head}?", "", *(__doc__ or "").splitlines()[2:4], "", f"On {machine()}.", ""]
    lines += ["| arm | motion | exact | main job's search | s | `--effort 10` | s | main job's, more |"]
    lines += ["|---|---|---|---|---|---|---|---|"]
    with without_cache(), warnings.catch_warnings():
        warnings.simplefilter("ignore", gd.GdAnalyzeWarning)  # limits that files do not state are assumed
        for row in rows(sys.argv[1:]):
            print(row, flush=True)
            lines.append(row)
            Path(__file__).with_suffix(".md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
