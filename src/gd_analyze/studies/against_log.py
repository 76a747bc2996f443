"""A log's torques beside models: the budget that a log allows, and what it says of a model."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from gd_analyze.arrays import FloatArray, chunks
from gd_analyze.certification.held import Held
from gd_analyze.diagnosis.answer import is_for_identification
from gd_analyze.diagnosis.log_resolution import LogResolution
from gd_analyze.diagnosis.log_verdict import LogVerdict
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.friction import FRICTION_TERMS
from gd_analyze.dynamics.measured_torque import TorqueComparison, compared
from gd_analyze.errors import UsageError
from gd_analyze.motions.measured import filtered_torque
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.simplification.accuracy import AgainstLog
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel

# Allowed to a joint that the log says nothing of: a share of its peak torque.
_UNSEEN_SHARE = 0.01
# An error shows if it leaves that much more, or if its RMS is that share of what is left: unrelated to it, it
# leaves 0.3 % more, but on other readings it may be related to it by chance.
_SHOWN_GROWTH, _SHOWN_SHARE = 0.01, 0.08
# Least share of what is left that is allowed: by the triangle inequality, no error leaves more than that.
_LEAST_SHARE = 1.0 / 16.0

# Searches the model of a budget; None if too many terms matter.
SearchWithin = Callable[[Budget], Held | None]


def with_log(exact: ExactDynamics, verdict: LogVerdict | None) -> ExactDynamics:
    """Exact dynamics whose budgets may be a share of what a log leaves, if it agrees with the file."""
    if verdict is None or verdict.resolution is None:
        return exact
    left = verdict.resolution.left
    return replace(exact, left_of_log=np.where(np.isfinite(left), left, _UNSEEN_SHARE * exact.peak_torque))


def require_log(verdict: LogVerdict | None, budget: Budget, argument: str = "budget") -> None:
    """Raise a UsageError for a budget from a log that does not agree with the file, or that tells nothing."""
    if "log" in budget.wholes and verdict is not None and verdict.resolution is None:
        raise UsageError(
            "this log gives no budget",
            where=argument,
            expected="a log that the file describes",
            found=verdict.opening,
            next_step="mend it first, as `gd-analyze diagnose ROBOT LOG` says, or take a budget such as 1%",
        )


def within_log(
    exact: ExactDynamics, resolution: LogResolution, asked: Budget, searches: Sequence[SearchWithin]
) -> Held | None:
    """Search the model within a log's budget, of which joints get as much as the log does not show.

    A joint's share is halved, down to a sixteenth, where the model's error shows: it leaves over 1 % more of
    the log, as RMS over the samples to which friction is fitted, or its own RMS is over 8 % of what is
    left.

    Parameters
    ----------
    exact, resolution
        Exact dynamics along the log, and what the log tells of errors.
    asked
        The budget to begin with; its shares of the log are halved.
    searches
        Rough ones first: each goes on with the shares that the one before leaves.

    Returns
    -------
    Held or None
        What the last search finds; None if too many terms matter for one of them.
    """
    states, share = resolution.states, np.ones(exact.arm.n_joints)
    torque = torque_of(exact.arm, states, drives=exact.form.drives)
    held = None
    for search in searches:
        while True:
            held = search(asked.scaled_of("log", share))
            if held is None:
                return None
            growth = resolution.growth(held.model.torque(*states.arrays) - torque)
            is_shown = (growth.fitted > _SHOWN_GROWTH) | (growth.most > _SHOWN_SHARE)
            is_shown &= share > _LEAST_SHARE
            if not is_shown.any():
                break
            share = np.where(is_shown, 0.5 * share, share)
    return held


def beside_log(
    model: SimplifiedModel,
    motion: Trajectory,
    comparison: TorqueComparison,
    verdict: LogVerdict,
    left: FloatArray | None,
) -> SimplifiedModel:
    """State what a log says of a model, beside the comparison of the exact torque.

    `left` is `ExactDynamics.left_of_log`.
    """
    arm, resolution, diagnosis = model.arm, verdict.resolution, verdict.diagnosis
    own = comparison if model.is_exact else compared(arm, motion, _along(model, motion))
    growth = None
    if resolution is not None:
        at_samples = torque_of(arm, resolution.states, drives=model.drives)
        error = model.torque(*resolution.states.arrays) - at_samples
        growth = np.where(np.isfinite(resolution.left), resolution.growth(error).held_out, np.nan)
    remedy = ""
    if diagnosis is not None and is_for_identification(diagnosis):
        remedy = "gd-analyze identify ROBOT LOG -o fitted.toml"
    elif diagnosis is not None and diagnosis.remedy.is_all_typed and diagnosis.remedy.options:
        remedy = f"gd-analyze ROBOT LOG {diagnosis.remedy.options}"
    stated = AgainstLog(
        name=motion.name,
        fingerprint=_fingerprint(motion),
        read_with=motion.origin.partition("corrected by ")[2],
        readings=comparison.compared,
        rms_exact=comparison.friction.rms,
        rms=own.friction.rms,
        below_95=own.friction.below_95,
        **dict(zip(FRICTION_TERMS, own.friction.terms.T, strict=True)),
        left=left,
        growth=growth,
        contradicted=verdict.contradicted,
        remedy=remedy,
    )
    return model.stating(replace(model.accuracy, log=stated))


def _fingerprint(log: Trajectory) -> str:
    """SHA-256 of a motion and its torques."""
    torque = np.ascontiguousarray(filtered_torque(log))
    return hashlib.sha256(log.fingerprint.encode() + torque.tobytes()).hexdigest()


def _along(model: SimplifiedModel, motion: Trajectory) -> FloatArray:
    """Torque of a model along a motion, N m, shape (N, n)."""
    parts = [motion.q, motion.qd, motion.qdd]
    return np.concatenate([model.torque(*(part[at] for part in parts)) for at in chunks(len(parts[0]))])
