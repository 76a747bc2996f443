"""Trials of the standard errors of identified numbers, with friction that is the model's and that is not.

Writes identified_errors.md beside it: `python analysis/identified_errors.py`; some minutes.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import numpy as np

import gd_analyze as gd
from documented_tables import table
from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.base_parameters import parameters_of
from gd_analyze.files import write_text
from gd_analyze.identification.identified_arm import base_matrix

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))  # makers that tests share

from faulty_logs import Robot, arms

RUNS, FIRST_SEED = 25, 500
ARMS = ("PUMA 560", "UR-like", "LBR7")
# Multiples of the drawn Stribeck and load-dependent friction, which the model lacks.
FRICTIONS = {"Coulomb and viscous": 0.0, "Stribeck and load, too": 1.0, "twice these": 2.0}
SECONDS = (16.0, 40.0)
HERE = Path(__file__).with_suffix(".md")
HEAD = f"""# Standard errors of identified numbers

Each of {RUNS} runs draws an arm whose links, drives and friction the file does not state, and one motion: a random Fourier series
of five harmonics within the arm's limits, sampled at 125 Hz, with noise of 0.0001 rad and of 2 % of the torque's RMS.
`gd.identify` fits the first two thirds. Stribeck friction is up to 8 % of a joint's torque, load-dependent friction up to 5 %
of it; the model has neither. The script is `analysis/identified_errors.py`.

*Within two*: base parameters that the log tells within 1.96 standard errors of the true ones; 95 % if errors are normal.
Motions of 40 s are slow ones here, in which gravity and friction hide what accelerations tell.

"""


def offsets(name: str, multiple: float, seconds: float) -> FloatArray:
    """Errors of all base parameters that logs tell, in standard errors."""
    out: list[float] = []
    file = arms()[name]
    for seed in range(FIRST_SEED, FIRST_SEED + RUNS):
        robot = Robot.of(file, seed, seconds=seconds)
        robot.friction[:, 2:4] *= multiple
        try:
            identification = gd.identify(file, robot.log(*robot.as_it_is), anyway=True)
        except gd.errors.UsageError:
            continue  # no arm, no errors
        unknowns = np.concatenate([parameters_of(robot.arm).ravel(), robot.drives])
        truth = base_matrix(robot.arm)[1] @ unknowns
        out += [
            abs(parameter.value - value) / parameter.error
            for parameter, value in zip(identification.parameters, truth.tolist(), strict=True)
            if parameter.identifiable
        ]
    return np.array(out)


def main() -> None:
    """Run the trials and write the page."""
    warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
    rows = [["arm", "friction", "s", "parameters of all runs", "within two", "within three"]]
    for name in ARMS:
        for friction, multiple in FRICTIONS.items():
            for seconds in SECONDS:
                errors = offsets(name, multiple, seconds)
                shares = [f"{100.0 * np.mean(errors < limit):.1f} %" for limit in (1.96, 3.0)]
                rows.append([name, friction, f"{seconds:g}", str(len(errors)), *shares])
                print(*rows[-1], flush=True)
    write_text(HERE, HEAD + table(rows))


if __name__ == "__main__":
    main()
