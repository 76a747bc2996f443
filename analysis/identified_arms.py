"""Trials of identification: 200 noisy logs of each of three arms whose numbers are known.

Writes identified_arms.md beside it: `python analysis/identified_arms.py --ur10 ur10_robot.urdf`; half an hour.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from pathlib import Path

import numpy as np

import gd_analyze as gd
from documented_tables import panda, table
from gd_analyze.files import write_text
from gd_analyze.identification.identification import Identification
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import pseudo_inertia
from gd_analyze.text import number, percent

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))  # makers that tests share

from logs_of_arms import TrueArm, fourier

RUNS, SECONDS, RATE, FRESH_RATE = 200, 20.0, 200.0, 50.0
# Exciting motions, taken in turn.
MOTIONS = 8
NOISE = (1e-4, 0.01)
HERE = Path(__file__).with_suffix(".md")
HEAD = f"""# Identified arms

Each of {RUNS} runs draws an arm whose links differ from the file's (masses and inertias by up to 20 and 40 %, centres of
mass by 20 mm), with drives and friction that the file does not state. It moves by one of {MOTIONS} motions of {SECONDS:g} s
from `gd-analyze plan --exciting`, sampled at {RATE:g} Hz. Positions have noise of {NOISE[0]:g} rad, torques of {NOISE[1]:.0%} of their RMS.
`gd.identify` gets the file and the log, and fits its first two thirds. The script is `analysis/identified_arms.py`.

- *Within three standard errors*: base parameters of all runs that the log tells; and the parameter that is so in the fewest runs.
- *Torque of a fresh motion over the noise floor*: RMS of the error on a random Fourier series within the arm's limits,
  with the noise of the log beside it, over that noise alone, the worst joint's.
- *Bodies possible*: runs in which every link's pseudo-inertia is positive definite.

"""


def least_eigenvalue(found: Identification) -> float:
    """Smallest eigenvalue of any link's pseudo-inertia."""
    matrices = [pseudo_inertia(link.mass, link.com, link.inertia_com) for link in found.arm.links]
    return float(min(np.linalg.eigvalsh(matrix)[0] for matrix in matrices))


def trials(name: str, arm: RobotArm, runs: int) -> list[str]:
    """One row."""
    off, known, fresh, possible, seconds = [], [], [], 0, 0.0
    plans = [gd.exciting_motion(arm, SECONDS, int(SECONDS * RATE) + 1, seed=seed) for seed in range(MOTIONS)]
    for run in range(runs):
        true, motion = TrueArm.near(arm, run), plans[run % MOTIONS].trajectory
        instants, states = motion.time, gd.tables.states_of(motion)
        log = true.log(instants, states, NOISE, run)
        start = time.process_time()
        found = gd.identify(arm, log)
        seconds += time.process_time() - start
        identifiable = np.array([one.identifiable for one in found.parameters])
        values, errors = (
            np.array([getattr(one, key) for one in found.parameters]) for key in ("value", "error")
        )
        off.append(np.where(identifiable, np.abs(values - true.base) / errors, np.nan))
        known.append(identifiable.sum())
        _, other = fourier(arm, SECONDS, FRESH_RATE, 10_000 + run)
        coulomb, viscous, offset = found.friction.T
        ours = gd.types.ExactDynamics.of(found.arm, other, drives=True).torque
        ours = ours + coulomb * np.sign(other.qd) + viscous * other.qd + offset
        noise = NOISE[1] * np.sqrt((true.torque(states) ** 2).mean(axis=0))
        error = np.sqrt(((ours - true.torque(other)) ** 2).mean(axis=0))
        fresh.append(float((np.hypot(error, noise) / noise).max()))
        possible += least_eigenvalue(found) > 0.0
    shares = np.array(off)
    is_within = np.where(np.isnan(shares), np.nan, shares < 3.0)
    within = np.nanmean(is_within, axis=0)
    return [
        name,
        f"{np.mean(known):.1f} of {shares.shape[1]}",
        f"{100 * np.nanmean(is_within):.2f} %",
        percent(float(np.nanmin(within))),
        f"{np.median(fresh):.3f}",
        f"{np.quantile(fresh, 0.99):.3f}",
        f"{max(fresh):.3f}",
        f"{possible} of {runs}",
        number(seconds / runs),
    ]


def main() -> None:
    """Run the trials and write the page."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--ur10", help="URDF file of a UR10")
    parser.add_argument("--runs", type=int, default=RUNS)
    given = parser.parse_args()
    warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
    arms = {"PUMA 560": gd.load_arm("puma560"), "Franka Panda": panda()}
    if given.ur10:
        arms["UR10"] = gd.load_arm(given.ur10, limits="all=10")
    heading = [
        "arm",
        "base parameters identifiable",
        "within three standard errors",
        "fewest",
        "fresh torque / noise floor, median",
        "99 %",
        "largest",
        "bodies possible",
        "s",
    ]
    rows = [trials(name, arm, given.runs) for name, arm in arms.items()]
    write_text(HERE, HEAD + table([heading, *rows]))
    print(table([heading, *rows]))


if __name__ == "__main__":
    main()
