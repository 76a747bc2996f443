"""A model or an arm's exact dynamics, as exported to C."""

from __future__ import annotations

from pathlib import Path

from gd_analyze.exporting import export
from gd_analyze.levels import SimplifiedModel
from gd_analyze.robots import RobotArm
from gd_analyze.states import States
from peers.timed import Way, library, way

# Both called apart from what they call, so that nothing is put in line.
_DRIVER = """
#include "arm.h"
void one(long passes, long count, const double *q, const double *qd, const double *qdd, double *tau)
{{
    for (long p = 0; p < passes; p++)
        for (long s = 0; s < count; s++)
            arm_torque(q + {n} * s, qd + {n} * s, qdd + {n} * s, tau + {n} * s);
}}
void many(long passes, long count, const double *q, const double *qd, const double *qdd, double *tau)
{{
    for (long p = 0; p < passes; p++)
        arm_torque_many((size_t)count, q, qd, qdd, tau);
}}
"""


def exported(
    name: str, folder: Path, given: SimplifiedModel | RobotArm, states: States, flags: str
) -> list[Way]:
    """One state after another by `NAME_torque`, and all by `NAME_torque_many`."""
    sources = dict(export(given, "c", name="arm").files)
    sources["driver.c"] = _DRIVER.format(n=states.q.shape[1])
    made = library(folder, sources, "gcc", *flags.split())
    return [
        way(f"{name} {flags}", made.one, states),
        way(f"{name} many {flags}", made.many, states, by_joint=True),
    ]
