"""What a model of parts left out, and how much torque each of them makes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import chunks
from gd_analyze.simplification.accuracy import share_of
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.parts import parts_of, torque_by_part


@dataclass(frozen=True)
class Loss:
    """One part left out: its largest torque, at the joint where that is most of the peak torque.

    Parameters
    ----------
    part
        Label of the part.
    torque_peak
        Largest torque of the part at joint `torque_joint` (from 1), N m.
    torque_share
        The same over that joint's peak torque; infinite where the joint has none.
    """

    part: str
    torque_peak: float
    torque_joint: int
    torque_share: float


def losses(model: SimplifiedModel, exact: ExactDynamics) -> tuple[Loss, ...]:
    """Rank the parts that a model of parts left out by their torque at given states, largest share first."""
    parts = tuple(part for part in parts_of(model.arm.n_joints) if part not in model.terms)
    largest = np.zeros((len(parts), model.arm.n_joints))
    for chunk in chunks(len(exact.states)):
        some = exact.at(exact.states.at(chunk))
        torque = np.abs(torque_by_part(some.quantities, some.states.qdd, parts))
        np.maximum(largest, torque.max(axis=2, initial=0.0), out=largest)
    shares = share_of(largest, exact.peak_torque)
    joints = shares.argmax(axis=1)
    rows = [
        Loss(part.label, float(largest[p, joint]), int(joint) + 1, float(shares[p, joint]))
        for p, (part, joint) in enumerate(zip(parts, joints, strict=True))
    ]
    return tuple(sorted(rows, key=lambda loss: -loss.torque_share))
