"""Runs the commands of the gallery and writes docs/gallery.md, its figures and reports: `python analysis/gallery.py`.

README's picture is a screenshot of the sample report, taken where there is a Chromium.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import shlex
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from gd_analyze.cli import main as gd_analyze
from gd_analyze.files import write_text

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "docs" / "gallery"
HEAD = """# Gallery

Results for the shipped arms: a figure, its commands, and the report that they write.

<!-- Written by analysis/gallery.py. -->
"""
BLANK = '<rect width="100%" height="100%" fill="#fff"/>'  # also where a page is dark
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@dataclass(frozen=True)
class Result:
    """One section: they draw figures into folder NAME, and may write NAME-report."""

    name: str
    title: str
    commands: tuple[str, ...]
    figure: str
    alternative: str
    sentence: str
    report: str = ""


RESULTS = (
    Result(
        "dominance",
        "A PUMA 560: which effect dominates, and when",
        (
            "gd-analyze figures puma560 pick-and-place --out dominance",
            "gd-analyze puma560 pick-and-place --out dominance-report",
        ),
        "dominance",
        "Elements of D and h of a PUMA 560 against time, coloured by dominant effect",
        "Each row is an element of D or h; colour says which effects it needs, shade how much torque it makes.",
        "../reports/sample/report.html",
    ),
    Result(
        "inertia",
        "A PUMA 560: Fig. 3.10 of the founding text",
        ("gd-analyze figures puma560 pick-and-place --no-drives --x set-point --out inertia",),
        "inertia",
        "The 21 elements of D of a PUMA 560 by effect, at 31 set points",
        "The 21 elements of D by effect, with a mark at each set point. [A tutorial](tutorials/figures_of_the_text.py) compares the verdicts.",
    ),
    Result(
        "stanford",
        "A Stanford arm: six joints, one of them sliding",
        (
            "gd-analyze plan stanford --from 0,-90,0.4,0,30,0 --to 60,-45,0.8,90,60,45 --duration 3 "
            "--profile quintic -o reach.csv",
            "gd-analyze figures stanford reach.csv --out stanford",
            "gd-analyze stanford reach.csv --format html --out stanford-report",
        ),
        "coriolis_centrifugal",
        "Coriolis and centrifugal torque of a Stanford arm by effect",
        "Coriolis and centrifugal torque by effect while the boom, joint 3, slides out; h3 is a force.",
    ),
    Result(
        "two_link",
        "Two links: the text's example",
        (
            "gd-analyze figures two_link two-link-swing --out two_link",
            "gd-analyze two_link two-link-swing --format html --out two_link-report",
        ),
        "inertia",
        "Elements of D of two slender rods by effect",
        "In a plane, rotation makes a constant part of D.",
    ),
)


def section(result: Result) -> str:
    """Run the commands in the current folder; keep figure and report; write them up."""
    told = {}
    for command in result.commands:
        print(command, flush=True)
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            gd_analyze([*shlex.split(command)[1:], "--json"])
        told = json.loads(printed.getvalue())
    image = FOLDER / f"{result.name}.svg"
    drawing = Path(result.name, f"{result.figure}.svg").read_text(encoding="utf-8")
    write_text(image, drawing.replace(">", f">{BLANK}", 1))
    parts = [f"\n## {result.title}", f"![{result.alternative}](gallery/{image.name})", result.sentence]
    made = Path(f"{result.name}-report", "report.html")
    if made.exists():
        report = result.report or f"gallery/{result.name}.html"
        if not result.report:
            shutil.copy(made, FOLDER.parent / report)
        parts.append(f"[The report]({report}): {told['headline']}")
    return "\n\n".join((*parts, "\n".join(("```sh", *result.commands, "```\n"))))


def picture() -> None:
    """Take README's picture of the sample report."""
    browser = next(filter(shutil.which, BROWSERS), None)
    if browser is None:
        print("no Chromium: README's picture is not taken anew")
        return
    words = [browser, "--headless", "--no-sandbox", "--hide-scrollbars", "--window-size=1180,806"]
    page = (ROOT / "reports" / "sample" / "report.html").as_uri()
    image = ROOT / "docs" / "images" / "report.png"
    subprocess.run([*words, f"--screenshot={image}", page], check=True, capture_output=True)


def main() -> None:
    """Make all sections in a temporary folder."""
    FOLDER.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        os.chdir(work)
        text = HEAD + "".join(map(section, RESULTS))
        os.chdir(ROOT)
    write_text(ROOT / "docs" / "gallery.md", text)
    picture()


if __name__ == "__main__":
    main()
