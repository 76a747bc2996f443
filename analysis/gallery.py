"""Runs the commands of the gallery and writes docs/gallery.md, its figures and reports: `python analysis/gallery.py`.

`python analysis/gallery.py ur10 panda` makes these sections and leaves the others, and so is a section left whose
input is missing. UR10 and Panda come from `pip install example-robot-data`; the page says where the UR10's log comes
from, and `--log FOLDER` where it lies. README's picture is a screenshot of the first report, taken where there is a
Chromium and nothing is chosen.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from textwrap import wrap

from PIL import Image

import gd_analyze as gd
from gd_analyze.cli import main as gd_analyze
from gd_analyze.figures.diagnosis import diagnosed_torque_figure
from gd_analyze.figures.figure import Figure
from gd_analyze.figures.svg import figure_svg
from gd_analyze.files import write_text
from gd_analyze.results.diagnosis_result import diagnosis_table
from gd_analyze.studies.identification_result import identified_torque_figure

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "docs" / "gallery"
PAGE = ROOT / "docs" / "gallery.md"
HEAD = """# Gallery

A figure, its commands, and the report that they write.

<!-- Written by analysis/gallery.py. -->
"""
LOG = "ur10_exciting_trajectory.db3"
PANDA_LOG = "panda_exciting_trajectory.db3"
# Files of example-robot-data.
PUBLISHED = {
    "ur10_robot.urdf": "ur_description/urdf/ur10_robot.urdf",
    "panda.urdf": "panda_description/urdf/panda.urdf",
}
DATA = "[example-robot-data](https://pypi.org/project/example-robot-data/)"
SALERNO = "https://github.com/unisa-acg/inverse-dynamics-solver"
BLANK = '<rect width="100%" height="100%" fill="#fff"/>'  # also where a page is dark
SCREEN = "1000,680"  # what a report shows before anyone scrolls
COLOURS = 128  # the page has few; a third of the size of true colour
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@dataclass(frozen=True)
class Result:
    """One section: its commands draw figures into folder NAME, or `figure` draws one, and may write NAME-report."""

    name: str
    title: str
    commands: tuple[str, ...]
    figure: str | Callable[[], Figure]
    alternative: str
    sentence: str
    report: str = ""
    inputs: tuple[str, ...] = ()


def identified() -> Figure:
    """Draw what the command finds: its figure is in the report alone."""
    arm = gd.load_arm("ur10_robot.urdf")
    return identified_torque_figure(gd.identify(arm, gd.read_trajectory(LOG, arm)))


def diagnosed() -> Figure:
    """Draw measured and fitted torque, which are in the report alone."""
    arm = gd.load_arm("panda.urdf", tip="panda_link8")
    return diagnosed_torque_figure(diagnosis_table(gd.diagnose(arm, gd.read_trajectory(PANDA_LOG, arm))), arm)


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
        "A PUMA 560: Fig. 3.10 of [FGL87]",
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
    Result(
        "ur10",
        "A UR10: what its log tells",
        (f"gd-analyze identify ur10_robot.urdf {LOG} -o ur10.toml --report ur10-report",),
        identified,
        "Torque of the six joints of a UR10 over 27 s: measured, of the file, and identified",
        f"The file knows neither friction nor drives; what is identified from the first two thirds predicts the last, shaded. "
        f"File: {DATA} (ROS-Industrial, BSD). Log: `ur10_inverse_dynamics_solver/bagfiles/{LOG}` of the "
        f"[University of Salerno]({SALERNO}) (Petrone, Ferrentino, Chiacchio; BSD-3-Clause).",
        inputs=("ur10_robot.urdf", LOG),
    ),
    Result(
        "panda",
        "A Panda: seven joints, full inertias",
        (
            "gd-analyze plan panda.urdf --tip panda_link8 --from 0,-45,0,-135,0,90,45 --to 90,0,30,-90,45,120,-30 "
            "--duration 2.5 --profile quintic -o reach.csv",
            "gd-analyze figures panda.urdf reach.csv --tip panda_link8 --no-marks --out panda",
            "gd-analyze panda.urdf reach.csv --tip panda_link8 --format html --out panda-report",
        ),
        "inertia",
        "The 28 elements of D of a Franka Panda by effect",
        f"Translation suffices for the large joints, and rotation counts towards the hand. File: {DATA} (Franka Robotics, Apache-2.0).",
        inputs=("panda.urdf",),
    ),
    Result(
        "diagnosis",
        "A Panda and its log: what does not fit",
        (
            f"gd-analyze diagnose panda.urdf {PANDA_LOG} --tip panda_link8 --report diagnosis-report --format html",
        ),
        diagnosed,
        "Measured and fitted torque of the seven joints of a Franka Panda over 24 s",
        "The file with friction explains joints 2 to 6. No cause is named for joints 1 and 7: they carry next to no weight, "
        "and a quarter of their small torques remains. "
        f"Log: `franka_inria_inverse_dynamics_solver/bagfiles/{PANDA_LOG}` of the same university (BSD-3-Clause).",
        inputs=("panda.urdf", PANDA_LOG),
    ),
    Result(
        "scara",
        "A SCARA: three joints that turn, one that slides",
        (
            "gd-analyze plan scara --from -60,90,0.15,0 --via -50,75,0.1,20 --via 35,-55,0.1,160 --to 45,-70,0.15,180 "
            "--points 46 --duration 0.9 -o place.csv",
            "gd-analyze figures scara place.csv --no-marks --out scara",
            "gd-analyze scara place.csv --format html --out scara-report",
        ),
        "inertia",
        "The ten elements of D of a SCARA by effect",
        "The spindle, joint 3, slides parallel to the other joints' axes: D13, D23 and D34 are zero. Numbers: Lloyd, Irani and "
        "Ahmadi 2021, Table 1.",
    ),
)


def fetched(log: Path | None) -> list[str]:
    """Copy the inputs that there are into the current folder."""
    places = {} if log is None else {name: log / name for name in (LOG, PANDA_LOG, *PUBLISHED)}
    with contextlib.suppress(PackageNotFoundError):
        robots = distribution("example-robot-data").locate_file(
            "cmeel.prefix/share/example-robot-data/robots"
        )
        places |= {name: Path(str(robots), path) for name, path in PUBLISHED.items()}
    there = [name for name, path in places.items() if path.is_file()]
    for name in there:
        shutil.copy(places[name], name)
    return there


def folded(command: str) -> str:
    """Continue a long command on further lines, an option's value on that of the option."""
    glued = re.sub(r"( --?[a-z][-a-z]*) ", "\\1\0", command)
    lines = wrap(glued, 92, break_long_words=False, break_on_hyphens=False)
    return " \\\n    ".join(lines).replace("\0", " ")


def section(result: Result) -> str:
    """Run the commands in the current folder; keep figure and report; write them up."""
    for command in result.commands:
        print(command, flush=True)
        with contextlib.redirect_stdout(io.StringIO()):
            gd_analyze([*shlex.split(command)[1:], "--json"])
    image = FOLDER / f"{result.name}.svg"
    if callable(result.figure):
        drawing = figure_svg(result.figure())
    else:
        drawing = Path(result.name, f"{result.figure}.svg").read_text(encoding="utf-8")
    write_text(image, drawing.replace(">", f">{BLANK}", 1))
    parts = [f"\n## {result.title}", f"![{result.alternative}](gallery/{image.name})", result.sentence]
    for made in Path(f"{result.name}-report").glob("*.html"):
        report = result.report or f"gallery/{result.name}.html"
        if not result.report:
            shutil.copy(made, FOLDER.parent / report)
        parts.append(f"[The report]({report}).")
    return "\n\n".join((*parts, "\n".join(("```sh", *map(folded, result.commands), "```\n"))))


def picture(page: Path) -> None:
    """Take README's picture of a report's first screen."""
    browser = next(filter(shutil.which, BROWSERS), None)
    if browser is None:
        print("no Chromium: README's picture is not taken anew")
        return
    words = [browser, "--headless", "--no-sandbox", "--hide-scrollbars", f"--window-size={SCREEN}"]
    image = ROOT / "docs" / "images" / "report.png"
    words += ["--force-device-scale-factor=2", f"--screenshot={image}"]
    subprocess.run([*words, page.resolve().as_uri()], check=True, capture_output=True)
    with Image.open(image) as shot:
        flat = shot.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    flat.save(image, optimize=True)


def written() -> dict[str, str]:
    """Sections that the page has, by title."""
    page = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
    return {part.partition("\n")[0]: f"\n## {part}" for part in page.split("\n## ")[1:]}


def main() -> None:
    """Make sections in a temporary folder, and the page of these and those that it had."""
    parser = argparse.ArgumentParser(description="Write docs/gallery.md, its figures and its reports.")
    names = [result.name for result in RESULTS]
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"sections to make, of: {', '.join(names)}")
    parser.add_argument("--log", type=Path, help=f"folder of {LOG}, of {PANDA_LOG}, or of the files")
    given = parser.parse_args()
    if unknown := set(given.names) - {*names}:
        parser.error(f"no section is called {', '.join(sorted(unknown))}; there are: {', '.join(names)}")
    log = None if given.log is None else given.log.resolve()
    FOLDER.mkdir(exist_ok=True)
    sections = written()
    with tempfile.TemporaryDirectory() as work:
        os.chdir(work)
        there = fetched(log)
        for result in RESULTS:
            missing = [name for name in result.inputs if name not in there]
            if given.names and result.name not in given.names:
                continue
            if missing:
                print(f"{result.name} is left as it is, for want of {', '.join(missing)} (see --help)")
                continue
            sections[result.title] = section(result)
        if not given.names:
            picture(Path("dominance-report", "report.html"))
        os.chdir(ROOT)
    write_text(PAGE, HEAD + "".join(sections.get(result.title, "") for result in RESULTS))


if __name__ == "__main__":
    main()
