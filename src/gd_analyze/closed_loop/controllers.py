"""What controllers know, and the torque they ask for.

Both laws are u = M (a + K_d e' + K_p e) + b, with the error e = q_d - q of positions:

- computed torque ([FGL87] section 5.3): a is the acceleration wanted, M and b are the model's D and h + c, or
  what the controller knows of them;
- PD with compensation of gravity: a is zero, M a constant for each joint, and b the model's c.

Where a controller knows no D, M is the mean of D's diagonal along the motion: what its gains are tuned to.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from gd_analyze.closed_loop.gains import Gains
from gd_analyze.levels import SimplifiedModel
from gd_analyze.operations import Program
from gd_analyze.operations.batch import Batch
from gd_analyze.vectors import FloatArray

Law = Literal["computed_torque", "pd"]
Knows = Literal["nothing", "gravity", "without_h", "simplified", "exact"]

KNOWN: dict[Knows, str] = {
    "nothing": "nothing",
    "gravity": "gravity only",
    "without_h": "without h",
    "simplified": "simplified model",
    "exact": "exact model",
}


class Controller(NamedTuple):
    """A law and what it knows of the arm."""

    law: Law
    knows: Knows

    @property
    def title(self) -> str:
        """Name it: computed torque by what it knows, PD as such."""
        if self.law == "computed_torque":
            return KNOWN[self.knows]
        of = {"nothing": "alone", "gravity": "exact c", "simplified": "simplified c"}
        return f"PD, {of[self.knows]}"

    @property
    def knows_inertia(self) -> bool:
        """Whether its M is a model's D."""
        return self.law == "computed_torque" and self.knows in ("without_h", "simplified", "exact")

    @property
    def knows_rates(self) -> bool:
        """Whether it makes up for h."""
        return self.law == "computed_torque" and self.knows in ("simplified", "exact")


# PD with the exact model, or with that without h, is PD with the exact gravity.
CONTROLLERS = (
    Controller("computed_torque", "exact"),
    Controller("computed_torque", "simplified"),
    Controller("computed_torque", "without_h"),
    Controller("computed_torque", "gravity"),
    Controller("computed_torque", "nothing"),
    Controller("pd", "gravity"),
    Controller("pd", "simplified"),
    Controller("pd", "nothing"),
)


@dataclass(frozen=True, eq=False)
class Knowledge:
    """What controllers may know of an arm.

    Parameters
    ----------
    exact, simplified
        Programs of its torque.
    diagonal
        Mean of D's diagonal along the motion, kg m^2 (kg), shape (n,).
    """

    exact: Program
    simplified: Program
    diagonal: FloatArray

    @classmethod
    def of(cls, model: SimplifiedModel, diagonal: FloatArray) -> Knowledge:
        """Take what a model and the exact dynamics it stands for tell."""
        return cls(model.form.program, model.program, diagonal)


class _Model:
    """One model's torque for those of several controllers that use it."""

    def __init__(self, program: Program, controllers: Sequence[Controller], n: int, simplified: bool) -> None:
        uses = [(c.knows == "simplified") == simplified and c.knows != "nothing" for c in controllers]
        self.chosen = np.flatnonzero(uses)
        chosen = [controller for controller, is_used in zip(controllers, uses, strict=True) if is_used]
        if not chosen:
            return
        self._batch = Batch(program, len(chosen))
        factors = {
            "q": np.ones(len(chosen)),
            "qd": np.array([float(c.knows_rates) for c in chosen]),
            "qdd": np.array([float(c.knows_inertia) for c in chosen]),
        }
        self._rows = [(self._batch.rows(name, n), factor) for name, factor in factors.items()]

    def add(self, torque: FloatArray, *state: FloatArray) -> None:
        """Add what it makes of states and wanted accelerations, shape (n, controllers)."""
        if not len(self.chosen):
            return
        for (rows, factor), values in zip(self._rows, state, strict=True):
            for i, row in rows:
                np.multiply(values[i, self.chosen], factor, out=row)
        torque[:, self.chosen] += self._batch.run()


class Bank:
    """Several controllers at work at the same time.

    Parameters
    ----------
    controllers
        Any number of them, m.
    knowledge, gains
        What they know, and how they are tuned.
    """

    def __init__(self, controllers: Sequence[Controller], knowledge: Knowledge, gains: Gains) -> None:
        n = len(knowledge.diagonal)
        self._gains = gains
        self._forward = np.array([float(c.law == "computed_torque") for c in controllers])
        constant = np.array([float(not c.knows_inertia) for c in controllers])
        self._constant = knowledge.diagonal[:, None] * constant
        self._models = [
            _Model(program, controllers, n, simplified)
            for program, simplified in ((knowledge.exact, False), (knowledge.simplified, True))
        ]

    def torque(self, q: FloatArray, qd: FloatArray, wanted: Sequence[FloatArray]) -> FloatArray:
        """Torque asked for, N m (N), shape (n, m), at states and wanted q, qd and qdd, all of that shape."""
        gains, (q_d, qd_d, qdd_d) = self._gains, wanted
        acceleration = self._forward * qdd_d
        acceleration += gains.damper * (qd_d - qd) + gains.stiffness * (q_d - q)
        torque = self._constant * acceleration
        for model in self._models:
            model.add(torque, q, qd, acceleration)
        return torque
