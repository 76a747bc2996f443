"""Labels of an arm's elements: D12, h112, c2, and D1,10 where two digits would run together."""

from __future__ import annotations

from collections.abc import Container, Iterable


def joined(joints: Iterable[int]) -> str:
    """Write joints, which count from 0, the way labels have them, from 1.

    Examples
    --------
    >>> joined((0, 1)), joined((0, 9)), joined((9,))
    ('12', '1,10', '10')
    """
    numbers = [str(joint + 1) for joint in joints]
    return ("," if any(len(number) > 1 for number in numbers) else "").join(numbers)


def parted(index: str, n_joints: int, lengths: Container[int]) -> tuple[int, ...] | None:
    """Read what `joined` wrote; commas may also part one digit from the other.

    Parameters
    ----------
    index
        Digits and commas.
    n_joints
        Joints of the arm.
    lengths
        How many indices there may be.

    Returns
    -------
    tuple of int or None
        Joints, from 0; None where this names none, or could name several.

    Examples
    --------
    >>> parted("12", 10, {2}), parted("1,10", 10, {2}), parted("10", 10, {1}), parted("10", 9, {1})
    ((0, 1), (0, 9), (9,), None)
    """
    readings = {tuple(index.split(","))} | (set() if "," in index else {tuple(index)})
    found = {
        tuple(int(number) - 1 for number in reading)
        for reading in readings
        if len(reading) in lengths and all(number.isdecimal() for number in reading)
    }
    found = {joints for joints in found if all(0 <= joint < n_joints for joint in joints)}
    return found.pop() if len(found) == 1 else None


def inertia_label(i: int, j: int) -> str:
    """Label of an element of the symmetric matrix D; joints count from 0."""
    return f"D{joined(sorted((i, j)))}"


def shortened(name: str, most: int) -> str:
    """Leave out the middle of a name of more than so many characters; names differ at their ends.

    Examples
    --------
    >>> shortened("left_gripper_extension_joint_r", 16), shortened("elbow_joint", 16)
    ('left_gri…joint_r', 'elbow_joint')
    """
    if len(name) <= most:
        return name
    ends = max(most - 1, 2)
    return f"{name[: ends - ends // 2]}…{name[len(name) - ends // 2 :]}"


def joint_name(number: int, name: str) -> str:
    """A joint's number, and its name where that says more."""
    return name if name == str(number) else f"{number} {name}"
