from __future__ import annotations

import math

import pytest

from gd_analyze import control, simplify
from gd_analyze.types import ControlSettings, ControlStudy, SimplifiedModel


@pytest.fixture(scope="session")
def swing_model(two_link, swing) -> SimplifiedModel:
    return simplify(two_link, swing, "20%")


@pytest.fixture(scope="session")
def puma_study(puma, pick_and_place) -> ControlStudy:
    """Without torque limits, which no bound knows of."""
    settings = ControlSettings(rates=(math.inf,), speeds=(1.0,), limits=None)
    return control(simplify(puma, pick_and_place, "1%"), pick_and_place, settings, command="gd-analyze")


@pytest.fixture(scope="session")
def swing_study(swing_model, swing) -> ControlStudy:
    settings = ControlSettings(rates=(math.inf, 200.0), speeds=(0.5, 1.0))
    return control(swing_model, swing, settings, command="gd-analyze control", warned=("odd",))
