"""How a motion is followed over time: by which formulation, integrator and tolerances."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from gd_analyze.dynamics.accelerations import DEFAULT_METHOD
from gd_analyze.dynamics.methods import known_method
from gd_analyze.errors import UsageError

Integrator = Literal["RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA"]

# SciPy's Runge-Kutta methods cannot be asked for more.
TIGHTEST_RTOL = 100 * float(np.finfo(float).eps)


@dataclass(frozen=True)
class Integration:
    """How to integrate a motion.

    Parameters
    ----------
    set_points
        How many, evenly spaced from 0 to the duration, to report.
    method
        Formulation that gives D, h and c, of `gd_analyze.dynamics.methods.METHODS`.
    integrator
        `scipy.integrate.solve_ivp`'s. An arm that friction holds nearly at rest is stiff: "LSODA" or "BDF".
    rtol, atol
        Tolerances per step, of every joint variable and rate and of work and dissipation.

    Raises
    ------
    UsageError
        If there is no such formulation or integrator, or a number does not fit.
    """

    set_points: int = 201
    method: str = DEFAULT_METHOD
    integrator: Integrator = "DOP853"
    rtol: float = 1e-9
    atol: float = 1e-9

    def __post_init__(self) -> None:
        known_method(self.method)
        if int(self.set_points) != self.set_points or self.set_points < 2:
            raise UsageError(
                "a simulation has at least two set points",
                where="set_points",
                expected="a whole number of 2 or more",
                found=str(self.set_points),
            )
        if self.integrator not in get_args(Integrator):
            raise UsageError(
                f"there is no integrator {self.integrator!r}",
                where="integrator",
                expected=", ".join(get_args(Integrator)),
            )
        rtol, atol = self.rtol, self.atol
        if not (np.isfinite(rtol) and rtol >= TIGHTEST_RTOL and np.isfinite(atol) and atol > 0):
            raise UsageError(
                "the integrator cannot keep these tolerances",
                where="rtol, atol",
                expected=f"rtol of {TIGHTEST_RTOL:.1e} or more, atol above 0",
                found=f"{rtol:g}, {atol:g}",
            )

    def __str__(self) -> str:
        return f"{self.method}, {self.integrator}, rtol {self.rtol:g}, atol {self.atol:g}"


USUAL = Integration()
