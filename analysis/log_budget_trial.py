"""Trial of the budget from a log: good logs of robots whose links differ from their files.

Writes log_budget_trial.md beside it: `python analysis/log_budget_trial.py`; some 10 minutes on two cores.

Each log is one of `good_log`: the robot's masses, centres and inertias are 5 to 25 % off, friction and drives are
not in the file, readings are noisy. Of each, the verdict is asked, and the model within the log's budget. Two figures
say what the log shows of the model's error: the growth that the model states, on samples not fitted, and the growth on
the last third of all readings, with drive inertia, friction and offset fitted to the rest, beside the file as it is.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import gd_analyze as gd
from gd_analyze.arrays import FloatArray
from gd_analyze.diagnosis.log_verdict import log_verdict
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.friction import own_columns
from gd_analyze.files import write_text
from gd_analyze.motions.measured import directions, filtered_torque, settled
from gd_analyze.motions.states import states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))  # makers that tests share

from faulty_logs import arms, good_log

HERE = Path(__file__).with_suffix(".md")
HEAD = """# The budget from a log tried

{count} logs without a fault, of {arms}: robots whose masses, centres and inertias are 5 to 25 % off the file's, with
friction and drives that the file does not state, and noise. The script is `analysis/log_budget_trial.py`.

"""


@dataclass(frozen=True)
class Row:
    """What a log said."""

    arm: str
    kind: str
    word: str
    contradicted: tuple[int, ...]
    terms: int  # of the model; 0 where none is searched, or too many matter
    of_terms: int
    stated: float  # largest growth that the model states
    checked: float  # largest growth on the last third of the readings
    seconds: float


def growth_on_last_third(log: Trajectory, exact: FloatArray, model: FloatArray) -> float:
    """Largest growth of the RMS of any joint on readings that nothing was fitted to."""
    direction, inside, measured = directions(log), settled(log), filtered_torque(log)
    is_late = np.arange(len(log.time)) >= 2 * len(log.time) // 3
    growths = []
    for i in range(log.n_joints):
        used = inside & (direction[:, i] != 0) & np.isfinite(measured[:, i])
        if min((used & is_late).sum(), (used & ~is_late).sum()) < 30:
            continue
        columns = own_columns(log.qdd[:, i], direction[:, i], log.qd[:, i])
        sizes = []
        for torque in (exact, model):
            difference = measured[:, i] - torque[:, i]
            numbers = np.linalg.lstsq(columns[used & ~is_late], difference[used & ~is_late], rcond=None)[0]
            left = (difference - columns @ numbers)[used & is_late]
            sizes.append(float(np.sqrt(np.mean(left**2))))
        growths.append(sizes[1] / sizes[0] - 1.0)
    return max(growths, default=np.nan)


def tried(name: str, seed: int) -> Row:
    """One log."""
    warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
    file = _arms()[name]
    kind, log = good_log(file, seed)
    start = time.process_time()
    verdict = log_verdict(file, [log])
    if verdict.resolution is None:
        seconds = time.process_time() - start
        return Row(name, kind, verdict.word, verdict.contradicted, 0, 0, np.nan, np.nan, seconds)
    try:
        model = gd.simplify(file, log, "log", at_set_points=True)
    except gd.GdAnalyzeError as error:  # too many terms matter
        print(name, kind, error, file=sys.stderr)
        seconds = time.process_time() - start
        return Row(name, kind, verdict.word, verdict.contradicted, 0, 0, np.nan, np.nan, seconds)
    seconds = time.process_time() - start
    stated = model.accuracy.log
    assert stated is not None
    assert stated.growth is not None
    exact = torque_of(file, states_of(log))
    checked = growth_on_last_third(log, exact, model.torque(log.q, log.qd, log.qdd))
    largest = float(np.nanmax(stated.growth))
    return Row(name, kind, verdict.word, verdict.contradicted, *model.size, largest, checked, seconds)


@cache
def _arms() -> dict[str, RobotArm]:
    return arms()


def rows_of(count: int, workers: int) -> Iterator[Row]:
    """All rows, in an order in which the first are like all."""
    tasks = [(name, seed + 7 * at) for at, name in enumerate(arms()) for seed in range(count)]
    order = np.random.default_rng(0).permutation(len(tasks)).tolist()
    names, seeds = zip(*(tasks[k] for k in order), strict=True)
    with ProcessPoolExecutor(workers) as executor:
        yield from executor.map(tried, names, seeds)


def page(rows: list[Row]) -> str:
    """Figures, and a line per arm."""
    names = list(dict.fromkeys(row.arm for row in rows))
    models = [row for row in rows if row.terms]
    contradicted = [row for row in rows if row.word == "does not agree"]
    in_part = [row for row in rows if row.contradicted and row not in contradicted]
    stated, checked = (np.array([getattr(row, key) for row in models]) for key in ("stated", "checked"))
    text = HEAD.format(count=len(rows), arms=", ".join(sorted(names)))
    text += f"- Said to contradict the file: {len(contradicted)}; to leave much at some joint: {len(in_part)}"
    text += "".join(f"; {row.arm}, {row.kind}" for row in (*contradicted, *in_part)) + ".\n"
    exact = sum(row.terms == row.of_terms for row in models)
    text += f"- With a model within the log's budget: {len(models)}, of which {exact} are the exact torque; of the others "
    text += "too many terms matter.\n"
    for what, growth in (("that the model states", stated), ("on the last third", checked)):
        within = 100 * np.mean(growth <= 0.03)
        worst = 100 * np.max(growth)
        text += (
            f"- Growth {what}, worst joint: at most 3 % in {within:.0f} % of them; at most {worst:.1f} %.\n"
        )
    seconds = np.array([row.seconds for row in models])
    text += f"- Processor time at the set points: median {np.median(seconds):.1f} s, at most {seconds.max():.0f} s.\n\n"
    text += "| arm | logs | budgets | terms (median) | of | growth stated (median, largest) | growth on the last third |\n"
    text += "| --- | ---: | ---: | ---: | ---: | ---: | ---: |\n"
    for name in sorted(names):
        own = [row for row in models if row.arm == name]
        count = sum(row.arm == name for row in rows)
        if not own:
            text += f"| {name} | {count} | 0 | | | | |\n"
            continue
        numbers = [
            f"{100 * np.median(growth):.1f}, {100 * np.max(growth):.1f} %"
            for growth in ([row.stated for row in own], [row.checked for row in own])
        ]
        terms, of = np.median([row.terms for row in own]), own[0].of_terms
        text += f"| {name} | {count} | {len(own)} | {terms:.0f} | {of} | {numbers[0]} | {numbers[1]} |\n"
    return text


def main() -> None:
    """Run the trial and write the page."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--logs", type=int, default=15, help="of each arm")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--dry", action="store_true", help="write no page")
    given = parser.parse_args()
    rows = []
    for row in rows_of(given.logs, given.workers):
        rows.append(row)
        print(row, file=sys.stderr, flush=True)
    text = page(rows)
    if not given.dry:
        write_text(HERE, text)
    print(text)


if __name__ == "__main__":
    main()
