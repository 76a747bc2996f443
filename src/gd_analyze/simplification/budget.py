"""The allowed torque error: per joint the largest of several amounts, or a share of the norm."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.drivetrain import least_friction
from gd_analyze.errors import UsageError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import LARGEST, UNSIGNED, in_python

# References of shares, and the syntax of amounts.
_WHOLES = ("peak", "limit", "friction", "uncertainty")
_ALLOWANCE = re.compile(
    rf"(?P<number>{UNSIGNED})\s*(?P<unit>%|N ?m?)?"
    rf"(?:\s*(?:of\s+)?(?P<whole>{'|'.join(_WHOLES)}))?|(?P<name>{'|'.join(_WHOLES)})",
    re.IGNORECASE,
)
_OR = re.compile(r"\s+or\s+", re.IGNORECASE)
_NORM = re.compile(
    rf"(?P<share>{UNSIGNED})\s*%\s*(?:of\s+(?:the\s+)?)?norm"
    rf"(?:\s+at\s+(?:all|every|(?P<states>{UNSIGNED})\s*%)(?:\s+(?:of\s+(?:the\s+)?)?states?)?)?",
    re.IGNORECASE,
)
# Keys to state in an arm file, by the reference of a share.
_TO_STATE = {
    "limit": "`torque_limit` in the joint's [[drives]] table",
    "friction": "`coulomb` in the joint's [[drives]] table, for both directions",
    "uncertainty": "`mass_uncertainty`, `com_uncertainty` or `inertia_uncertainty` of the links",
}
_FOR_TRACKING = "`gd-analyze simplify` takes a tracking error, along one motion"
# Shares of the states for which PSDM (Lloyd, Irani, Ahmadi 2021) states its error of the norm.
USUAL_STATES = (0.95, 0.999)


@dataclass(frozen=True, eq=False)
class ReferenceTorques:
    """References of a budget's shares at each joint of an arm, N m (N for a prismatic joint)."""

    arm: RobotArm  # states torque limits and friction
    peak: FloatArray  # largest magnitude of the exact torque, (n,)
    uncertainty: FloatArray | None = None  # largest standard uncertainty of the torque, (n,), if stated

    def of(self, name: str, joint: int, option: str = "--budget") -> float:
        """One of `_WHOLES` at a joint, from 0; a UsageError naming `option` if the arm does not state it."""
        value = float(self.all(name)[joint])
        if np.isnan(value):
            what = f"a budget cannot be a share of {name}, as the arm states none"
            where = f"{option}, joint {joint + 1}, {self.arm.joints[joint].name}, of {self.arm.name}"
            next_step = f"state it in the arm file, or give one entry per joint, this one without {name}"
            raise UsageError(what, where=where, expected=_TO_STATE[name], next_step=next_step)
        return value

    def all(self, name: str) -> FloatArray:
        """One of `_WHOLES` at every joint, shape (n,); nan if the arm does not state it."""
        if name == "peak":
            return self.peak
        if name == "uncertainty" and self.uncertainty is not None:
            return self.uncertainty
        if name == "uncertainty" or not self.arm.drives:
            return np.full(self.arm.n_joints, np.nan)
        if name == "friction":
            level = least_friction(self.arm)
            return np.where(level > 0.0, level, np.nan)
        return np.array([np.nan if d.torque_limit is None else d.torque_limit for d in self.arm.drives])


class Allowance(NamedTuple):
    """One allowed torque error."""

    amount: float  # a share (1 % is 0.01), or N m (N for a prismatic joint)
    of: str = "peak"  # one of `_WHOLES`; "torque" for N m

    @classmethod
    def parse(cls, text: str) -> Self | None:
        """Read "1%", "10% friction", "uncertainty" or "0.5 N m"; None for any other text."""
        match = _ALLOWANCE.fullmatch(text.strip())
        if match is None:
            return None
        if match["name"]:
            return cls(1.0, match["name"].lower())
        number, is_share = float(match["number"]), match["unit"] == "%"
        if number > LARGEST or (match["whole"] and not is_share):
            return None
        return cls(number / 100, (match["whole"] or "peak").lower()) if is_share else cls(number, "torque")

    def __str__(self) -> str:
        if self.of == "torque":
            return f"{self.amount:g} N m"
        share = f"{self.amount * 100:g}%"
        if self.of == "peak":
            return share
        return self.of if share == "100%" else f"{share} {self.of}"


class NormShare(NamedTuple):
    """An error allowed to all joints together: norm of the torque error over norm of the torque."""

    share: float  # 1 % is 0.01
    states: float = 1.0  # share of the states that must keep it, above 0; 1 for all

    @classmethod
    def parse(cls, text: str) -> Self | None:
        """Read "1% norm" or "1% of norm at 95% of states"; None for any other text."""
        match = _NORM.fullmatch(text.strip())
        if match is None:
            return None
        share, states = float(match["share"]), float(match["states"] or 100.0)
        if share > LARGEST or not 0.0 < states <= 100.0:
            return None
        return cls(share / 100, round(states / 100, 15))  # 99.9 / 100 differs from 0.999 in the last digits

    def __str__(self) -> str:
        where = "all states" if self.states == 1.0 else f"{self.states * 100:.12g}% of states"
        return f"{self.share * 100:.12g}% norm at {where}"


@dataclass(frozen=True)
class Budget:
    """Allowed torque error: one entry for all joints, or one each; the largest amount of an entry counts.

    Parameters
    ----------
    entries
        One or several allowances per entry; by default 1 % of peak torque. Empty with a norm.
    norm
        Error allowed to all joints together, in place of entries.
    option
        Name of the option, for messages.

    Raises
    ------
    UsageError
        If there is no entry, one of them is empty, or an amount is negative or not finite.
    """

    entries: tuple[tuple[Allowance, ...], ...] = ((Allowance(0.01),),)
    norm: NormShare | None = None
    option: str = field(default="--budget", compare=False, repr=False)

    def __post_init__(self) -> None:
        norm, of_any = self.norm, (*_WHOLES, "torque")
        if norm is not None:
            possible = not self.entries and 0.0 <= norm.share < np.inf and 0.0 < norm.states <= 1.0
        else:
            amounts = [allowance for entry in self.entries for allowance in entry]
            possible = bool(amounts) and all(self.entries)
            possible &= all(0.0 <= amount < np.inf and of in of_any for amount, of in amounts)
        if not possible:
            expected = (
                f"one or more entries, each amounts of 0 or more, of {', '.join(_WHOLES)}, or torque; or none"
            )
            expected += " and a share of the norm of 0 or more, of the states above 0 and up to 1"
            found = f"{self.entries!r}, norm {norm!r}"
            raise UsageError("this is not a budget", where="Budget", expected=expected, found=found)

    @classmethod
    def parse(cls, text: str, option: str = "--budget") -> Self:
        """Read entries separated by commas: amounts separated by "or", of which the largest counts.

        An amount is a share of the joint's peak torque over the states ("1%"), of its torque limit ("0.5%
        limit"), of its Coulomb friction ("10% friction"), of its torque's uncertainty ("50% uncertainty", or
        all of it, "uncertainty"), or a torque ("0.05 N m", "0.05"). Alternatively, alone, a share of the norm
        of all joints' torque, with the share of states that keep it ("1% norm at 95% of states", "1% norm").

        Raises
        ------
        UsageError
            If an amount is not understood.

        Examples
        --------
        >>> str(Budget.parse("1% or 10% of friction, 0.2"))
        '1% or 10% friction, 0.2 N m'
        """
        if re.search(r"\bnorm\b", text, re.IGNORECASE):
            norm = NormShare.parse(text)
            if norm is None:
                next_step = "give a single entry, with more than 0 and up to 100 % of the states"
                raise _not_understood(text, option, next_step)
            return cls((), norm, option)
        entries = []
        for column, entry in enumerate(text.split(","), start=1):
            allowances = [Allowance.parse(words) for words in _OR.split(entry)]
            if None in allowances:
                raise _not_understood(entry, f"{option}, entry {column}")
            entries.append(tuple(allowance for allowance in allowances if allowance is not None))
        return cls(tuple(entries), option=option)

    @classmethod
    def of(cls, given: Self | str | None) -> Self:
        """Take a Budget, its text, or None for 1 %."""
        if given is None:
            return cls()
        if isinstance(given, str):
            return cls.parse(given)
        if isinstance(given, cls):
            return given
        expected = 'a Budget, or its text: "1%" of peak torque, "0.5" N m, or "1% or 10% friction"'
        raise UsageError("this is not a budget", where="budget", expected=expected, found=in_python(given))

    @classmethod
    def of_torques(cls, amounts: Iterable[float]) -> Self:
        """Allow these torques, N m (N), of the joints."""
        return cls(tuple((Allowance(float(amount), "torque"),) for amount in amounts))

    @property
    def wholes(self) -> frozenset[str]:
        """References of its shares; "torque" stands for N m, and "norm" is alone."""
        if self.norm is not None:
            return frozenset({"norm"})
        return frozenset(allowance.of for entry in self.entries for allowance in entry)

    @property
    def shares_of(self) -> str:
        """Reference of errors when shown: "peak torque" for a share of it, otherwise "allowed error"."""
        return "peak torque" if self.wholes in ({"peak"}, {"norm"}) else "allowed error"

    def require_per_joint(self, what: str, next_step: str | None = None) -> Self:
        """Raise a UsageError for a budget of the norm, if `what` needs one for every joint."""
        if self.norm is not None:
            what += " is not possible with a budget of the norm"
            found = f'"{self}", which is for all joints together'
            expected = 'an error allowed at each joint, such as "1%" or "1% or 10% friction"'
            raise UsageError(what, where=self.option, expected=expected, found=found, next_step=next_step)
        return self

    def of_joints(self, count: int) -> Sequence[tuple[Allowance, ...]]:
        """One entry per joint; a UsageError if there are neither one nor as many as joints."""
        if len(self.entries) not in (1, count):
            what, found = "the budget has the wrong number of entries", str(len(self.entries))
            raise UsageError(what, where=self.option, expected=f"1 or {count}", found=found)
        return self.entries * count if len(self.entries) == 1 else self.entries

    def allowed(self, by: ReferenceTorques) -> FloatArray:
        """Allowed error of each joint, N m, shape (n,).

        A share of the norm is not per joint. It then gives that share of the norm of the peak torques of
        joints of the same kind: no state that keeps the budget has a larger error.

        Raises
        ------
        UsageError
            If there are neither one nor as many entries as joints, or an amount is a share of a number that
            the arm does not state.
        """
        if self.norm is not None:
            alike = np.equal.outer(by.arm.is_revolute, by.arm.is_revolute)
            return np.asarray(self.norm.share * np.sqrt(alike @ by.peak**2))

        def largest(joint: int, entry: tuple[Allowance, ...]) -> float:
            return max(a if of == "torque" else a * by.of(of, joint, self.option) for a, of in entry)

        return np.array([largest(*each) for each in enumerate(self.of_joints(by.arm.n_joints))])

    def scaled(self, factor: float) -> Budget:
        """The same budget, every amount times a factor."""
        if self.norm is not None:
            return Budget((), self.norm._replace(share=factor * self.norm.share))
        return Budget(
            tuple(tuple(Allowance(factor * a.amount, a.of) for a in entry) for entry in self.entries)
        )

    def __str__(self) -> str:
        if self.norm is not None:
            return str(self.norm)
        return ", ".join(" or ".join(map(str, entry)) for entry in self.entries)


def _not_understood(text: str, where: str, next_step: str | None = None) -> UsageError:
    """Error for a budget or an entry, with the likely word if one is misspelt."""
    words = (word for word in re.findall(r"[a-z]{3,}", text.lower()) if word not in _WHOLES)
    likely = [match for word in words for match in get_close_matches(word, (*_WHOLES, "norm"), n=1)]
    return UsageError(
        "the budget is not understood",
        where=where,
        expected='1% of peak torque, 0.5 N m, "10% friction" (or limit, uncertainty), the larger of several '
        f'"1% or 10% friction", all up to {LARGEST:g}; or "1% norm at 95% of states"',
        found=repr(text.strip()),
        next_step=_FOR_TRACKING
        if text.strip().lower().startswith("tracking")
        else next_step or (f"did you mean {likely[0]}?" if likely else None),
    )


@dataclass(frozen=True, eq=False)
class NormMeasure:
    """Norm of the torque error over that of the torque, for joints of each kind; the larger share counts."""

    allowed: float  # share of the norm
    states: float  # share of the states that must keep it; errors of the others are unlimited
    torque: FloatArray  # exact, (n, N), N m (N)
    revolute: NDArray[np.bool_]  # (n,)
    round_off: float = 0.0  # errors up to this, N m, count as zero

    @cached_property
    def norms(self) -> FloatArray:
        """Norm of the torque of the revolute joints, and of the prismatic ones, shape (1 or 2, N)."""
        return self._norms_of(self.torque)

    @cached_property
    def group(self) -> NDArray[np.intp]:
        """Index of each joint's norm, shape (n,)."""
        return np.unique(~self.revolute, return_inverse=True)[1]

    @property
    def exempt(self) -> int:
        """Number of states that may exceed the budget."""
        count = self.torque.shape[1]
        return count - kept_states(self.states, count)

    def shares(self, error: FloatArray) -> FloatArray:
        """Share of the norm at every state, shape (N,); infinite for an error without torque."""
        counting = np.where(np.abs(error) <= self.round_off, 0.0, error)
        with np.errstate(divide="ignore", invalid="ignore"):
            each = self._norms_of(counting) / self.norms
        return np.where(np.isnan(each), 0.0, each).max(axis=0)

    def share(self, error: FloatArray) -> float:
        """Smallest share that enough states keep, over the allowed one; the budget is kept up to 1."""
        least = share_at(self.shares(error), self.states)
        if self.allowed > 0.0:
            return least / self.allowed
        return math.inf if least > 0.0 else 0.0

    def _norms_of(self, torque: FloatArray) -> FloatArray:
        groups = range(int(self.group.max()) + 1)
        return np.array([np.linalg.norm(torque[self.group == g], axis=0) for g in groups])


def kept_states(share: float, count: int) -> int:
    """Least number of states that make a share of `count`: 95 % of 4000 are 3800."""
    # 0.95 and products with it are rounded: a number that is whole up to rounding is whole.
    return min(math.ceil(round(share * count, 6)), count)


def share_at(shares: FloatArray, states: float) -> float:
    """Smallest share of the norm that this share of the states keeps, from shares (N,)."""
    last = kept_states(states, len(shares)) - 1
    return float(np.partition(shares, last)[last])
