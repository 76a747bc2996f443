from __future__ import annotations

import pytest

from gd_analyze.motions.csv_file import read_trajectory
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.studies.compare import Comparison, compare
from gd_analyze.studies.costs import Growth, growth


@pytest.fixture(scope="session")
def grown() -> Growth:
    return growth()


@pytest.fixture(scope="session")
def swing_comparison() -> Comparison:
    arm = load_arm("two_link")
    return compare(
        arm, read_trajectory("two-link-swing", arm), command="gd-analyze compare two_link", warned=("odd",)
    )
