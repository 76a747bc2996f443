from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gd_analyze as gd
from browser import Tab, opened, started
from few_tries import few_tries
from gd_analyze import Trajectory, load_arm, read_trajectory
from gd_analyze.motions.columns import ColumnUse
from gd_analyze.report.html import page_of
from gd_analyze.report.main_report import main_report
from gd_analyze.studies.main_job import find
from gd_analyze.types import Budget, Findings, Log, RobotArm, Settings
from page_reader import Page
from recordings import Motion, swung

# At which the two rods lose terms.
WIDE = Budget.parse("5%")


@pytest.fixture(scope="session")
def puma_findings() -> Findings:
    arm = load_arm("puma560")
    motion = read_trajectory("wrist-move", arm)
    return find(arm, motion, Settings(level="term"), command="gd-analyze puma560 wrist-move")


@pytest.fixture(scope="session")
def source(puma_findings: Findings) -> str:
    return page_of(main_report(puma_findings))


@pytest.fixture(scope="session")
def page(source: str) -> Page:
    return Page(source)


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    with started() as running:
        yield running


@pytest.fixture(scope="session")
def file(source: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path: Path = tmp_path_factory.mktemp("page") / "report.html"
    path.write_text(source, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def tab(browser: Any, file: Path) -> Iterator[Tab]:
    """The page with all folds open, shared by the tests of a file, which leave it as they found it."""
    with opened(browser, file) as tab:
        tab.unfold()
        yield tab
        assert not [line for line in tab.said if line.startswith(("error", "warning"))]


@pytest.fixture(scope="session")
@few_tries()
def by_level(two_link: RobotArm, swing: Trajectory) -> dict[str, Findings]:
    mechanical = Settings(budget=WIDE, level="energy", at_set_points=True)
    return {
        "element": gd.analyze(two_link, swing, level="element"),
        "energy": gd.analyze(two_link, swing, settings=mechanical),
        "term": gd.analyze(two_link, swing, level="term", budget=WIDE, at_set_points=True),
    }


@pytest.fixture(scope="session")
def recorded(two_link: RobotArm) -> Findings:
    """Two stretches of readings at 125 Hz, with noise."""
    time = np.concatenate([np.arange(400), np.arange(400) + 600]) / 125
    q = Motion.of(1).at(time) + 1e-3 * np.random.default_rng(3).normal(size=(len(time), 2))
    columns = (
        ColumnUse("Time", "time", unit="s", why="by name"),
        ColumnUse("<b>temp</b>", "unused", why="no quantity of a joint"),
    )
    logged = Log(time, q, None, None, None, measured=True, columns=columns, name="log", origin="made")
    return gd.analyze(two_link, Trajectory.from_log(logged, two_link))


@pytest.fixture(scope="session")
def two_motions() -> Findings:
    return gd.analyze("two_link", [swung(20.0, "slow"), swung(2.2, "fast")])
