"""The torque error a user allows, per joint: the larger of several amounts."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import NamedTuple, Self

import numpy as np

from gd_analyze.errors import UsageError
from gd_analyze.given_numbers import LARGEST, UNSIGNED
from gd_analyze.levels.yardsticks import Yardsticks
from gd_analyze.vectors import FloatArray
from gd_analyze.visible import in_python

# What an amount may be a share of, and how amounts are written.
_WHOLES = ("peak", "limit", "friction", "uncertainty")
_ALLOWANCE = re.compile(
    rf"(?P<number>{UNSIGNED})\s*(?P<unit>%|N ?m?)?"
    rf"(?:\s*(?:of\s+)?(?P<whole>{'|'.join(_WHOLES)}))?|(?P<name>{'|'.join(_WHOLES)})",
    re.IGNORECASE,
)
_OR = re.compile(r"\s+or\s+", re.IGNORECASE)


class Allowance(NamedTuple):
    """One torque error that is allowed.

    Parameters
    ----------
    amount
        A share (1 % is 0.01), or N m (N for a sliding joint).
    of
        What it is a share of: the joint's "peak" torque over the states, its torque "limit", its Coulomb
        "friction", or the "uncertainty" of its torque that follows from the parameters' stated ones;
        "torque" for N m.
    """

    amount: float
    of: str = "peak"

    @classmethod
    def parse(cls, text: str) -> Self | None:
        """Read "1%", "10% friction", "uncertainty" or "0.5 N m"; None where it is nothing of this kind."""
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


@dataclass(frozen=True)
class Budget:
    """Allowed torque error: one entry for all joints, or one each; the larger amount of an entry counts.

    Parameters
    ----------
    entries
        One or several allowances per entry; 1 % of peak torque by default.

    Raises
    ------
    UsageError
        If there is no entry, one of them is empty, or an amount is negative or not finite.
    """

    entries: tuple[tuple[Allowance, ...], ...] = ((Allowance(0.01),),)

    def __post_init__(self) -> None:
        if not self.entries or not all(self.entries):
            raise UsageError(
                "a budget allows nothing", where="Budget", expected="at least one amount per entry"
            )
        for amount, of in (allowance for entry in self.entries for allowance in entry):
            if not 0 <= amount < np.inf or of not in (*_WHOLES, "torque"):
                raise UsageError(
                    "a budget cannot be that",
                    where="Budget",
                    expected=f"0 or more, of {', '.join(_WHOLES)}, or torque",
                    found=f"{amount:g} of {of}",
                )

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read entries, separated by commas: amounts, separated by "or", of which the larger counts.

        An amount is a share of the joint's peak torque over the states ("1%"), of its torque limit ("0.5%
        limit"), of its Coulomb friction ("10% friction"), of its torque's uncertainty ("50% uncertainty", or
        all of it, "uncertainty"), or a torque ("0.05 N m", "0.05").

        Raises
        ------
        UsageError
            If an amount is none of these.

        Examples
        --------
        >>> str(Budget.parse("1% or 10% of friction, 0.2"))
        '1% or 10% friction, 0.2 N m'
        """
        entries = []
        for column, entry in enumerate(text.split(","), start=1):
            allowances = [
                Allowance.parse(words) for words in re.split(r"\s+or\s+", entry, flags=re.IGNORECASE)
            ]
            if None in allowances:
                raise _not_understood(entry, column)
            entries.append(tuple(allowance for allowance in allowances if allowance is not None))
        return cls(tuple(entries))

    @classmethod
    def of(cls, given: Self | str | None) -> Self:
        """Take a budget as users of the library give it: itself, its text, or None for the usual 1 %."""
        if given is None:
            return cls()
        if isinstance(given, str):
            return cls.parse(given)
        if isinstance(given, cls):
            return given
        raise UsageError(
            "this is no budget",
            where="budget",
            expected='a Budget, or its text: "1%" of peak torque, "0.5" N m, or "1% or 10% friction"',
            found=in_python(given),
        )

    @classmethod
    def of_torques(cls, amounts: Iterable[float]) -> Self:
        """Allow these torques, N m (N), of the joints."""
        return cls(tuple((Allowance(float(amount), "torque"),) for amount in amounts))

    @property
    def wholes(self) -> frozenset[str]:
        """What its amounts are shares of; "torque" among them for N m."""
        return frozenset(allowance.of for entry in self.entries for allowance in entry)

    @property
    def shares_of(self) -> str:
        """What errors under it are told as shares of: "peak torque" where it is one, or "allowed error"."""
        return "peak torque" if self.wholes == {"peak"} else "allowed error"

    def of_joints(self, count: int) -> Sequence[tuple[Allowance, ...]]:
        """One entry per joint.

        Raises
        ------
        UsageError
            If there are several entries, but not one per joint.
        """
        if len(self.entries) not in (1, count):
            raise UsageError(
                "the budget has a wrong number of entries",
                where="--budget",
                expected=f"1 or {count}",
                found=str(len(self.entries)),
            )
        return self.entries * count if len(self.entries) == 1 else self.entries

    def allowed(self, by: Yardsticks) -> FloatArray:
        """Allowed error of each joint, N m, shape (n,).

        Raises
        ------
        UsageError
            If there are several entries, but not one per joint, or an amount is a share of what the arm does
            not state.
        """
        return np.array(
            [
                max(amount if of == "torque" else amount * by.of(of, joint) for amount, of in entry)
                for joint, entry in enumerate(self.of_joints(by.arm.n_joints))
            ]
        )

    def scaled(self, factor: float) -> Budget:
        """The same budget, every amount times a factor."""
        return Budget(
            tuple(tuple(Allowance(factor * a.amount, a.of) for a in entry) for entry in self.entries)
        )

    def __str__(self) -> str:
        return ", ".join(" or ".join(map(str, entry)) for entry in self.entries)


def _not_understood(entry: str, column: int) -> UsageError:
    """The error for an entry of a budget, with the word that was likely meant where one is misspelt."""
    likely = [
        matches[0]
        for word in re.findall(r"[a-z]{3,}", entry.lower())
        if word not in _WHOLES and (matches := get_close_matches(word, _WHOLES, n=1))
    ]
    return UsageError(
        "the budget is not understood",
        where=f"--budget, entry {column}",
        expected="a share of peak torque such as 1%, N m such as 0.5, or the larger of several "
        f'such as "1% or 10% friction" (or limit, uncertainty); up to {LARGEST:g}',
        found=repr(entry.strip()),
        next_step=f"did you mean {likely[0]}?" if likely else None,
    )
