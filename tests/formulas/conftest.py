"""Every kind of arm with formulas: revolute, prismatic, and parallel axes."""

from __future__ import annotations

import pytest

from gd_analyze.harmonics.lagrangian import energy_terms, torques_of_energies
from gd_analyze.harmonics.terms import Torques
from gd_analyze.harmonics.transform import Harmonics, harmonics_of
from gd_analyze.robots.catalogue import load_arm
from parallel_axes import scara


@pytest.fixture(scope="module", params=("two_link", "puma560", "stanford", "scara"))
def harmonics(request: pytest.FixtureRequest) -> Harmonics:
    return harmonics_of(scara() if request.param == "scara" else load_arm(request.param))


@pytest.fixture(scope="module")
def torques(harmonics: Harmonics) -> Torques:
    return torques_of_energies(energy_terms(harmonics), harmonics.velocities)
