"""What torque terms are made of as expressions of q, qd and qdd on a trace."""

from __future__ import annotations

from typing import Any

from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.terms import Factor, Rate
from gd_analyze.operations import Trace


class TorqueVariables:
    """Sines, cosines, powers, absolute rates and accelerations; sums of parallel angles are formed once.

    Parameters
    ----------
    rates
        The arm's absolute rates.
    trace
        Where the expressions are kept.
    """

    def __init__(self, rates: AbsoluteRates, trace: Trace) -> None:
        n = rates.n_joints
        self._trace = trace
        self._q, qd, qdd = (trace.inputs(name, n)[:, 0] for name in ("q", "qd", "qdd"))
        self._known: dict[Rate | Factor, Any] = {}
        self._moving = {1: rates.absolute(qd), 2: rates.absolute(qdd)}

    def __call__(self, variable: Rate | Factor) -> Any:
        """Expression of a rate or a factor."""
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
        return argument if kind == "power" else self._trace.apply(kind, argument)
