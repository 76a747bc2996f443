"""Identification from logs of real robots, beside the fit that was published with them.

The logs are not part of this project: github.com/shamilmamedov/dynamic_calibration (dataset_ur10e) and
github.com/unisa-acg/inverse-dynamics-solver, each with the robot's URDF file. Writes identified_robots.md:
`python analysis/identified_robots.py FOLDER_OF_UR10E FOLDER_OF_UR10`.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

import gd_analyze as gd
from documented_tables import table
from gd_analyze.arrays import FloatArray
from gd_analyze.files import write_text
from gd_analyze.identification.identification import Identification
from gd_analyze.identification.rows import Unknowns, identification_rows
from gd_analyze.motions.states import States
from gd_analyze.text import number, percent

# Mamedov and Mikhel 2020: torque per ampere; viscous and Coulomb friction and offset, by joint.
CURRENTS = "10.0,10.7,8.5,9.0,9.5,10.1"
PUBLISHED = np.array(
    [
        [12.5, 21.3, 0.2],
        [13.3, 20.2, -0.75],
        [5.0, 10.4, 0.2],
        [2.0, 3.6, 0.05],
        [2.7, 2.5, -0.01],
        [2.3, 3.0, 0.04],
    ]
)
# Fitted to the controller's own torques with the file's links, as their paper's drives are not published apart.
DRIVES = np.array([6.3, 7.0, 6.3, 0.93, 0.64, 0.61])
COLUMNS = ("time=#1", "q=#2..#7", "qd=#8..#13", "torque=#14..#19")
HERE = Path(__file__).with_suffix(".md")
Row = Iterable[object]


def joints(values: FloatArray) -> list[str]:
    """Show a number per joint."""
    return [number(float(value)) for value in values]


def published(found: Identification, arm: gd.types.RobotArm, motion: gd.Trajectory) -> FloatArray:
    """RMS that the file with the published friction, and drives, leaves of the rows held out."""
    unknowns = Unknowns(arm.n_joints)
    fastest = np.abs(motion.qd).max(axis=0)
    values = found.estimate.start.copy()
    values[unknowns.of_drives], values[unknowns.of_friction] = DRIVES, PUBLISHED.ravel()
    rows = identification_rows(arm, motion, unknowns, fastest)
    return np.array([np.sqrt(np.mean((each.torque - each.columns @ values) ** 2)) for each in rows])


def held_out(folder: Path) -> Iterator[Row]:
    """Two exciting motions of a UR10e, each predicted from the other."""
    arm = gd.load_arm(str(folder / "ur10e.urdf"))
    reading = gd.types.Reading.of(COLUMNS, torque_constant=CURRENTS)
    names = ("ur-20_02_19_14harm50sec", "ur-20_02_12-40sec_12harm")
    logs = [gd.read_trajectory(folder / f"{name}.csv", arm, reading) for name in names]
    yield ("fitted on", "predicted", "RMS, N m, at joint", *range(1, 7))
    for fitted, other in (logs, logs[::-1]):
        found = gd.identify(arm, fitted, held_out=other)
        models = {
            "measured": np.array([each.rms("measured") for each in found.residuals]),
            "left by the file": np.array([each.rms("file") for each in found.residuals]),
            "with the published friction and drives": published(found, arm, other),
            "with friction fitted": np.array([each.rms("friction") for each in found.residuals]),
            "identified": np.array([each.rms("identified") for each in found.residuals]),
        }
        for name, values in models.items():
            yield (fitted.name, other.name, name, *joints(values))
        shares = models["identified"] / models["measured"]
        yield (fitted.name, other.name, "identified, of measured", *(percent(float(x)) for x in shares))


def at_rest(folder: Path) -> Iterator[Row]:
    """Two recordings in which the arm stands still: gravity alone, within what friction may hold."""
    arm = gd.load_arm(str(folder / "ur10e.urdf"))
    reading = gd.types.Reading.of(COLUMNS, torque_constant=CURRENTS)
    fitted = gd.read_trajectory(folder / "ur-20_02_19_14harm50sec.csv", arm, reading)
    found = gd.identify(arm, fitted)
    yield ("recording", "N m, at joint", *range(1, 7))
    for name in ("ur-20_01_17-p1", "ur-20_01_17-p2"):
        table = np.loadtxt(folder / f"{name}.csv", delimiter=",")
        q = table[:, 1:7].mean(axis=0)
        torque = table[:, 13:19].mean(axis=0) * np.array(CURRENTS.split(","), dtype=float)
        still = States(q[None], np.zeros((1, 6)), np.zeros((1, 6)))
        yield (name, "measured", *joints(torque))
        for label, of in (("left by the file", arm), ("left by the identified arm", found.arm)):
            yield (
                name,
                label,
                *joints(torque - gd.types.ExactDynamics.of(of, still, drives=False).torque[0]),
            )
        yield (name, "Coulomb friction identified", *joints(found.friction[:, 0]))


def payload(folder: Path) -> Iterator[Row]:
    """The unknown load of the same motion."""
    arm = gd.load_arm(str(folder / "ur10e.urdf"))
    reading = gd.types.Reading.of(COLUMNS, torque_constant=CURRENTS)
    bare, loaded = (
        gd.read_trajectory(folder / f"ur-20_02_19_14harm50sec{load}.csv", arm, reading)
        for load in ("", "Load")
    )
    found = gd.identify(arm, bare, loaded=loaded)
    assert found.payload is not None
    yield "", "mass, kg", "x, m", "y, m", "z, m"
    for label, row in zip(("identified", "standard error"), found.payload, strict=True):
        yield (label, *joints(row))


def ur10(folder: Path) -> Iterator[Row]:
    """The exciting motion of a UR10: the last third predicted from the others."""
    arm = gd.load_arm(str(folder / "ur10_robot.urdf"))
    found = gd.identify(arm, gd.read_trajectory(folder / "ur10_exciting_trajectory.db3", arm))
    yield ("RMS, N m, at joint", *range(1, 7))
    for name in ("measured", "file", "friction", "identified"):
        label = {"file": "left by the file", "friction": "with friction fitted"}.get(name, name)
        yield (label, *joints(np.array([each.rms(name) for each in found.residuals])))


TEXT = """# Identified robots

Logs of real robots that others published; the script `analysis/identified_robots.py` says where they are. Nothing is tuned
to a log: `gd.identify` runs with its defaults.

## A UR10e, each of two motions predicted from the other

Fourier series of 12 and 14 harmonics (Mamedov and Mikhel 2020); torques are measured currents times their published
constants. The published friction is taken with the file's links and drives' inertia of 6.3 7.0 6.3 0.93 0.64 0.61 kg m².

{held_out}
The two recordings meant for validation, `ur-20_01_17-p1` and `-p2`, hold an arm that stands still: no joint moves. At rest
friction may hold any torque up to Coulomb's, so all that can be said is that gravity is within it:

{at_rest}
The same motion with and without a load on the flange (`loaded`):

{payload}
## A UR10, the last third of its motion predicted

{ur10}"""


def main() -> None:
    """Write the page."""
    warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
    ur10e, other = map(Path, sys.argv[1:3])
    tables = {
        "held_out": table(held_out(ur10e)),
        "at_rest": table(at_rest(ur10e)),
        "payload": table(payload(ur10e)),
        "ur10": table(ur10(other)),
    }
    write_text(HERE, TEXT.format(**tables))


if __name__ == "__main__":
    main()
