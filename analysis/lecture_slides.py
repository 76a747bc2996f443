"""Six slides for a lecture on chapter 3 of [FGL87], as PNGs of 1600 x 900 pixels.

The PUMA 560 along the shipped pick-and-place move: Figs 3.10 and 3.11 of the text, both lists of verdicts, the matrix D
with h and c, the equations of the simplified model, and operations against budget.
Writes into `docs/lecture/`, or into the folder named: `python analysis/lecture_slides.py [FOLDER]`, in ten seconds.
"""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

import gd_analyze as gd
from gd_analyze.figures.structure import cells

FOLDER = Path(__file__).parents[1] / "docs" / "lecture"
WIDTH, HEIGHT, DPI = 16.0, 9.0, 100
ARM, MOTION = "puma560", "pick-and-place"
COLOURS = {
    "translation": "#4c78c8",
    "rotation": "#e08214",
    "both": "#8a63b5",
    "drive": "#9aa0a6",
    "gravity": "#3f9b6b",
    "negligible": "#e6e6e6",
    "zero": "#ffffff",
}
DARK = ("translation", "rotation", "both", "gravity")
FONT: dict[Any, Any] = {"font.size": 18, "axes.titlesize": 20, "axes.labelsize": 18}


def slide(title: str) -> Figure:
    """Return an empty slide with its title."""
    figure = plt.figure(figsize=(WIDTH, HEIGHT), dpi=DPI)
    figure.text(0.03, 0.955, title, fontsize=28, weight="bold", va="center")
    return figure


def thicken(axes: Iterable[Axes], size: int) -> None:
    """Make lines, ticks and titles of a drawn figure readable from the last row."""
    for ax in axes:
        for side in ("left", "right"):
            ax.set_title(ax.get_title(loc=side), loc=side, fontsize=size)
        ax.tick_params(labelsize=size - 3)
        ax.set(xlabel="", ylabel="")
        for line in ax.lines:
            line.set_linewidth(2.4)
        legend = ax.get_legend()
        if legend is not None:
            legend.remove()


def fig_3_10(links: gd.types.Findings) -> Figure:
    """Return D by effect, its upper triangle where it stands in the matrix."""
    figure = slide("Fig. 3.10: the elements of D by effect")
    grid = figure.add_gridspec(6, 6, left=0.05, right=0.985, top=0.87, bottom=0.06, hspace=0.75, wspace=0.42)
    names = [f"D{i}{j}" for i in range(1, 7) for j in range(i, 7)]
    axes = [figure.add_subplot(grid[int(name[1]) - 1, int(name[2]) - 1]) for name in names]
    links.plot.inertia(names, x="set point", ax=axes)
    thicken(axes, 15)
    key(figure, 0.3)
    return figure


def fig_3_11(links: gd.types.Findings) -> Figure:
    """Return h by effect."""
    figure = slide("Fig. 3.11: the elements of h by effect")
    grid = figure.add_gridspec(2, 3, left=0.06, right=0.98, top=0.84, bottom=0.16, hspace=0.4, wspace=0.25)
    names = [f"h{i}" for i in range(1, 7)]
    axes = [figure.add_subplot(grid[k // 3, k % 3]) for k in range(6)]
    links.plot.coriolis_centrifugal(names, x="set point", ax=axes)
    thicken(axes, 21)
    key(figure, 0.905)
    return figure


def key(figure: Figure, height: float) -> None:
    """Say what the lines and letters are."""
    lines = figure.axes[-1].lines
    dashed = next(line for line in lines if line.get_linestyle() == "--")
    handles, names = [lines[0], lines[1], dashed], ("whole", "translation", "rotation")
    figure.legend(
        handles, names, loc="lower left", bbox_to_anchor=(0.03, 0.01), ncols=3, fontsize=19, frameon=False
    )
    note = "set points 1 to 31; T, R: effects that represent the element within 10 % of its peak"
    for k, line in enumerate(textwrap.wrap(note, 90 if height > 0.5 else 48)):
        figure.text(0.03, height - 0.045 * k, line, fontsize=17, va="center")


def verdict_lists(links: gd.types.Findings) -> Figure:
    """Return the verdicts of the text beside those of this arm, element by element."""
    figure = slide("Which effect represents the element?")
    ax = figure.add_axes((0.02, 0.02, 0.96, 0.88))
    ax.set_axis_off()
    ax.set(xlim=(0, 3), ylim=(10.6, -0.6))
    stated = gd.tables.text_verdicts(ARM)
    assert stated is not None  # the text's own arm
    text = stated.verdicts
    ours = links.dominance.dominant.to_series()
    agree = sum(ours[element] == verdict for element, verdict in text.items())
    for k, (element, verdict) in enumerate(text.items()):
        left, row = k // 9, k % 9 + 0.6
        if k % 9 == 0:
            for x, heading in ((0.36, "the text"), (0.7, "here")):
                ax.text(left + x, -0.2, heading, fontsize=20, ha="center", va="center", style="italic")
        ax.text(left + 0.02, row, element, fontsize=24, va="center", weight="bold")
        for x, word in ((0.36, verdict), (0.7, ours[element])):
            cell(ax, left + x, row, word, 0.32, 0.82, word, 19)
        if ours[element] != verdict:
            ax.text(left + 0.91, row, "≠", fontsize=26, ha="center", va="center", color="#b00020")
    ax.text(
        0.06,
        10.2,
        f"{agree} of {len(text)} agree. Here: Armstrong, Khatib and Burdick's arm, pick-and-place, links alone",
        fontsize=22,
        va="center",
    )
    return figure


def cell(
    ax: Axes, x: float, y: float, colour: str, width: float, height: float, label: str, size: float
) -> None:
    """Draw a coloured box with a label."""
    box = Rectangle(
        (x - width / 2, y - height / 2), width, height, facecolor=COLOURS[colour], edgecolor="#bbbbbb"
    )
    ax.add_patch(box)
    ink = "white" if colour in DARK else "#222222"
    ax.text(x, y, label, fontsize=size, ha="center", va="center", color=ink, linespacing=1.3)


def matrix(findings: gd.types.Findings) -> Figure:
    """Return D with h and c: verdicts, and the largest share of a joint's peak torque."""
    figure = slide("Which parts count along the motion: D, h and c, drives included")
    ax = figure.add_axes((0.02, 0.1, 0.96, 0.8))
    ax.set_axis_off()
    ax.set(xlim=(-0.1, 8.9), ylim=(6.1, -0.1))
    verdicts = findings.dominance.verdict.to_series()
    parts = cells(findings)
    shares = {name: part.share for name, part in parts.items()}
    places: dict[str, tuple[float, float]] = {
        f"D{i}{j}": (j - 1, i - 1) for i in range(1, 7) for j in range(i, 7)
    }
    places |= {f"h{i}": (6.6, i - 1) for i in range(1, 7)} | {f"c{i}": (7.8, i - 1) for i in range(1, 7)}
    for name, (x, y) in places.items():
        verdict = verdicts.get(name, "zero")
        colour = "gravity" if name[0] == "c" and verdict != "zero" else verdict
        share = shares.get(name, 0.0)
        said = f"{100 * share:.2g} %" if share < 0.1 else f"{100 * share:.0f} %"
        if verdict in ("zero", "negligible"):
            cell(
                ax, x + 0.5, y + 0.5, colour, 0.92, 0.92, name if verdict == "zero" else f"{name}\n{said}", 19
            )
            continue
        cell(ax, x + 0.5, y + 0.5, "zero", 0.92, 0.92, "", 19)
        ax.text(x + 0.5, y + 0.36, f"{name}\n{said}", fontsize=19, ha="center", va="center", linespacing=1.2)
        # Below, the links in the colour of their verdict, and the drive beside them.
        of_drive = parts[name].parts.get("drives", 0.0)
        for name_of, start, width in ((colour, 0.0, 1.0 - of_drive), ("drive", 1.0 - of_drive, of_drive)):
            place = (x + 0.04 + 0.92 * start, y + 0.7)
            ax.add_patch(Rectangle(place, 0.92 * width, 0.26, facecolor=COLOURS[name_of]))
    names = [name for name in COLOURS if name in {*verdicts, "gravity"}]
    handles = [Patch(facecolor=COLOURS[name], edgecolor="#bbbbbb", label=name) for name in names]
    figure.legend(
        handles=handles, loc="lower left", bbox_to_anchor=(0.02, 0.01), ncols=7, fontsize=17, frameon=False
    )
    figure.text(0.03, 0.9, "largest torque, % of the joint's peak torque", fontsize=19, va="center")
    return figure


def equations(findings: gd.types.Findings) -> Figure:
    """Return the simplified model, written out."""
    model = findings.model
    functions = sum(function.count.total for function in model.functions)
    figure = slide(
        f"The model within 1 % of peak torque: {functions} operations instead of {exact_functions(model)}"
    )
    lines = [line for line in str(model.equations).splitlines() if line]
    drives = ", ".join(line for line in lines if line.startswith("J"))
    inertia = [line for line in lines if line.startswith("D")]
    others = [line for line in lines if line[0] not in "DJ"]
    for x, block, width in ((0.03, inertia, 42), (0.46, others, 51)):
        y = 0.88
        for line in block:
            whole = line.replace(" ", "\N{NO-BREAK SPACE}")  # a term stays on its line
            for sign in "+-":
                whole = whole.replace(
                    f"\N{NO-BREAK SPACE}{sign}\N{NO-BREAK SPACE}", f" {sign}\N{NO-BREAK SPACE}"
                )
            for piece in textwrap.wrap(whole, width, subsequent_indent="     "):
                figure.text(x, y, piece, fontsize=19, family="monospace", va="center")
                y -= 0.046
            y -= 0.012
    figure.text(0.03, 0.06, f"drives, kg m²: {drives}", fontsize=19, family="monospace", va="center")
    return figure


def exact_functions(model: gd.types.SimplifiedModel) -> int:
    """Operations of the exact D, h and c."""
    return int(model.form.functions.operations.total)


def budget(findings: gd.types.Findings) -> Figure:
    """Return operations against the budget, and what every joint allows, uses and is proven to use."""
    figure = slide("What a torque budget buys")
    left, right = figure.add_axes((0.07, 0.14, 0.42, 0.72)), figure.add_axes((0.58, 0.14, 0.4, 0.72))
    table = findings.tables["budgets"]
    curve = [
        (float(text.rstrip("%")), int(count))
        for text, count in zip(table.budget.values, table.operations_apart.values, strict=True)
        if text.endswith("%") and " " not in text
    ]
    exact = exact_functions(findings.model)
    left.semilogx(
        *zip(*sorted(curve), strict=True), marker="o", linewidth=3, markersize=9, color=COLOURS["translation"]
    )
    left.axhline(exact, color="#666666", linestyle="--", linewidth=2.5)
    left.text(0.1, exact - 12, f"exact: {exact}", fontsize=20, va="top")
    count = dict(curve)[1.0]
    left.annotate(
        f"1 %: {count}",
        (1.0, count),
        (1.4, count + 90),
        fontsize=22,
        arrowprops={"arrowstyle": "->", "linewidth": 2},
    )
    left.set(
        xlabel="allowed torque error, % of each joint's peak",
        ylabel="operations of D, h and c",
        ylim=(0, 1.1 * exact),
    )
    left.set_xticks([0.1, 0.3, 1, 3, 10], ["0.1", "0.3", "1", "3", "10"])
    left.minorticks_off()
    joints = [str(name) for name in findings.tables["tube"].joint_name.values]
    sampled = 100 * findings.tables["simplified_model"].largest_share.values
    proven = 100 * findings.tables["tube"].tube_certified_share.values
    places = range(len(joints))
    right.bar(
        [p - 0.2 for p in places], sampled, 0.4, color=COLOURS["translation"], label="error at the set points"
    )
    right.bar(
        [p + 0.2 for p in places], proven, 0.4, color=COLOURS["rotation"], label="proven near the motion"
    )
    right.axhline(1.0, color="#b00020", linewidth=2.5, label="allowed")
    right.set_xticks(list(places), joints, rotation=20)
    right.set(ylabel="% of peak torque", ylim=(0, 1.35))
    right.legend(fontsize=18, loc="upper right", frameon=False)
    for ax in (left, right):
        ax.spines[["top", "right"]].set_visible(False)
        ax.tick_params(labelsize=17)
    return figure


def slides() -> dict[str, Callable[[], Figure]]:
    """Return the slides by name; the main job runs with drives, and for the text's figures without."""
    links = gd.analyze(ARM, MOTION, drives=False, at_set_points=True)
    findings = gd.analyze(ARM, MOTION, budget="1%")
    return {
        "1_fig_3_10": lambda: fig_3_10(links),
        "2_fig_3_11": lambda: fig_3_11(links),
        "3_verdicts": lambda: verdict_lists(links),
        "4_matrix": lambda: matrix(findings),
        "5_equations": lambda: equations(findings),
        "6_budget": lambda: budget(findings),
    }


def write(folder: Path) -> list[Path]:
    """Write all slides into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    with plt.rc_context(FONT):
        for name, draw in slides().items():
            figure = draw()
            paths.append(folder / f"{name}.png")
            figure.savefig(paths[-1], metadata={"Software": None})
            plt.close(figure)
    return paths


if __name__ == "__main__":
    for path in write(Path(sys.argv[1]) if sys.argv[1:] else FOLDER):
        print(path)
