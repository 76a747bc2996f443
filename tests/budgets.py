"""Budgets of one kind, from numbers instead of words."""

from __future__ import annotations

from gd_analyze.simplification.budget import Allowance, Budget


def of_shares(*shares: float) -> Budget:
    """Shares of peak torque, one for all joints or one each."""
    return Budget(tuple((Allowance(share),) for share in shares))


def of_torque(amount: float) -> Budget:
    """One torque for all joints, N m."""
    return Budget.of_torques([amount])
