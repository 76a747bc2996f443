"""The allowed torque error of each joint: the largest of several amounts."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from numbers import Real
from typing import NamedTuple, Self

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.drivetrain import least_friction
from gd_analyze.errors import UsageError, require_type
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import LARGEST, in_python
from gd_analyze.units import Quantity

# References of shares.
# Multiples of a budget at which other models are shown beside its own.
BUDGET_FACTORS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)

_WHOLES = ("peak", "limit", "friction", "uncertainty", "log")
_UNITS = {"torque": "N m", "force": "N"}
_OR = re.compile(r"\s+or\s+", re.IGNORECASE)
# Keys to state in an arm file, by the reference of a share.
_TO_STATE = {
    "limit": "`torque_limit` in the joint's [[drives]] table",
    "friction": "`coulomb` in the joint's [[drives]] table, for both directions",
    "uncertainty": "`mass_uncertainty`, `com_uncertainty` or `inertia_uncertainty` of the links",
}
_NO_LOG = "there are no measured torques to take a budget from"
_FOR_EXAMPLE = 'give amounts of 0 or more, for example 1%, 0.5 (N m) or "1% or 10% friction"'


@dataclass(frozen=True, eq=False)
class ReferenceTorques:
    """References of a budget's shares at each joint of an arm, N m (N for a prismatic joint)."""

    arm: RobotArm  # states torque limits and friction
    peak: FloatArray  # largest magnitude of the exact torque, (n,)
    uncertainty: FloatArray | None = None  # largest standard uncertainty of the torque, (n,), if stated
    log: FloatArray | None = None  # RMS of what a log's torques leave, see `LogResolution.left`, (n,)

    def of(self, name: str, joint: int, argument: str = "budget") -> float:
        """One of `_WHOLES` at a joint, from 0; a UsageError for `argument` if the arm does not state it."""
        value = float(self.all(name)[joint])
        if np.isnan(value) and name == "log":
            next_step = "simplify along a log with measured torques, or take another budget such as 1%"
            raise UsageError(_NO_LOG, where=argument, next_step=next_step)
        if np.isnan(value):
            message = f"a budget cannot be a share of {name}, as the arm states none"
            where = f"{argument}, joint {joint + 1}, {self.arm.joints[joint].name}, of {self.arm.name}"
            next_step = f"state it in the arm file, or give one entry per joint, this one without {name}"
            raise UsageError(message, where=where, expected=_TO_STATE[name], next_step=next_step)
        return value

    def all(self, name: str) -> FloatArray:
        """One of `_WHOLES` at every joint, shape (n,); nan if the arm does not state it."""
        given = {"peak": self.peak, "uncertainty": self.uncertainty, "log": self.log}
        value = given.get(name)
        if value is not None:
            return value
        if name in given or not self.arm.drives:
            return np.full(self.arm.n_joints, np.nan)
        if name == "friction":
            level = least_friction(self.arm)
            return np.where(level > 0.0, level, np.nan)
        return np.array([np.nan if d.torque_limit is None else d.torque_limit for d in self.arm.drives])


class Allowance(NamedTuple):
    """One allowed torque error."""

    amount: float  # a share (1 % is 0.01), or N m (N for a prismatic joint)
    of: str = "peak"  # one of `_WHOLES`; "torque" for N m, "force" for N of joints that slide

    @classmethod
    def parse(cls, text: str) -> Self | None:
        """Read "1%", "10% friction", "uncertainty" or "0.5 N m"; None for any other text."""
        if text.strip().lower() in _WHOLES:
            return cls(1.0, text.strip().lower())
        quantity = Quantity.parse(text)
        if quantity is None or not 0.0 <= quantity.si <= LARGEST:
            return None
        if quantity.kind == "share":
            whole = quantity.of or "peak"
            return cls(quantity.si, whole) if whole in _WHOLES else None
        if quantity.kind == "force":
            return cls(quantity.si, "force")
        return cls(quantity.si, "torque") if quantity.kind in ("", "torque") else None

    def __str__(self) -> str:
        if self.of in _UNITS:
            return f"{self.amount:g} {_UNITS[self.of]}"
        share = f"{self.amount * 100:g}%"
        if self.of == "peak":
            return share
        return self.of if share == "100%" else f"{share} {self.of}"


@dataclass(frozen=True)
class Budget:
    """Allowed torque error: one entry for all joints, or one each; the largest amount of an entry counts.

    Parameters
    ----------
    entries
        One or several allowances per entry; by default 1 % of peak torque.
    argument
        Name of the argument, for messages.

    Raises
    ------
    UsageError
        If there is no entry, one of them is empty, or an amount is negative or not finite.
    """

    entries: tuple[tuple[Allowance, ...], ...] = ((Allowance(0.01),),)
    argument: str = field(default="budget", compare=False, repr=False)

    def __post_init__(self) -> None:
        of_any = (*_WHOLES, *_UNITS)
        amounts = [allowance for entry in self.entries for allowance in entry]
        possible = bool(amounts) and all(self.entries)
        possible &= all(0.0 <= amount < np.inf and of in of_any for amount, of in amounts)
        if not possible:
            expected = f"one or more entries, each amounts of 0 or more, of {', '.join(_WHOLES)}, or torque"
            raise UsageError(
                "this is not a budget", where="Budget", expected=expected, found=repr(self.entries)
            )

    @classmethod
    def parse(cls, text: str, argument: str = "budget") -> Self:
        """Read entries separated by commas: amounts separated by "or", of which the largest counts.

        An amount is a share of the joint's peak torque over the states ("1%"), of its torque limit ("0.5%
        limit"), of its Coulomb friction ("10% friction"), of its torque's uncertainty ("50% uncertainty", or
        all of it, "uncertainty"), of what a log leaves of its torque ("log"), or a torque ("0.05 N m",
        "0.05").

        Raises
        ------
        UsageError
            If an amount is not understood.

        Examples
        --------
        >>> str(Budget.parse("1% or 10% of friction, 0.2"))
        '1% or 10% friction, 0.2 N m'
        """
        require_type(text, str, argument, 'a text such as "1%" or "1% or 10% friction"')
        if re.search(r"\bnorm\b", text, re.IGNORECASE):
            raise UsageError(
                "a budget is allowed to every joint, not to the norm of all",
                where=argument,
                expected='an error allowed at each joint, such as "1%" or "1% or 10% friction"',
                found=repr(text.strip()),
                next_step="give a budget per joint: the norms of its model's error are reported",
            )
        entries = []
        for column, entry in enumerate(text.split(","), start=1):
            allowances = [Allowance.parse(words) for words in _OR.split(entry)]
            if None in allowances:
                raise _not_understood(entry, f"{argument}, entry {column}")
            entries.append(tuple(allowance for allowance in allowances if allowance is not None))
        return cls(tuple(entries), argument=argument)

    @classmethod
    def of(cls, budget: Self | str | float | None, argument: str = "budget") -> Self:
        """Take a Budget, its text, a number as a share of peak torque, or None for 1 %."""
        if budget is None:
            return cls(argument=argument)
        if isinstance(budget, str):
            return cls.parse(budget, argument)
        if isinstance(budget, cls):
            return budget
        if isinstance(budget, Real) and not isinstance(budget, bool) and 0.0 <= budget <= 1.0:
            return cls(((Allowance(float(budget)),),), argument)
        raise UsageError(
            "this is not a budget",
            where=argument,
            expected='a share of peak torque from 0 to 1, or a text: "1%", "0.5 N m", "1% or 10% friction"',
            found=in_python(budget),
        )

    @classmethod
    def of_torques(cls, amounts: Iterable[float]) -> Self:
        """Allow these torques, N m (N), of the joints."""
        return cls(tuple((Allowance(float(amount), "torque"),) for amount in amounts))

    @property
    def wholes(self) -> frozenset[str]:
        """References of its shares; "torque" stands for N m."""
        return frozenset(allowance.of for entry in self.entries for allowance in entry)

    @property
    def words(self) -> str:
        """Its text; of shares of what a log leaves that differ by joint, the smallest and the largest."""
        if self.wholes != {"log"} or len(self.entries) == 1:
            return str(self)
        shares = [100.0 * max(allowance.amount for allowance in entry) for entry in self.entries]
        return f"{min(shares):g} to {max(shares):g} % of the log's residual with fitted links"

    @property
    def shares_of(self) -> str:
        """Reference of errors when shown: "peak torque" for a share of it, otherwise "the budget"."""
        return "peak torque" if self.wholes == {"peak"} else "the budget"

    def of_joints(self, count: int) -> Sequence[tuple[Allowance, ...]]:
        """One entry per joint; a UsageError if there are neither one nor as many as joints."""
        if len(self.entries) not in (1, count):
            raise UsageError(
                "the budget has the wrong number of entries",
                where=self.argument,
                expected=f"1 or {count}",
                found=str(len(self.entries)),
                next_step=f"give one entry for all joints, or {count} separated by commas, one per joint",
            )
        return self.entries * count if len(self.entries) == 1 else self.entries

    def allowed(self, by: ReferenceTorques) -> FloatArray:
        """Allowed error of each joint, N m, shape (n,).

        Raises
        ------
        UsageError
            If there are neither one nor as many entries as joints, or an amount is a share of a number that
            the arm does not state.
        """

        def largest(joint: int, entry: tuple[Allowance, ...]) -> float:
            amounts = [(a, of) for a, of in entry if of != "force" or not by.arm.is_revolute[joint]]
            if not amounts:
                raise UsageError(
                    "the budget of a joint that turns is a force",
                    where=f"{self.argument}, joint {joint + 1}, {by.arm.joints[joint].name}",
                    expected="a torque such as 0.5 N m, or a share such as 1%",
                    found=" or ".join(map(str, entry)),
                    next_step="give one entry per joint, or both, such as '0.5 N m or 5 N'",
                )
            return max(a if of in _UNITS else a * by.of(of, joint, self.argument) for a, of in amounts)

        entries = self.of_joints(by.arm.n_joints)
        return np.array([largest(joint, entry) for joint, entry in enumerate(entries)])

    def scaled(self, factor: float) -> Budget:
        """The same budget, every amount times a factor."""
        return Budget(
            tuple(tuple(Allowance(factor * a.amount, a.of) for a in entry) for entry in self.entries)
        )

    def scaled_of(self, whole: str, factors: FloatArray) -> Budget:
        """The same budget, its shares of one of `_WHOLES` times a factor of each joint, shape (n,)."""
        entries = tuple(
            tuple(Allowance(factor * a.amount, a.of) if a.of == whole else a for a in entry)
            for factor, entry in zip(factors.tolist(), self.of_joints(len(factors)), strict=True)
        )
        return Budget(entries[:1] if len(set(entries)) == 1 else entries, self.argument)

    def __str__(self) -> str:
        return ", ".join(" or ".join(map(str, entry)) for entry in self.entries)


def _not_understood(text: str, where: str) -> UsageError:
    """Error for a budget or an entry, with the likely word if one is misspelt, or else examples."""
    words = (word for word in re.findall(r"[a-z]{3,}", text.lower()) if word not in _WHOLES)
    likely = [match for word in words for match in get_close_matches(word, _WHOLES, n=1)]
    return UsageError(
        "the budget is not understood",
        where=where,
        expected='1% of peak torque, 0.5 N m, "10% friction" (or limit, uncertainty, log), the larger of '
        f'several "1% or 10% friction", all up to {LARGEST:g}',
        found=repr(text.strip()),
        next_step=f"did you mean {likely[0]}?" if likely else _FOR_EXAMPLE,
    )
