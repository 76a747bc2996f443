from __future__ import annotations

import pytest

from gd_analyze.comparison import Comparison, Growth, compare, growth
from gd_analyze.robots import load_arm
from gd_analyze.trajectories import read_trajectory


@pytest.fixture(scope="session")
def grown() -> Growth:
    return growth()


@pytest.fixture(scope="session")
def swing_comparison() -> Comparison:
    arm = load_arm("two_link")
    return compare(
        arm, read_trajectory("two-link-swing", arm), command="gd-analyze compare two_link", warned=("odd",)
    )
