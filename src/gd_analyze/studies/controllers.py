"""What controllers know, and the torque they ask for.

All laws are u = M (K_d e' + K_p e) + b, with the error e = q_d - q of positions:

- computed torque ([FGL87] section 5.3): M is the model's D, and b its torque D a + h + c for the acceleration
  a that is wanted, or what the controller knows of them;
- the same with fixed gains: M is a constant for each joint;
- PD with compensation of gravity: M is that constant, and b the model's c.

The constant is the mean of D's diagonal along the motion: what gains are tuned to. It stands for D, too,
where a controller of computed torque knows none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.program import Batch, Program
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.studies.gains import Gains

Law = Literal["computed_torque", "fixed_gains", "pd"]
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
        if self.law == "fixed_gains":
            return f"{self.knows}, fixed gains"
        of = {"nothing": "alone", "gravity": "exact c", "simplified": "simplified c"}
        return f"PD, {of[self.knows]}"

    @property
    def knows_inertia(self) -> bool:
        """Whether its torque for the wanted acceleration is a model's."""
        return self.law != "pd" and self.knows in ("without_h", "simplified", "exact")

    @property
    def multiplies(self) -> bool:
        """Whether its M is a model's D."""
        return self.law == "computed_torque" and self.knows_inertia

    @property
    def knows_rates(self) -> bool:
        """Whether it makes up for h."""
        return self.law != "pd" and self.knows in ("simplified", "exact")


# PD with the exact model, or with that without h, is PD with the exact gravity.
CONTROLLERS = (
    Controller("computed_torque", "exact"),
    Controller("computed_torque", "simplified"),
    Controller("fixed_gains", "simplified"),
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
        self._diagonal = knowledge.diagonal[:, None]
        # Of the wanted acceleration and of the feedback what is multiplied by the constants, and what by D.
        self._constant = [
            np.array([float(c.law == "computed_torque" and not c.knows_inertia) for c in controllers]),
            np.array([float(not c.multiplies) for c in controllers]),
        ]
        self._by_model = np.array([float(c.multiplies) for c in controllers])
        self._models = [
            _Model(program, controllers, n, simplified)
            for program, simplified in ((knowledge.exact, False), (knowledge.simplified, True))
        ]

    def torque(self, q: FloatArray, qd: FloatArray, wanted: Sequence[FloatArray]) -> FloatArray:
        """Torque asked for, N m (N), shape (n, m), at states and wanted q, qd and qdd, all of that shape."""
        gains, (q_d, qd_d, qdd_d) = self._gains, wanted
        feedback = gains.damper * (qd_d - qd) + gains.stiffness * (q_d - q)
        forward, back = self._constant
        torque = self._diagonal * (forward * qdd_d + back * feedback)
        acceleration = qdd_d + self._by_model * feedback
        for model in self._models:
            model.add(torque, q, qd, acceleration)
        return torque
