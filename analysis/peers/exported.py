"""C and C++ that is exported, compiled and called: state by state, and C all at once."""

from __future__ import annotations

from pathlib import Path

from gd_analyze.exporting.export import written
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.motions.states import States
from peers.timed import Way, library, way

# Called from a file of its own, as a controller does: nothing is put in line.
DRIVER = """
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
_CPP_DRIVER = """
#include "arm.hpp"
extern "C" void one(long passes, long count, const double *q, const double *qd, const double *qdd, double *tau)
{{
    for (long p = 0; p < passes; p++)
        for (long s = 0; s < count; s++)
            arm::torque<double>(q + {n} * s, qd + {n} * s, qdd + {n} * s, tau + {n} * s);
}}
"""


def exported(what: str, subject: ExportInput, states: States, folder: Path, flags: str) -> list[Way]:
    """Call `arm_torque` in a loop of C and of C++, and `arm_torque_many`, of a subject that is named arm."""
    sources = dict(written(subject, "c").files) | {"driver.c": DRIVER.format(n=subject.n)}
    made = library(folder / "c", sources, "gcc", *flags.split())
    sources = dict(written(subject, "cpp").files) | {"driver.cpp": _CPP_DRIVER.format(n=subject.n)}
    in_cpp = library(folder / "cpp", sources, "g++", *flags.split())
    return [
        way(f"{what}, one, {flags}", made.one, states),
        way(f"{what}, many, {flags}", made.many, states, by_joint=True),
        way(f"{what}, C++, {flags}", in_cpp.one, states),
    ]
