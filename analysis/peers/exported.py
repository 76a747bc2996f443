"""C that is exported, compiled and called: state by state, and all at once."""

from __future__ import annotations

from pathlib import Path

from gd_analyze.exporting.export import written
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.motions.states import States
from peers.timed import Way, library, way

# Called from a file of its own, as a controller does: nothing is put in line.
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


def exported(what: str, subject: ExportInput, states: States, folder: Path, flags: str) -> list[Way]:
    """Call `arm_torque` in a loop of C, and `arm_torque_many`, of a subject that is named arm."""
    sources = dict(written(subject, "c").files) | {"driver.c": _DRIVER.format(n=subject.n)}
    made = library(folder, sources, "gcc", *flags.split())
    one = way(f"{what}, one, {flags}", made.one, states)
    return [one, way(f"{what}, many, {flags}", made.many, states, by_joint=True)]
