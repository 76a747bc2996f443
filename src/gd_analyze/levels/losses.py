"""What a model left out, and how much torque each part of it is along a trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.round_off import peak_magnitude
from gd_analyze.levels.model import SimplifiedModel
from gd_analyze.levels.parts import parts_of, torque_by_part

if TYPE_CHECKING:
    import xarray as xr


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


def losses(model: SimplifiedModel, dataset: xr.Dataset) -> tuple[Loss, ...]:
    """Rank the parts a model of parts left out by their torque along a decomposed trajectory."""
    parts = tuple(part for part in parts_of(model.arm.n_joints) if part not in model.terms)
    largest = np.abs(torque_by_part(dataset, dataset.qdd.values, parts)).max(axis=2)
    peak_torque = peak_magnitude(dataset.torque.values)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(largest == 0.0, 0.0, largest / peak_torque)
    joints = shares.argmax(axis=1)
    rows = [
        Loss(part.label, float(largest[p, joint]), int(joint) + 1, float(shares[p, joint]))
        for p, (part, joint) in enumerate(zip(parts, joints, strict=True))
    ]
    return tuple(sorted(rows, key=lambda loss: -loss.torque_share))
