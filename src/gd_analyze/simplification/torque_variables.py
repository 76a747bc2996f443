"""What torque terms are made of, as numbers at states or as expressions of q, qd and qdd on a trace."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.terms import Factor, Rate
from gd_analyze.operations.program import UFUNCS
from gd_analyze.operations.trace import Trace


class TorqueVariables:
    """Sines, cosines, powers, absolute rates and accelerations; sums of parallel angles are formed once.

    Parameters
    ----------
    rates
        The arm's absolute rates.
    states
        q, qd and qdd: values of every joint, of any kind that can be added up, n of each.
    """

    def __init__(self, rates: AbsoluteRates, states: Iterable[Any]) -> None:
        self._q, qd, qdd = states
        self._moving = {1: rates.absolute(qd), 2: rates.absolute(qdd)}
        self._known: dict[Rate | Factor, Any] = {}

    @classmethod
    def traced(cls, rates: AbsoluteRates, trace: Trace) -> TorqueVariables:
        """Expressions on a trace."""
        states = (trace.inputs(name, rates.n_joints)[:, 0] for name in ("q", "qd", "qdd"))
        return cls(rates, states)

    def __call__(self, variable: Rate | Factor) -> Any:
        """Value of a rate or a factor."""
        if variable not in self._known:
            self._known[variable] = self._made(variable)
        return self._known[variable]

    def _made(self, variable: Rate | Factor) -> Any:
        if isinstance(variable, Rate):
            return self._moving[variable.order][variable.joint]
        kind, multiples = variable
        argument: Any = 0.0
        for joint, multiple in enumerate(multiples):
            for _ in range(abs(multiple)):
                argument = argument + self._q[joint] if multiple > 0 else argument - self._q[joint]
        return argument if kind == "power" else UFUNCS[kind](argument)
