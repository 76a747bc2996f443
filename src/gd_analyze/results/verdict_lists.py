"""Elements listed by verdict, and joints whose torque mostly accelerates their drives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

# Lists in the order of reports; gravity loading that counts has one of its own.
LISTS = ("translation", "rotation", "both", "gravity", "drive", "negligible", "zero")
# Share of a joint's peak torque from which its drive makes most of it.
_LEAST_DRIVE_SHARE = 0.5


@dataclass(frozen=True)
class Listed:
    """One element in a list."""

    element: str  # label: "D12"
    dominant: str  # "translation", "rotation", "both" or "zero"
    torque_share: float  # of peak torque
    consequence: float  # of the torque error allowed


@dataclass(frozen=True)
class DriveShare:
    """The drive of one joint."""

    joint: int  # from 1
    element: str  # its place in D: "D44"
    share: float  # largest torque of the drive over the joint's peak torque


@dataclass(frozen=True)
class VerdictLists:
    """Elements by verdict, the largest torque first, and the drives that make most of a joint's torque."""

    lists: dict[str, tuple[Listed, ...]]  # by `LISTS`
    drives: tuple[DriveShare, ...]  # by joint

    def labels(self, verdict: str) -> list[str]:
        """Labels of the elements in a list."""
        return [row.element for row in self.lists[verdict]]


def verdict_lists(ranking: xr.Dataset) -> VerdictLists:
    """List the elements of a ranking by verdict.

    Parameters
    ----------
    ranking
        The result of `rank`; its verdicts are those over the motion.

    Returns
    -------
    VerdictLists
        Every element in one list. Elements are ordered by the torque of their links' parts as a share of peak
        torque, those of the drives by that of the drive.
    """
    columns = {str(name): values.values.tolist() for name, values in ranking.data_vars.items()}
    lists: dict[str, list[Listed]] = {name: [] for name in LISTS}
    drives = []
    for k, label in enumerate(ranking.element.values.tolist()):
        driven = columns["drive_torque_share"][k]
        verdict = columns["verdict"][k]
        share = driven if verdict == "drive" else columns["torque_share"][k]
        lists[verdict].append(Listed(label, columns["dominant"][k], share, columns["consequence"][k]))
        if driven > _LEAST_DRIVE_SHARE:
            drives.append(DriveShare(columns["i"][k], label, driven))
    lists["drive"].sort(key=lambda listed: -listed.torque_share)
    return VerdictLists(
        {name: tuple(listed) for name, listed in lists.items()},
        tuple(sorted(drives, key=lambda drive: drive.joint)),
    )
