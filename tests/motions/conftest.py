from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gd_analyze import read_log
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError, in_options
from gd_analyze.types import Joint, Link, Log, Reading, RobotArm
from remedies import as_options, remedies, typed


@pytest.fixture(scope="session")
def slider() -> RobotArm:
    """A prismatic joint with limits behind a revolute joint without any."""
    joints = (
        Joint("1"),
        Joint("slide", kind="prismatic", lower=0.0, upper=0.5, velocity_limit=1.0, acceleration_limit=4.0),
    )
    links = tuple(Link(str(i), 1.0, np.zeros(3), 0.1 * np.eye(3)) for i in (1, 2))
    return RobotArm("slider", joints, links)


@pytest.fixture
def log(tmp_path: Path) -> Callable[..., Path]:
    """Writes a file."""

    def write(content: str | bytes, name: str = "log.csv") -> Path:
        path = tmp_path / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return write


@pytest.fixture
def read(log: Callable[..., Path]) -> Callable[..., Log]:
    """Writes a log and reads it; keywords are those of `Reading.of`."""

    def call(content: str | bytes, arm: RobotArm, name: str = "log.csv", **asked: Any) -> Log:
        return read_log(log(content, name), arm, Reading.of(**asked))

    return call


@pytest.fixture
def refused(log: Callable[..., Path], read: Callable[..., Log]) -> Callable[..., None]:
    """Writes a log, which is refused with words that name place or fact; types what the message advises."""

    def call(says: str, content: str | bytes, arm: RobotArm, name: str = "log.csv", **asked: Any) -> None:
        with pytest.raises(TrajectoryError) as caught:
            read(content, arm, name, **asked)
        assert says in caught.value.with_options()
        assert name in str(caught.value) or "where" in caught.value.details
        for words, is_complete in remedies(in_options(caught.value.details.get("next", ""))):
            advised: TrajectoryError | None = None
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", GdAnalyzeWarning)
                    read_log(log(content, name), arm, typed([*as_options(asked), *words]))
            except TrajectoryError as error:
                advised = error
            # What the user fills in may be refused, but not for the same reason.
            assert advised is None or not is_complete, f"{words}: {advised}"
            assert advised is None or advised.what != caught.value.what, f"{words}: {advised}"

    return call


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
