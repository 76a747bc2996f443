from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.robots.parts import Joint, Link


@pytest.fixture(scope="session")
def puma() -> RobotArm:
    return load_arm("puma560")


@pytest.fixture(scope="session")
def two_link() -> RobotArm:
    return load_arm("two_link")


@pytest.fixture(scope="session")
def slider() -> RobotArm:
    """A sliding joint with limits behind a turning joint without any."""
    joints = (
        Joint("1"),
        Joint("slide", kind="prismatic", lower=0.0, upper=0.5, velocity_limit=1.0, acceleration_limit=4.0),
    )
    links = tuple(Link(str(i), 1.0, np.zeros(3), 0.1 * np.eye(3)) for i in (1, 2))
    return RobotArm("slider", joints, links)


@pytest.fixture
def csv_file(tmp_path: Path) -> Callable[[str | bytes], Path]:
    def write(content: str | bytes) -> Path:
        path = tmp_path / "motion.csv"
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return write


@pytest.fixture
def warned() -> Callable[[], object]:
    """Collects the texts of our warnings; any other warning stays an error."""

    @contextmanager
    def collect() -> Iterator[list[str]]:
        texts: list[str] = []
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("error")
            warnings.simplefilter("always", GdAnalyzeWarning)
            yield texts
        texts += [str(warning.message) for warning in caught]

    return collect
