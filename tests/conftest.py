"""Shared fixtures; the Hypothesis profile makes every run draw the same examples."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
import xarray as xr
from hypothesis import settings

from advice import false_advice
from gd_analyze import Trajectory, decompose, load_arm, read_trajectory, simplify
from gd_analyze.cache import VARIABLE
from gd_analyze.cli.app import app
from gd_analyze.cli.entry import options_by_argument
from gd_analyze.errors import GdAnalyzeError, GdAnalyzeWarning
from gd_analyze.studies.main_job import find
from gd_analyze.tables import save_results, states_in_box
from gd_analyze.threads import begin_with_one_thread
from gd_analyze.types import Findings, RobotArm, Settings, SimplifiedModel
from recordings import CUTOFF, recorded
from strategies import PROFILE

settings.load_profile(PROFILE)


def pytest_configure() -> None:
    """Workers fill the cores: threads of linear algebra in each would only take them from each other."""
    begin_with_one_thread()


@pytest.fixture(scope="session", autouse=True)
def cache_of_the_tests(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder of the tests' own, one for all workers: nothing is written into the user's."""
    base = tmp_path_factory.getbasetemp()
    place = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "cache"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, str(place))
        yield place


@pytest.fixture(autouse=True)
def sound_advice(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Options that a message advises, in any test, exist where it stands, and take their values."""
    false: list[str] = []
    make = GdAnalyzeError.__init__

    def checked(error: GdAnalyzeError, what: str, **details: Any) -> None:
        make(error, what, **details)
        context = click.get_current_context(silent=True)
        verb = None if context is None or context.command.name not in app.commands else context.command
        options = {}
        for command in app.commands.values() if verb is None else [verb]:
            options |= options_by_argument(command)
        _, _, advice = error.with_options(options).partition("\n  next: ")
        false.extend(f"{text} in {error}" for text in false_advice(advice, verb))

    monkeypatch.setattr(GdAnalyzeError, "__init__", checked)
    yield
    assert not false, "\n".join(dict.fromkeys(false))


@pytest.fixture(scope="session")
def puma() -> RobotArm:
    return load_arm("puma560")


@pytest.fixture(scope="session")
def two_link() -> RobotArm:
    return load_arm("two_link")


@pytest.fixture(scope="session")
def pick_and_place(puma: RobotArm) -> Trajectory:
    return read_trajectory("pick-and-place", puma)


@pytest.fixture(scope="session")
def swing(two_link: RobotArm) -> Trajectory:
    return read_trajectory("two-link-swing", two_link)


@pytest.fixture(scope="session")
def pick_and_place_dataset(puma: RobotArm, pick_and_place: Trajectory) -> xr.Dataset:
    """The links' own, without drives."""
    return decompose(puma, pick_and_place, drives=False)


@pytest.fixture(scope="session")
def swing_dataset(two_link: RobotArm, swing: Trajectory) -> xr.Dataset:
    return decompose(two_link, swing)


@pytest.fixture(scope="session")
def puma_findings(puma: RobotArm, pick_and_place: Trajectory) -> Findings:
    """Everything optional switched on."""
    return find(
        puma,
        pick_and_place,
        Settings(drives=True, by_link=True, terms=True),
        command="gd-analyze puma560",
        warned=("odd",),
    )


@pytest.fixture(scope="session")
def swing_findings(two_link: RobotArm, swing: Trajectory) -> Findings:
    return find(two_link, swing, command="gd-analyze two_link")


@pytest.fixture(scope="session")
def measured_findings(two_link: RobotArm) -> Findings:
    """A log with torques, of which the second's constant is twice what it is, and friction fitted."""
    log = recorded(two_link, gain=(1.0, 2.0), noise=0.05, cutoff=CUTOFF)
    with pytest.warns(GdAnalyzeWarning, match="The file does not fit|nearly fits"):
        return find(two_link, log, Settings(fit_friction=True), command="gd-analyze two_link")


@pytest.fixture(scope="session")
def everything_found(two_link: RobotArm) -> Findings:
    """Of two logs with torques: every group and attribute that results may have."""
    first, second = (recorded(two_link, gain=(1.0, 2.0), noise=0.05, seed=k, cutoff=CUTOFF) for k in (0, 1))
    logs = [first, dataclasses.replace(second, name="again")]
    with pytest.warns(GdAnalyzeWarning, match="The file does not fit|nearly fits"):
        return find(two_link, logs, Settings(fit_friction=True), command="gd-analyze two_link")


@pytest.fixture(scope="session")
def puma_energy(puma: RobotArm) -> SimplifiedModel:
    """The PUMA with drives at 1 % over its box: what the energy level is for."""
    return simplify(puma, states_in_box(puma), level="energy", drives=True)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20240501)


@pytest.fixture
def blocked_folder(tmp_path: Path) -> Path:
    """A folder nobody can make, whatever their rights: its parent is a file."""
    (tmp_path / "file").write_text("in the way")
    return tmp_path / "file" / "results"


@pytest.fixture(scope="module")
def stored(puma_findings, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("store") / "analysis.h5"
    save_results(puma_findings, path)
    return path


@pytest.fixture(scope="module")
def small(swing_findings, tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("store") / "analysis.h5"
    save_results(swing_findings, path)
    return path.read_bytes()
