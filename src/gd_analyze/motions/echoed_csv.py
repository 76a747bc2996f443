"""What `ros2 topic echo --csv` prints of JointState: no header, but the joints' names in every row."""

from __future__ import annotations

import re
from collections.abc import Sequence

_INTEGER = re.compile(r"[0-9]{1,19}")
_FIELDS = ("position", "velocity", "effort")


def echoed_names(cells: Sequence[str], are_numbers: Sequence[bool]) -> tuple[str, ...] | None:
    """Names of the columns: seconds, nanoseconds, frame, the joints' names, and what is given of each.

    Parameters
    ----------
    cells
        Of the first row.
    are_numbers
        Whether each of them is a number.

    Returns
    -------
    tuple of str or None
        None of a row that is none of these. An empty list in the message is an empty cell.

    Examples
    --------
    >>> echoed_names(["0", "8", "", "hip", "0.1", "", "3.5"], [True, True, False, False, True, False, True])
    ('header/stamp/sec', 'header/stamp/nanosec', '', '', 'hip/position', '', 'hip/effort')
    """
    if len(cells) < 5 or not all(_INTEGER.fullmatch(cell) for cell in cells[:2]) or are_numbers[2]:
        return None
    joints = []
    for cell, number in zip(cells[3:], are_numbers[3:], strict=True):
        if number or not cell:
            break
        joints.append(cell)
    names = ["header/stamp/sec", "header/stamp/nanosec", "", *([""] * len(joints))]
    fields = 0
    while joints and len(names) < len(cells) and fields < len(_FIELDS):
        if not cells[len(names)]:
            names.append("")
        else:
            names += [f"{joint}/{_FIELDS[fields]}" for joint in joints]
        fields += 1
    return tuple(names) if joints and len(names) == len(cells) else None
