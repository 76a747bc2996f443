from __future__ import annotations

from pathlib import Path

import pytest
from report_arms import ONE_JOINT, SLIDING

from gd_analyze.main_job import Origin, find
from gd_analyze.results import Findings
from gd_analyze.robots import RobotArm, load_arm, read_arm
from gd_analyze.trajectories import read_trajectory


@pytest.fixture(scope="session")
def puma_findings() -> Findings:
    arm = load_arm("puma560")
    return find(arm, read_trajectory("wrist-move", arm), origin=Origin("gd-analyze puma560 wrist-move"))


@pytest.fixture(scope="session")
def arms(tmp_path_factory: pytest.TempPathFactory) -> dict[str, RobotArm]:
    folder: Path = tmp_path_factory.mktemp("arms")
    out = {}
    for name, text in (("one joint", ONE_JOINT), ("sliding", SLIDING)):
        path = folder / f"{name}.toml"
        path.write_text(text, encoding="utf-8")
        out[name] = read_arm(path)
    return out
