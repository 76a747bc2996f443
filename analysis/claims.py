"""Every figure of README and of the three-minute page, and some of the other pages, with the command that gives it.

A claim is a sentence as it stands on a page, with `{}` for each figure. The figures are computed anew, or read from the
study that measured them, and compared with the page. Writes `claims.md` beside this file and ends with exit code 1 where
one differs; some two minutes: `python analysis/claims.py [PAGE ...]`.
"""

from __future__ import annotations

import re
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np

import gd_analyze as gd
from documented_tables import elbow
from gd_analyze.certification.holding import simplify_held
from gd_analyze.results.verdict_lists import verdict_lists
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.text import number

ROOT = Path(__file__).parents[1]
README, MINUTES = "README.md", "docs/three_minutes.md"
MOTIONS = ("pick-and-place", "large-slew", "wrist-move")
MAIN_JOB = "gd-analyze puma560 pick-and-place"
Figures = tuple[object, ...]


@dataclass(frozen=True)
class Claim:
    """A sentence of a page, what it takes to check it, and how."""

    page: str
    words: str  # as on the page, line breaks as blanks; `{}` for a figure, `{...}` for an equation or a list
    command: str
    find: Callable[[], Figures]

    @property
    def stated(self) -> tuple[str, ...]:
        """Return the figures that the page states; its words must stand there once."""
        text = " ".join((ROOT / self.page).read_text(encoding="utf-8").split())
        pattern = re.escape(self.words).replace(r"\{\}", r"(\S+?)").replace(r"\{\.\.\.\}", "([^`|]+?)")
        matches = list(re.finditer(rf"{pattern}(?![\w])", text))
        if len(matches) != 1:
            raise ValueError(f"{self.page} has {len(matches)} times: {self.words}")
        return matches[0].groups()

    @property
    def found(self) -> tuple[str, ...]:
        """Return the figures computed or measured."""
        return tuple(str(figure) for figure in self.find())


def apart(model: gd.types.SimplifiedModel) -> int:
    """Operations of a model's D, h and c as functions of their own."""
    return int(sum(function.count.total for function in model.functions))


@cache
def main_job() -> gd.types.Findings:
    """The main job that both pages begin with."""
    return gd.analyze("puma560", "pick-and-place", budget="1%")


@cache
def near(motions: tuple[str, ...], budget: str) -> gd.types.SimplifiedModel:
    """A model near motions, as `gd-analyze simplify` finds it."""
    arm = gd.load_arm("puma560")
    read = [gd.read_trajectory(name, arm) for name in motions]
    return gd.simplify(arm, read if len(read) > 1 else read[0], budget)


@cache
def within(certified: bool) -> tuple[gd.types.SimplifiedModel, float]:
    """A model within the PUMA's limits, and its largest error found over the error allowed."""
    arm = gd.load_arm("puma560")
    exact = gd.types.ExactDynamics.of(arm, gd.tables.states_in_box(arm, 4000))
    options = SearchOptions(LEVELS["term"])
    held = simplify_held(exact, "1%", gd.types.Box.of(arm), options, certified=certified)
    share = 0.0 if held.found is None else float(np.max(held.found / held.model.accuracy.allowed))
    return held.model, share


@cache
def named_budgets() -> dict[str, Figures]:
    """Terms, and operations of D, h and c and of the torque, of the main job's named budgets."""
    stops = gd.analyze("puma560", "pick-and-place").tables["stops"]
    columns = ("terms", "operations_apart", "sines_cosines_apart", "operations", "sines_cosines")
    return {
        str(row.budget): tuple(int(row[name]) for name in columns)
        for _, row in stops.to_dataframe().iterrows()
    }


def row_of_joint(joint: int) -> Figures:
    """A row of the main job's table of errors: peak, allowed, error and bound, with shares."""
    model, tube = main_job().tables["simplified_model"], main_job().tables["tube"]
    peak, allowed = model.peak_torque.values[joint], model.allowed_error.values[joint]
    error, proven = model.largest_error.values[joint], tube.tube_certified.values[joint]
    shares = model.largest_share.values[joint], tube.tube_certified_share.values[joint]
    upwards = np.ceil(1e4 * shares[1]) / 100, np.ceil(1e4 * proven) / 1e4  # bounds are rounded up
    return number(peak), number(allowed), number(error), f"{100 * shares[0]:.2f}", upwards[1], upwards[0]


def largest_of_dropped_terms() -> Figures:
    """Largest torques of the elbow's dropped gravity terms, S23 C5 and C23 C4 S5, and their shares of peak torque."""
    findings = main_job()
    ranked, q = findings.ranked_terms, findings.trajectory.q
    of_the_hand = [
        term for term, value in ranked.items() if term.row == 2 and abs(value / -0.028241856 - 1.0) < 1e-6
    ]
    peak, largest = np.abs(findings.exact_torque[:, 2]).max(), []
    for term in sorted(of_the_hand, key=lambda term: len(term.monomial)):
        torque = np.full(len(q), ranked[term])
        for function, multiples in term.monomial:
            torque *= getattr(np, function)(q @ np.array(multiples))
        largest.append(np.abs(torque).max())
    return *map(number, largest), *(f"{100 * torque / peak:.2g}" for torque in largest)


def equation(element: str, min_share: float = 0.0) -> str:
    """An exact equation of the PUMA as it is printed, without its left side."""
    text = " ".join(str(gd.equations("puma560", [element], min_share=min_share)).split())
    return text.rpartition(f"{element} = ")[2]


def study(name: str, *start: str) -> list[str]:
    """Cells of the one row of a study's page that begins so."""
    lines = (ROOT / "analysis" / f"{name}.md").read_text(encoding="utf-8").splitlines()
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")]
    (row,) = (row for row in rows if row[: len(start)] == list(start))
    return row


def matched(name: str, pattern: str) -> Figures:
    """What a study's page says where a pattern matches first."""
    match = re.search(pattern, (ROOT / "analysis" / f"{name}.md").read_text(encoding="utf-8"))
    assert match, f"{name}.md does not say {pattern}"
    return match.groups()


def bounds_near_motions() -> tuple[float, float]:
    """Largest ratio of bound to error found near the shipped motions, and of bound to error at the set points."""
    rows = [study("documented_tables", motion) for motion in MOTIONS]
    ratio = max(float(row[3].rpartition(" ")[2]) for row in rows)
    return ratio, max(
        float(row[2].removesuffix(" %")) / float(row[1].removesuffix(" %")) for row in rows if "%" in row[1]
    )


def bound_within_limits() -> Figures:
    """Ratio of bound to error found of the PUMA's model of terms, smallest and largest of the joints."""
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in (ROOT / "analysis" / "documented_tables.md").read_text(encoding="utf-8").splitlines()
        if line.startswith("| PUMA 560 with drives, term, 1 % |") and "| 250 000 |" in line
    ]
    return tuple(rows[0][-1].split(" to "))


def identified_arms() -> Figures:
    """Least share of runs within three standard errors, and largest torque over the noise floor, rounded up."""
    rows = [study("identified_arms", arm) for arm in ("PUMA 560", "Franka Panda", "UR10")]
    floor = max(float(row[6]) for row in rows)
    return min(int(row[3].removesuffix(" %")) for row in rows), f"{np.ceil(100 * floor) / 100:.2f}"


def left_of_real_torques() -> Figures:
    """Smallest and largest share left by the identified UR10e, of both motions and all joints."""
    logs = "ur-20_02_19_14harm50sec", "ur-20_02_12-40sec_12harm"
    rows = [study("identified_robots", *pair, "identified, of measured") for pair in (logs, logs[::-1])]
    shares = [float(cell.removesuffix(" %")) for row in rows for cell in row[3:]]
    return min(shares), max(shares)


def chains_tried() -> Figures:
    """Chains of published robots that were tried, and those refused or given up."""
    return *matched("arms_as_published", r": (\d+) chains"), *matched(
        "arms_as_published", r"(\d+) of these refused"
    )


def real_robot() -> Figures:
    """What is left at joint 2 of the UR10e's log: identified, by the file, and measured."""
    log, held = "ur-20_02_19_14harm50sec", "ur-20_02_12-40sec_12harm"
    left, file, measured = (
        study("identified_robots", log, held, kind)[4]
        for kind in ("identified, of measured", "left by the file", "measured")
    )
    return left.removesuffix(" %"), 2, file, measured


def given(*figures: str) -> Figures:
    """Figures that were computed with others."""
    return figures


def times_faster() -> Figures:
    """How many times faster one torque in C is than CasADi's, -O3 -march=native: exact, and within 1 %."""
    start = "PUMA 560 with drives"
    return tuple(
        study("exported_c", start, torque, "one -O3 -march=native")[3] for torque in ("exact", "1 %")
    )


def of_several(motions: tuple[str, ...]) -> Figures:
    """Operations of D, h and c near motions, for two budgets."""
    return tuple(apart(near(motions, budget)) for budget in ("1%", "1% or 10% friction"))


def named_budget(budget: str) -> Figures:
    """What the main job finds for a named budget."""
    return named_budgets()[budget]


def verdicts_of_translation() -> Figures:
    """Elements that translation dominates, as they are listed."""
    return (", ".join(verdict_lists(main_job().dominance).labels("translation")),)


def parts_of_the_elbow() -> list[Claim]:
    """A claim for each row of the table of parts."""
    _, *rows = ([str(cell) for cell in row] for row in elbow())
    return [
        Claim(
            MINUTES,
            f"| {part} | {meaning} | {{}} | {{}} % |",
            MAIN_JOB,
            partial(given, largest, share.removesuffix(" %")),
        )
        for part, meaning, largest, share in rows
    ]


def operations() -> Figures:
    """Operations, and sines and cosines, of D, h and c of the model and exact, and of both torques."""
    model = main_job().model
    counts = (
        model.functions.operations,
        model.form.functions.operations,
        model.operations,
        model.operations_full,
    )
    return tuple(number for count in counts for number in (count.total, count.sines_cosines))


def claims() -> list[Claim]:
    """All claims, by page."""
    simplification, trajectories, certificate, identification = (
        f"docs/{name}.md" for name in ("simplification", "trajectories", "certificate", "identification")
    )
    limits = [
        Claim(
            simplification,
            "of 1 % has {} of {} terms, {} operations for D, h and c and {} for the torque",
            "gd-analyze simplify puma560",
            lambda: (*within(False)[0].size, apart(within(False)[0]), within(False)[0].operations.total),
        ),
        Claim(
            simplification,
            "Proven, it takes {}. Links alone",
            "gd-analyze simplify puma560 --certified",
            lambda: (within(True)[0].operations.total,),
        ),
    ]
    studies = [
        Claim(
            certificate,
            "the bound is at most {} times the largest error found",
            "python analysis/documented_tables.py tubes",
            lambda: (f"{bounds_near_motions()[0]:.2f}",),
        ),
        Claim(
            certificate,
            "over its limits {} to {} times",
            "python analysis/documented_tables.py boxes",
            bound_within_limits,
        ),
        Claim(
            certificate,
            "The error in the tube is up to {} times",
            "python analysis/documented_tables.py tubes",
            lambda: (f"{bounds_near_motions()[1]:.1f}",),
        ),
        Claim(
            identification,
            "in at least {} % of the runs, and the torque of a fresh motion within {} times",
            "python analysis/identified_arms.py",
            identified_arms,
        ),
        Claim(
            identification,
            "are met to {} to {} % of their RMS",
            "python analysis/identified_robots.py",
            left_of_real_torques,
        ),
    ]
    several = [
        Claim(
            trajectories,
            f"| {row} | {{}} | {{}} |",
            f"gd-analyze simplify puma560 {' '.join(motions)} --budget ...",
            partial(of_several, motions),
        )
        for row, motions in [*((f"`{name}`", (name,)) for name in MOTIONS), ("all three", MOTIONS)]
    ]
    named = [
        Claim(
            simplification,
            f"| `{budget}` | {{}} | {{}} and {{}} | {{}} and {{}} |",
            MAIN_JOB,
            partial(named_budget, budget),
        )
        for budget in ("1%", "1% or 10% friction", "1% or 0.5% limit")
    ]
    return [
        Claim(
            README, "an error proven to be at most {} % of peak torque", MAIN_JOB, lambda: row_of_joint(2)[5:]
        ),
        Claim(
            README,
            "D, h and c of the PUMA 560 take {} operations and {} sines and cosines instead of {} and {}",
            MAIN_JOB,
            lambda: operations()[:4],
        ),
        Claim(README, "and keep {} of {} terms", MAIN_JOB, lambda: main_job().model.size),
        Claim(
            README,
            "the residual at joint {} is {} % (RMS)",
            "python analysis/identified_robots.py",
            lambda: real_robot()[1::-1],
        ),
        Claim(
            README,
            "with the file alone it is {} %, {} of {} N m",
            "python analysis/identified_robots.py",
            lambda: (
                f"{100 * float(str(real_robot()[2])) / float(str(real_robot()[3])):.0f}",
                *real_robot()[2:],
            ),
        ),
        Claim(
            README,
            "[{} chains of published robots](analysis/arms_as_published.md) were tried; {} were refused or given up",
            "python analysis/arms_as_published.py",
            chains_tried,
        ),
        Claim(
            README,
            "one torque of the PUMA is {} times faster exact, and {} times within 1 %, than CasADi's exact C",
            "python analysis/exported_c.py",
            times_faster,
        ),
        Claim(
            README,
            "# within the limits: {} operations, up to {} % found",
            "gd-analyze simplify puma560 --budget 1%",
            lambda: (within(False)[0].operations.total, f"{within(False)[1]:.2f}"),
        ),
        Claim(
            README,
            "(`--certified`), the PUMA's model takes {} operations",
            "gd-analyze simplify puma560 --budget 1% --certified",
            lambda: (within(True)[0].operations.total,),
        ),
        Claim(
            README,
            "`D12 = {...}` and",
            "gd-analyze equations puma560 --element D12 --min-share 1%",
            lambda: (equation("D12", 0.01),),
        ),
        Claim(
            README,
            "and `c2 = {...}`;",
            "gd-analyze equations puma560 --element c2 --min-share 1%",
            lambda: (equation("c2", 0.01),),
        ),
        *parts_of_the_elbow(),
        Claim(MINUTES, "Translation dominates {...} ```", MAIN_JOB, verdicts_of_translation),
        Claim(
            MINUTES,
            "without its rotation it changes by {} % of its peak",
            MAIN_JOB,
            lambda: (
                f"{100 * main_job().dominance.change_without.sel(element='D13', effect='rotation').item():.1g}",
            ),
        ),
        Claim(
            MINUTES,
            "c3 = {...} ``` The last two",
            "gd-analyze equations puma560 --element c3",
            lambda: (equation("c3"),),
        ),
        Claim(
            MINUTES,
            "terms make at most {} and {} N m on this motion, {} % and {} % of",
            MAIN_JOB,
            largest_of_dropped_terms,
        ),
        Claim(MINUTES, "3 elbow {} {} {} {} % {} {} %", MAIN_JOB, lambda: row_of_joint(2)),
        Claim(
            MINUTES, "at the {} points of the motion", MAIN_JOB, lambda: (len(main_job().trajectory.time),)
        ),
        Claim(MINUTES, "Of all joints' {} terms, {} stay", MAIN_JOB, lambda: main_job().model.size[::-1]),
        Claim(
            MINUTES,
            "D, h and c in {} operations and {} sines and cosines instead of {} and {}; "
            "torque in {} and {} instead of {} and {}.",
            MAIN_JOB,
            operations,
        ),
        *named,
        *limits,
        *several,
        *studies,
    ]


def report(checked: list[tuple[Claim, tuple[str, ...], tuple[str, ...]]]) -> str:
    """Write claims, what pages state and what was found as Markdown."""
    lines = [
        "# Claims",
        "",
        "Figures of README and the pages, each with the command that gives it. `python analysis/claims.py` computes them anew,",
        "or reads them from the study that measured them, writes this page, and fails where one differs.",
        "",
        "| page | words | command | stated | found |",
        "|---|---|---|---|---|",
    ]
    for claim, stated, found in checked:
        words = (
            claim.words.replace("|", "¦")
            .replace("`", "")
            .replace("](analysis/arms_as_published.md)", "")
            .replace("[", "")
        )
        pairs = [
            "; ".join(figures) if stated == found or k else f"**{'; '.join(figures)}**"
            for k, figures in enumerate((stated, found))
        ]
        lines.append(
            f"| {claim.page.removeprefix('docs/')} | {words} | `{claim.command}` | {pairs[0]} | {pairs[1]} |"
        )
    return "\n".join([*lines, ""])


def main() -> int:
    """Check the claims of the pages named, or of all, and write the page if all were checked."""
    warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
    wanted = sys.argv[1:]
    checked, wrong = [], 0
    for claim in claims():
        if wanted and claim.page not in wanted:
            continue
        stated, found = claim.stated, claim.found
        wrong += stated != found
        checked.append((claim, stated, found))
        print(
            "ok   " if stated == found else "WRONG",
            claim.page,
            claim.words,
            stated,
            *(() if stated == found else (found,)),
            flush=True,
        )
    if not wanted:
        Path(__file__).with_suffix(".md").write_text(report(checked), encoding="utf-8")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
