"""The robot arm as a value: joints, links, drives and gravity, valid once it exists.

From link frame i-1 a constant `Joint.placement` leads to the joint frame, whose origin is p_{i-1} and in
which the joint turns about (or slides along) `Joint.axis`; from there a constant `Link.frame` leads to link
frame i, in which the link's data are given.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from gd_analyze.arguments import strict
from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError
from gd_analyze.guesses import OF_ARM, guessing
from gd_analyze.robots.frames import CONVENTIONS
from gd_analyze.robots.parts import DHRow, Drive, Joint, Link, Placement, checked, is_sentence, require_name
from gd_analyze.text import amount, html_of, in_python, joint_name, pretty

Limit = Literal["lower", "upper", "velocity_limit", "acceleration_limit"]


# Gravity in the base frame of a level arm, m/s^2.
USUAL_GRAVITY = (0.0, 0.0, -9.8062)


@dataclass(frozen=True, eq=False)
class RobotArm:
    """A serial arm of n joints.

    Parameters
    ----------
    name, title
        Short identifier and display name.
    joints, links
        n of each; link i moves with joint i.
    gravity_vector
        g in the base frame, m/s^2; a level arm has `USUAL_GRAVITY`.
    drives
        One per joint, or empty.
    dh_table, convention
        The Denavit-Hartenberg table the arm was built from, "standard" or "modified"; empty, "placement",
        when it was built otherwise.
    sources, assumptions
        Origin of the numbers, and those that are not published.
    doubts
        Implausible numbers found when the arm was read, a sentence each; every use of the arm warns of them.
    tip, tip_frame
        The last link asked for, and its frame (of a payload) relative to that of the last moving link.
    ends
        Bodies that the file names beyond the last joint, each with all that it carries, in the last link's
        frame: they are part of the last link, and may be missing on the robot.
    spread
        For an identified arm: factor S of the covariance S^T S of the links' `PARAMETERS` and, last, the
        drives' inertia, shape (k, n, 11). It replaces the links' and drives' own uncertainties.

    Raises
    ------
    ArmError
        If a number is impossible, a text not printable, or the lists differ in length.
    """

    name: str
    joints: tuple[Joint, ...]
    links: tuple[Link, ...]
    gravity_vector: FloatArray = field(default_factory=lambda: np.array(USUAL_GRAVITY))
    title: str = ""
    drives: tuple[Drive, ...] = ()
    dh_table: tuple[DHRow, ...] = ()
    convention: Literal["standard", "modified", "placement"] = "placement"
    sources: tuple[str, ...] = ()
    assumptions: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    tip: str = ""
    tip_frame: Placement = field(default_factory=Placement)
    ends: tuple[Link, ...] = ()
    spread: FloatArray | None = None

    def __post_init__(self) -> None:
        where = f"arm {self.name}"
        for name in ("name", "title"):
            require_name(getattr(self, name), f"an arm's {name}", where)
        if self.convention not in (*CONVENTIONS, "placement"):
            message, words = "the arm has an unknown convention", ", ".join(CONVENTIONS)
            value_text = in_python(self.convention)
            raise ArmError(message, where=where, expected=f"{words}, placement", found=value_text)
        for text in (*self.sources, *self.assumptions, *self.doubts):
            if not is_sentence(text):
                message, value_text = "a source, an assumption or a doubt is not printable", in_python(text)
                raise ArmError(
                    message, where=where, expected="text without control characters", found=value_text
                )
        object.__setattr__(
            self, "gravity_vector", checked(self.gravity_vector, (3,), f"gravity of {where}", where)
        )
        if not self.joints:
            raise ArmError(f"{where} has no joints", expected="at least one joint")
        n = len(self.joints)
        for noun, items in (("links", self.links), ("drives", self.drives), ("table rows", self.dh_table)):
            if len(items) != n and (items or noun == "links"):
                message, count_text = f"{where} needs as many {noun} as joints", str(len(items))
                raise ArmError(message, where=where, expected=f"{n} {noun}", found=count_text)
        if self.spread is not None:
            shape = (len(self.spread), n, 11)
            object.__setattr__(self, "spread", checked(self.spread, shape, f"spread of {where}", where))
        for index, link in enumerate(self.links):
            if link.axial_only and (index > 0 or self.joints[0].kind != "revolute"):
                message = f"link {link.name} states its inertia about the joint axis only"
                expected = "this only for the first link, behind a revolute joint"
                raise ArmError(
                    message, where=link.place, expected=expected, next_step="state the full inertia"
                )

    if not TYPE_CHECKING:  # checkers are to refuse unknown names
        __getattr__ = guessing(OF_ARM)

    def __repr__(self) -> str:
        return f"RobotArm({self.name!r}, {self.n_joints} joints{', drives' if self.drives else ''})"

    def _repr_html_(self) -> str:
        """Joints, links and drives, for a notebook."""
        headings = ["joint", "kind", "range", "velocity limit", "mass of link"]
        rows = [
            [joint_name(i, joint.name), joint.kind, *_limits_text(joint), amount(link.mass, "kg")]
            for i, (joint, link) in enumerate(zip(self.joints, self.links, strict=True), start=1)
        ]
        if self.drives:
            headings.append("drive at the joint")
            for row, drive, revolute in zip(rows, self.drives, self.is_revolute, strict=True):
                row.append(pretty(amount(drive.inertia, "kg m^2" if revolute else "kg")))
        g = ", ".join(f"{x:g}" for x in self.gravity_vector)
        return html_of(self.title or self.name, headings, rows, f"{self!r}; gravity ({g}) m/s^2")

    @property
    def n_joints(self) -> int:
        """Number of joints n."""
        return len(self.joints)

    @property
    def n(self) -> int:
        """Number of joints n, the short name that other robotics libraries have."""
        return self.n_joints

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in their order."""
        return tuple(joint.name for joint in self.joints)

    @cached_property
    def reach(self) -> float:
        """Upper bound on the distance from the first joint to the last link frame, m."""
        slides = [joint for joint in self.joints if joint.kind == "prismatic"]
        travel = sum(max(abs(joint.lower or 0.0), abs(joint.upper or 0.0)) for joint in slides)
        lengths = [np.linalg.norm(joint.placement.translation) for joint in self.joints[1:]]
        lengths += [np.linalg.norm(link.frame.translation) for link in self.links]
        return float(sum(lengths) + travel)

    @cached_property
    def mass(self) -> FloatArray:
        """Masses m_s, kg, shape (n,)."""
        return _read_only([link.mass for link in self.links])

    @cached_property
    def com(self) -> FloatArray:
        """Centres of mass in their link frames, m, shape (n, 3)."""
        return _read_only([link.com for link in self.links])

    @cached_property
    def inertia_com(self) -> FloatArray:
        """Inertias I_s about the centres of mass, in link frames, kg m^2, shape (n, 3, 3)."""
        return _read_only([link.inertia_com for link in self.links])

    @cached_property
    def is_revolute(self) -> tuple[bool, ...]:
        """Whether each joint is revolute."""
        return tuple(joint.kind == "revolute" for joint in self.joints)

    def limits(self, limit: Limit) -> FloatArray:
        """One limit of every joint, shape (n,); infinite (minus infinite for "lower") where unknown."""
        unknown = -np.inf if limit == "lower" else np.inf
        values = [getattr(joint, limit) for joint in self.joints]
        return np.array([unknown if value is None else value for value in values])

    @property
    def has_all_limits(self) -> bool:
        """Whether every joint states its range and its velocity and acceleration limits."""
        return all(np.isfinite(self.limits(limit)).all() for limit in get_args(Limit))

    def joint_number(self, word: str) -> int | None:
        """Number, from 0, of the joint given by its name or by its number from 1; None if there is none."""
        names = [joint.name for joint in self.joints]
        if word in names:
            return names.index(word)
        is_number = word.isascii() and word.isdigit() and 1 <= int(word[:9]) <= self.n_joints
        return int(word) - 1 if is_number else None

    @strict
    def counts_drives(self, drives: bool | None = None) -> bool:
        """Whether to include the drives' inertia: as `drives` says, or else if the arm describes any."""
        return any(drive.inertia > 0.0 for drive in self.drives) if drives is None else drives

    @cached_property
    def drive_inertia(self) -> FloatArray:
        """Drive inertia at the joints, kg m^2, shape (n,).

        Raises
        ------
        ArmError
            If the arm describes no drives.
        """
        if not self.drives:
            hint = "add one [[drives]] table per joint to the arm file, or ask for the links alone"
            raise ArmError(f"arm {self.name} describes no drives", where=f"arm {self.name}", next_step=hint)
        return _read_only([drive.inertia for drive in self.drives])


def _limits_text(joint: Joint) -> tuple[str, str]:
    """Range (revolute joints: in degrees) and velocity limit with units; a dash where unknown."""
    ends = [end for end in (joint.lower, joint.upper) if end is not None]
    scale, unit = (180 / math.pi, "°") if joint.kind == "revolute" else (1.0, "m")
    span = " .. ".join(f"{scale * end:.4g}" for end in ends)
    velocity = "–" if joint.velocity_limit is None else f"{joint.velocity_limit:.4g} {joint.unit}/s"
    return f"{span} {unit}" if len(ends) == 2 else "–", velocity


def _read_only(values: Sequence[float | FloatArray]) -> FloatArray:
    array = np.array(values, dtype=float)
    array.flags.writeable = False
    return array
