"""The torque error a user allows, per joint."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from gd_analyze.errors import UsageError
from gd_analyze.given_numbers import LARGEST, UNSIGNED
from gd_analyze.vectors import FloatArray


@dataclass(frozen=True)
class Budget:
    """Allowed torque error: a share of each joint's peak torque, or N m; one entry, or one per joint.

    Parameters
    ----------
    amounts
        Shares (1 % is 0.01) or N m (N for a sliding joint).
    is_share
        Whether each amount is a share of peak torque.
    """

    amounts: tuple[float, ...] = (0.01,)
    is_share: tuple[bool, ...] = (True,)

    def __post_init__(self) -> None:
        if not self.amounts or len(self.amounts) != len(self.is_share):
            raise UsageError(
                "a budget needs one mark of share or not per amount",
                where="Budget",
                expected="amounts and is_share of the same length, at least 1",
                found=f"{len(self.amounts)} and {len(self.is_share)}",
            )
        for amount in self.amounts:
            if not 0 <= amount < np.inf:
                raise UsageError(
                    "a budget cannot be that", where="Budget", expected="0 or more", found=f"{amount:g}"
                )

    @classmethod
    def parse(cls, text: str) -> Budget:
        """Read "1%", "0.5" (N m), or one such entry per joint: "1%,1%,0.2".

        Raises
        ------
        UsageError
            If an entry is not a number of 0 or more, with or without a percent sign.

        Examples
        --------
        >>> Budget.parse("1%").amounts
        (0.01,)
        """
        amounts, is_share = [], []
        for column, entry in enumerate(text.split(","), start=1):
            match = re.fullmatch(rf"\s*({UNSIGNED})\s*(%|N ?m?)?\s*", entry)
            if match is None or float(match[1]) > LARGEST:
                raise UsageError(
                    "the budget is not understood",
                    where=f"--budget, entry {column}",
                    expected=f"a share of peak torque such as 1%, or N m such as 0.5; up to {LARGEST:g}",
                    found=repr(entry.strip()),
                )
            percent = match[2] == "%"
            amounts.append(float(match[1]) / 100 if percent else float(match[1]))
            is_share.append(percent)
        return cls(tuple(amounts), tuple(is_share))

    def allowed(self, peak_torque: FloatArray) -> FloatArray:
        """Allowed error of each joint, N m, shape (n,).

        Raises
        ------
        UsageError
            If there are several entries, but not one per joint.
        """
        n = len(peak_torque)
        if len(self.amounts) not in (1, n):
            raise UsageError(
                "the budget has a wrong number of entries",
                where="--budget",
                expected=f"1 or {n}",
                found=str(len(self.amounts)),
            )
        amounts = np.broadcast_to(self.amounts, (n,))
        return np.where(np.broadcast_to(self.is_share, (n,)), amounts * peak_torque, amounts)

    def scaled(self, factor: float) -> Budget:
        """The same budget, every amount times a factor."""
        return Budget(tuple(factor * amount for amount in self.amounts), self.is_share)

    def __str__(self) -> str:
        return ", ".join(
            f"{amount * 100:g}%" if share else f"{amount:g} N m"
            for amount, share in zip(self.amounts, self.is_share, strict=True)
        )
