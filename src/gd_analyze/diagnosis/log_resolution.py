"""What a log can tell of errors in torque: what is left of it, and how much more an error would leave."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.diagnosis.diagnose import Diagnosis
from gd_analyze.diagnosis.equations import NUMBERS_OF_JOINT, corrected_columns
from gd_analyze.motions.states import States


class Growth(NamedTuple):
    """What an error does to the RMS of what is left, (n,); 0 where a joint is not compared."""

    fitted: FloatArray  # growth over the samples to which friction is fitted, 0.01 for 1 % more
    held_out: FloatArray  # growth over the others
    most: FloatArray  # RMS of the error over that of what is left, of all samples: their growth is no larger


@dataclass(frozen=True, eq=False)
class LogResolution:
    """Torque that a log leaves, once friction, drive inertia, offset and links are fitted, by joint.

    Parameters
    ----------
    states
        The N samples of a diagnosis.
    difference
        Measured torque less the fit, N m (N), (N, n); nan where a joint is not compared.
    own
        Columns of each joint's own numbers: drive inertia, friction and offset, (n, N, 4).
    is_held_out
        Whether a sample was not fitted, (N,).
    """

    states: States
    difference: FloatArray
    own: FloatArray
    is_held_out: Array

    @classmethod
    def of(cls, diagnosis: Diagnosis) -> Self:
        """Take the samples of a diagnosis without a cause, as logged."""
        problem = diagnosis.problem
        samples = problem.samples
        columns, _, shared = corrected_columns(samples, problem.correction)
        own = columns[:, :, shared : shared + NUMBERS_OF_JOINT]
        measured, model = problem.torques()
        states = States(samples.q, samples.qd, samples.qdd)
        resolution = cls(states, measured - model, own, np.asarray(samples.scored))
        return cls(states, resolution._refitted(measured - model), own, resolution.is_held_out)

    @cached_property
    def left(self) -> FloatArray:
        """RMS of what is left on the samples not fitted, N m (N), (n,); nan where a joint is not compared."""
        return _rms(self.difference[self.is_held_out])

    def growth(self, error: FloatArray) -> Growth:
        """How much more a torque error leaves, N m (N), (N, n), with each joint's own numbers fitted anew."""
        left = self._refitted(np.where(np.isfinite(self.difference), error, np.nan))
        with_error = self.difference - left
        fitted, held_out = (
            _ratio(_rms(with_error[chosen]), _rms(self.difference[chosen]), 1.0) - 1.0
            for chosen in (~self.is_held_out, self.is_held_out)
        )
        return Growth(fitted, held_out, _ratio(_rms(left), _rms(self.difference), 0.0))

    def _refitted(self, torque: FloatArray) -> FloatArray:
        """Torque less what a joint's own numbers make of it on the fitted samples."""
        out = torque.copy()
        for i in range(torque.shape[1]):
            fitted = ~self.is_held_out & np.isfinite(torque[:, i])
            numbers = np.linalg.lstsq(self.own[i, fitted], torque[fitted, i], rcond=None)[0]
            out[:, i] -= self.own[i] @ numbers
        return out


def _ratio(values: FloatArray, by: FloatArray, otherwise: float) -> FloatArray:
    """Ratio of two RMS values by joint; another number where there is none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = values / by
    return np.where(np.isfinite(ratio), ratio, otherwise)


def _rms(values: FloatArray) -> FloatArray:
    """RMS of the numbers of every column, (n,); nan of none."""
    counts = np.isfinite(values).sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.sqrt(np.nansum(values**2, axis=0) / counts))
