"""Trial of diagnosis: synthetic logs of arms with one fault each, and logs without any.

Writes diagnosis_trial.md beside it: `python analysis/diagnosis_trial.py`; some 20 minutes, on two cores half of that.

A log is that of a robot whose links differ from the file's, with drives, Stribeck and load-dependent friction that
the file does not state, and noise. A fault is visible if the score of file and friction is worse than with the true
correction by more than `VISIBLE` (of loads: than that of the log without the load); a motion does not show the zero of
a vertical joint.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections import Counter, defaultdict
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import gd_analyze as gd
from gd_analyze.diagnosis.diagnose import Diagnosis, diagnose
from gd_analyze.diagnosis.hypothesis import Candidate
from gd_analyze.diagnosis.trial import Trial
from gd_analyze.files import write_text
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))  # makers that tests share

from faulty_logs import FAULTS, GOOD_KINDS, Robot, arms, good_log

HERE = Path(__file__).with_suffix(".md")
# Fall of the score, against the log without the fault, that makes it visible: twice what a claim needs.
VISIBLE = 60.0
# Numbers that score as well as the true ones to within this are right as far as the log tells.
ALIKE = 5.0
HEAD = """# Diagnosis tried

{good} logs without a fault and {bad} with one, of {arms}. The robots differ from their files (masses by 5 to 25 %,
centres of mass and inertias alike), have drives and friction that the files do not state (Coulomb, viscous, Stribeck, a
share of load), and noise. Each motion is a random Fourier series. The script is `analysis/diagnosis_trial.py`.

"""


def tried(log: Trajectory, file: RobotArm) -> tuple[Diagnosis | None, float]:
    """Diagnose, and the processor's seconds."""
    start = time.process_time()
    try:
        found = diagnose(file, log)
    except gd.GdAnalyzeError:
        found = None
    return found, time.process_time() - start


@dataclass(frozen=True)
class Row:
    """What was said of one log."""

    arm: str
    kind: str
    answers: list[str]  # in order; "right" is true, and "invisible" comes first where a fault is
    seconds: float
    best: list[str]  # the causes ranked first, for a closer look

    @property
    def is_good(self) -> bool:
        """Whether the log has no fault."""
        return self.kind.startswith("good")


def _best(found: Diagnosis | None) -> list[str]:
    return [] if found is None else [f"{one.what} ({one.fall:.0f})" for one in found.ranking[:3]]


def trial_good(name: str, file: RobotArm, seed: int) -> Row | None:
    """A log without a fault."""
    kind, log = good_log(file, seed)
    found, seconds = tried(log, file)
    claims = [] if found is None else [cause.name for cause in found.causes]
    return Row(name, f"good: {kind}", claims, seconds, _best(found))


def trial_bad(name: str, file: RobotArm, kind: str, seed: int) -> Row | None:
    """A log with a fault; None if the arm cannot have it, or the log cannot be read."""
    robot = Robot.of(file, seed)
    made = FAULTS[kind](robot)
    if made is None:
        return None
    log, arm, right, told, truth = made
    found, seconds = tried(log, arm)
    if found is None:
        return None
    answers = [*found.causes[:1], *found.rivals, *found.causes[1:]]
    score = None if truth is None else found.problem.score(truth)

    def is_right(one: Candidate) -> bool:
        # Numbers that score like the true ones are right as far as the log tells.
        alike = score is not None and found.problem.score(one.correction) < score + ALIKE
        return one.name == right and (told(one) or alike)

    names = ["right" if is_right(one) else one.name for one in answers]
    seen = found.before.score - score_without_fault(robot) if score is None else -score
    hidden = seen < VISIBLE
    return Row(name, kind, ["invisible", *names] if hidden else names, seconds, _best(found))


def trials(seeds: int, good: int, only: str, workers: int) -> Iterator[Row]:
    """All rows, in an order in which the first are like all."""
    tasks: list[Task] = []
    for at, name in enumerate(arms()):
        tasks += [("", name, seed + 7 * at) for seed in range(good if not only else 0)]
        for k, kind in enumerate(FAULTS):
            if only in kind:
                tasks += [(kind, name, 10_000 * at + 100 * k + seed) for seed in range(seeds)]
    order = [tasks[k] for k in np.random.default_rng(0).permutation(len(tasks)).tolist()]
    with ProcessPoolExecutor(workers) as executor:
        yield from (row for row in executor.map(_run, order) if row is not None)


Task = tuple[str, str, int]  # the fault, "" for none, the arm's name, and the seed


@cache
def _arms() -> dict[str, RobotArm]:
    return arms()


def _run(task: Task) -> Row | None:
    warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
    kind, name, seed = task
    file = _arms()[name]
    return trial_bad(name, file, kind, seed) if kind else trial_good(name, file, seed)


def score_without_fault(robot: Robot) -> float:
    """Score of file and friction on the log without the fault."""
    from gd_analyze.diagnosis.hypothesis import Problem
    from gd_analyze.diagnosis.samples import samples_of

    log = robot.log(*robot.as_it_is)
    usable = np.ones(log.q.shape, dtype=bool)
    problem = Problem(samples_of(robot.file, [log], [usable]), Trial.none(log.n_joints))
    return problem.null.score


def page(rows: list[Row]) -> str:
    """Figures and the confusion matrix."""
    good = [row for row in rows if row.is_good]
    bad = [row for row in rows if not row.is_good]
    seen = [row for row in bad if row.answers[:1] != ["invisible"]]
    first = sum(row.answers[:1] == ["right"] for row in seen)
    two = sum("right" in row.answers[:2] for row in seen)
    hidden = [row for row in bad if row.answers[:1] == ["invisible"]]
    wrong_hidden = sum(len(row.answers) > 1 and row.answers[1] != "right" for row in hidden)
    false = [row for row in good if row.answers]
    names = ", ".join(dict.fromkeys(row.arm for row in rows))
    text = HEAD.format(good=len(good), bad=len(bad), arms=names)
    text += f"- True cause first: {first} of {len(seen)} visible ({100 * first / max(len(seen), 1):.1f} %).\n"
    text += f"- True cause among the first two: {two} ({100 * two / max(len(seen), 1):.1f} %).\n"
    text += f"- False alarms: {len(false)} of {len(good)} logs without a fault ({100 * len(false) / max(len(good), 1):.1f} %)"
    text += "".join(f"; {row.arm}, {row.kind[6:]}: {row.answers[0]}" for row in false) + ".\n"
    text += f"- Of {len(hidden)} logs with an invisible fault {wrong_hidden} got another cause.\n"
    seconds = np.array([row.seconds for row in rows])
    text += (
        f"- Processor time: median {np.median(seconds):.1f} s a log; in all {seconds.sum() / 60:.0f} min.\n\n"
    )
    table: dict[str, Counter[str]] = defaultdict(Counter)
    for kind in [*FAULTS, *(f"good: {kind}" for kind in dict.fromkeys(GOOD_KINDS))]:
        for row in (row for row in [*seen, *good] if row.kind == kind):
            table[kind][row.answers[0] if row.answers else "none"] += 1
    columns = ["right", "none", *sorted({name for row in table.values() for name in row} - {"right", "none"})]
    lines = [
        ["log", *columns],
        *([kind, *(str(row[name] or "") for name in columns)] for kind, row in table.items()),
    ]
    widths = [max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    shown = [
        "| " + " | ".join(cell.ljust(w) for cell, w in zip(line, widths, strict=True)) + " |"
        for line in lines
    ]
    shown.insert(1, "|" + "|".join("-" * (w + 2) for w in widths) + "|")
    return f"{text}First answer by kind of log; visible faults only.\n\n" + "\n".join(shown) + "\n"


def main() -> None:
    """Run the trial and write the page."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--good", type=int, default=43)
    parser.add_argument("--only", default="")
    parser.add_argument("--most", type=int, default=10**9, help="logs after which to stop")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--dry", action="store_true", help="write no page")
    given = parser.parse_args()
    rows = []
    for row in trials(given.seeds, given.good, given.only, given.workers):
        rows.append(row)
        if row.answers if row.is_good else row.answers[:1] not in (["right"], ["invisible"]):
            print(row, file=sys.stderr, flush=True)
        if len(rows) >= given.most:
            break
    text = page(rows)
    if not given.dry:
        write_text(HERE, text)
    print(text)


if __name__ == "__main__":
    main()
