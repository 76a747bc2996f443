"""Result of an identification: parameters with errors, and residual torques."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.diagnosis.faults import Fault
from gd_analyze.dynamics.friction import correlation_time
from gd_analyze.identification.estimate import Estimate, start_of
from gd_analyze.result import value_text
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import html_of, joint_name


@dataclass(frozen=True)
class IdentifiedParameter:
    """One base parameter, in its unit."""

    symbol: str
    unit: str
    link: int
    file: float
    least_squares: float
    value: float  # identified: physically consistent, if that was asked for
    error: float  # standard error; plausible size if the log does not tell the parameter
    size: float  # plausible size
    identifiable: bool  # whether a change of a third of its plausible size would show in the log


@dataclass(frozen=True, eq=False)
class Residuals:
    """One joint along all logs: torques, N m (N), a row per window of time, shape (rows,) each."""

    time: FloatArray  # s, one log after the other
    measured: FloatArray
    file: FloatArray  # of the arm as given; of uniform rods if its file states no masses
    friction: FloatArray  # of the same with fitted friction
    identified: FloatArray
    held_out: Array  # whether a row was predicted, not fitted
    loaded: Array  # whether the unknown payload was carried

    @property
    def judged(self) -> Array:
        """Rows by which models are judged: held-out rows without unknown payload."""
        return self.held_out & ~self.loaded

    def rms(self, model: str) -> float:
        """RMS residual of a model over the judged rows; `measured` for the torque; nan without rows."""
        values = getattr(self, model)[self.judged]
        residual = values if model == "measured" else self.measured[self.judged] - values
        return float(np.sqrt(np.mean(residual**2))) if len(residual) else np.nan

    @property
    def is_better(self) -> bool:
        """Whether the identified model predicts better than the file with friction, by a standard error."""
        measured, friction, identified = (
            getattr(self, name)[self.judged] for name in ("measured", "friction", "identified")
        )
        gain = (measured - friction) ** 2 - (measured - identified) ** 2
        if len(gain) < 2:
            return False
        deviations = gain - gain.mean()
        all_rows = np.ones(len(gain), dtype=bool)
        independent = len(gain) / correlation_time(deviations.__getitem__, all_rows, [slice(0, len(gain))])
        return bool(gain.mean() > gain.std() / np.sqrt(independent))

    def share(self, model: str) -> float:
        """RMS residual over the RMS of the measured torque."""
        measured = self.rms("measured")
        return self.rms(model) / measured if measured else np.nan


@dataclass(frozen=True, eq=False)
class Identification:
    """An arm identified from logs.

    Parameters
    ----------
    stated_arm, arm
        The arm as stated; and the arm with identified links, drives and friction, and their uncertainty.
    logs, held_out, loaded
        Names of fitted logs, of held-out ones (empty: the last third of each), and of those with the payload.
    physical
        Whether every body is physically consistent.
    parameters
        The base parameters, drives included, from base to tip.
    friction, friction_error
        Coulomb and viscous friction and offset of every joint, N m, N m s, N m (N, N s/m, N), and standard
        errors, nan where not identifiable; (n, 3).
    drive_inertia, drive_error
        Drive inertia at the joints, kg m^2 (kg), and standard errors, (n,); partly inseparable from links.
    residuals
        Residual torques by joint.
    estimate
        Least squares of all unknowns: noise by joint, condition number, identifiable directions.
    kept
        Joints, from 1, at which the identified model did not predict held-out torque better than the file
        with friction: their torque is the file's with friction.
    faults
        Faulty readings of the logs, left out of the fit.
    doubts
        What is implausible of the identified arm, a sentence each.
    payload
        Mass, kg, and centre of mass, m, in the frame of the arm's tip, and standard errors of these four,
        (2, 4); None without loaded logs. The mass's error holds that of the torques' scale.
    torque_scale
        Factor on all torques that a known payload gave, and its standard error; None without one.
    """

    stated_arm: RobotArm
    arm: RobotArm
    logs: tuple[str, ...]
    held_out: tuple[str, ...]
    loaded: tuple[str, ...]
    physical: bool
    parameters: tuple[IdentifiedParameter, ...]
    friction: FloatArray
    friction_error: FloatArray
    drive_inertia: FloatArray
    drive_error: FloatArray
    residuals: tuple[Residuals, ...]
    estimate: Estimate
    kept: tuple[int, ...] = ()
    doubts: tuple[str, ...] = ()
    faults: tuple[Fault, ...] = ()
    payload: FloatArray | None = None
    torque_scale: tuple[float, float] | None = None

    def __repr__(self) -> str:
        count, of = sum(parameter.identifiable for parameter in self.parameters), len(self.parameters)
        return f"Identification({self.stated_arm.name!r}, {count} of {of} base parameters identifiable)"

    def _repr_html_(self) -> str:
        """Residual torques of file and identified arm by joint, for a notebook."""
        pairs = zip(self.stated_arm.joints, self.residuals, strict=True)
        rows = [
            [
                joint_name(i, joint.name),
                value_text(residuals.rms("measured"), joint.effort_unit),
                *(
                    value_text(residuals.share(model), shown="percent")
                    for model in ("file", "friction", "identified")
                ),
            ]
            for i, (joint, residuals) in enumerate(pairs, start=1)
        ]
        headings = ["joint", "RMS torque", "file", "file with friction", "identified"]
        title = f"{self.stated_arm.title or self.stated_arm.name} identified from {', '.join(self.logs)}"
        return html_of(title, headings, rows, f"RMS residuals over the RMS torque. {self!r}")

    @property
    def start(self) -> str:
        """Where links begin that logs do not tell: the file, or rods if it states no masses."""
        return start_of(self.stated_arm)

    @cached_property
    def silent(self) -> tuple[int, ...]:
        """Joints, from 1, that never move enough for their torque to be informative."""
        return tuple(i + 1 for i, residuals in enumerate(self.residuals) if not len(residuals.time))
