from __future__ import annotations

import pytest

from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.studies.comparison import Comparison, compare
from gd_analyze.studies.comparison_costs import Growth, growth


@pytest.fixture(scope="session")
def grown() -> Growth:
    return growth()


@pytest.fixture(scope="session")
def swing_comparison(two_link: RobotArm, swing: Trajectory) -> Comparison:
    return compare(two_link, swing, command="gd-analyze compare two_link", warned=("odd",))
