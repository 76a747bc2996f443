"""Changes of a recursion as a search makes them, but drawn at random."""

from __future__ import annotations

import numpy as np

from gd_analyze.levels.recursion import CONSTANT, NUMBER, Change, Recursion
from gd_analyze.operations.trace import Expression


def random_changes(recursion: Recursion, share: float, seed: int) -> dict[Change, float]:
    """Change a share of the steps: summands dropped, sines taken as constant, numbers changed, steps gone.

    What comes out is a torque: of degree two in the rates, one in the accelerations.
    """
    rng = np.random.default_rng(seed)
    place = {step.order: k for k, step in enumerate(recursion.steps)}
    changes: dict[Change, float] = {}
    for k in recursion.images({})[1]:
        step = recursion.steps[k]
        operands = [place[x.order] for x in step.arguments if isinstance(x, Expression)]
        if step.operation not in ("add", "subtract", "multiply") or rng.random() > share:
            continue
        gone, which = rng.random() < 0.2, int(rng.integers(len(operands)))
        if gone:
            changes[Change(k, NUMBER)] = 0.0
        elif len(operands) < 2 and step.operation == "multiply":
            changes[Change(k, CONSTANT)] = float(step.arguments[0] * rng.uniform(0.5, 1.5))
        elif step.operation == "multiply":
            functions = [x for x in operands if recursion.steps[x].operation in ("cos", "sin")]
            if len(functions) != 1:
                continue
            (which,) = (place for place, x in enumerate(operands) if x not in functions)
            changes[Change(k, operands[which])] = float(rng.uniform(-1.0, 1.0))
        elif len(operands) == 2:
            second = step.arguments[1]
            negative = step.operation == "subtract" and place[second.order] == operands[which]
            changes[Change(k, operands[which])] = -1.0 if negative else 1.0
    return changes
