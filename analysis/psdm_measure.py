"""PSDM's arms under PSDM's own measure of error, beside what PSDM published.

Lloyd, Irani and Ahmadi, "A numeric derivation for fast regressive modeling of manipulator dynamics", Mechanism and
Machine Theory 2021 (doi 10.1016/j.mechmachtheory.2020.104149), find expanded equations numerically, drop coefficients
and refit the rest, until the norm of the torque error is a share of the norm of the torque at 95 % or 99.9 % of sampled
states. The arms are those of their Table 1, the budgets theirs. The SCARA is simplified: the others have too many terms.
Writes `psdm_measure.md` beside this file and shows how far it is: `python analysis/psdm_measure.py`.
"""

from __future__ import annotations

import ctypes
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gd_analyze import __version__
from gd_analyze.cache import without_cache
from gd_analyze.exporting.export import Exported, export, written
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))  # makers that tests share

from published_arms import PROFILES, arm_of

# States, and how much of the usual effort every search takes.
STATES, EFFORT = 2000, 0.25
# Searches of each model with scaled budgets, which come within 1.1 times of the largest that keeps the norm.
SEARCHES = 6
SHARES, QUANTILES = (0.01, 0.001), (0.95, 0.999)

# Behind the exported C: the torque at one state after the other.
_EVERY_STATE = """
void all(long count, long n, const double *q, const double *qd, const double *qdd, double *tau)
{
    for (long s = 0; s < count; s++)
        %s_torque(q + s * n, qd + s * n, qdd + s * n, tau + s * n);
}
"""


class Published(NamedTuple):
    """What PSDM's authors give of an arm."""

    operations: int
    seconds: float


PUBLISHED = {
    "KR6": Published(10_185, 5.3),
    "LBR7": Published(32_368, 88.0),
    "SCARA": Published(210, 0.05),
}
SIMPLIFIED = "SCARA"


def dynamics_of(name: str, profile: str = "fast", seed: int = 0) -> ExactDynamics:
    """Take an arm's exact dynamics over states drawn evenly from the profile's limits."""
    arm = arm_of(name, profile)
    return ExactDynamics.of(arm, states_in_box(arm, STATES, seed))


@dataclass(frozen=True)
class Row:
    """One simplified model."""

    arm: str
    profile: str
    share: float
    quantile: float
    model: SimplifiedModel
    seconds: float
    fresh: float
    nanoseconds: float | None

    @property
    def line(self) -> str:
        """Its line of the table."""
        accuracy, errors = self.model.accuracy, self.model.accuracy.errors
        (norm,) = (norm for norm in accuracy.norms if norm.states == self.quantile)
        return (
            f"| {self.arm} | {self.profile} | {self.share:.1%} | {self.quantile:.1%} | "
            f"{self.model.operations.total} | {norm.share:.2%} | {self.fresh:.2%} | "
            f"{errors.largest_share.max():.1%} (joint {errors.worst + 1}) | {self.seconds:.0f} | "
            f"{_rounded(self.nanoseconds)} |"
        )


def simplified(
    name: str, profile: str, share: float, quantile: float, states: int = STATES
) -> tuple[SimplifiedModel, float, float]:
    """Simplify; the model, the seconds it took, and the share that as many of other states keep.

    The share of peak torque allowed to each joint is scaled until the norm is just kept.
    """
    exact = dynamics_of(name, profile)
    if states < STATES:
        exact = exact.at(exact.states.evenly(states))
    start = time.process_time()
    few, many = share / 10, 10 * share
    how = SearchOptions(effort=EFFORT)
    model = simplify_exact(exact, f"{few:%}", how)
    for _ in range(SEARCHES):
        middle = (few * many) ** 0.5
        trial = simplify_exact(exact, f"{middle:%}", how)
        if norm_at(exact, trial, quantile) <= share:
            few = middle
            model = min(model, trial, key=lambda one: one.operations.total)
        else:
            many = middle
    seconds = time.process_time() - start
    return model, seconds, norm_at(dynamics_of(name, profile, seed=1), model, quantile)


def norm_at(exact: ExactDynamics, model: SimplifiedModel, quantile: float) -> float:
    """Norm of a model's error over that of the torque at this share of the states."""
    (share,) = (n.share for n in exact.norms_of(model.torque(*exact.states.arrays)) if n.states == quantile)
    return share


def nanoseconds(exported: Exported, states: States) -> float | None:
    """Time exported C, per state, the least of many passes over all states; None without a compiler."""
    if shutil.which("gcc") is None:
        return None
    name, function = exported.subject.name, exported.subject.torque
    assert function is not None
    rows = [np.ascontiguousarray(x) for x in states.arrays]
    count, n = rows[0].shape
    torque = np.empty_like(rows[0])
    with tempfile.TemporaryDirectory() as folder:
        exported.save(folder)
        source, library = Path(folder, f"{name}.c"), Path(folder, "torque.so")
        # In the same file, so that the call of every state costs nothing.
        source.write_text(source.read_text(encoding="ascii") + _EVERY_STATE % name, encoding="ascii")
        command = ["gcc", "-O2", "-shared", "-fPIC", str(source), "-o", str(library), "-lm"]
        subprocess.run(command, check=True, capture_output=True)
        every = ctypes.CDLL(str(library)).all
        pointers = [ctypes.c_void_p(x.ctypes.data) for x in (*rows, torque)]
        least = np.inf
        for _ in range(200):
            start = time.perf_counter_ns()
            every(ctypes.c_long(count), ctypes.c_long(n), *pointers)
            least = min(least, (time.perf_counter_ns() - start) / count)
    inputs = {
        f"{name}{i + 1}": x[:, i] for name, x in zip(("q", "qd", "qdd"), rows, strict=True) for i in range(n)
    }
    # What was timed is the model: the compiler may round otherwise in the last digits, hundreds of times.
    exact = function.program.run(inputs)
    np.testing.assert_allclose(torque.T, exact, rtol=0.0, atol=1e-11 * np.abs(torque).max())
    return least


def exact_line(name: str) -> str:
    """What the exact torque takes, beside PSDM's: operations, seconds to derive it, nanoseconds to evaluate it."""
    exact, theirs = dynamics_of(name), PUBLISHED[name]
    start = time.process_time()
    count = exact.form.operations
    seconds = time.process_time() - start
    timed = nanoseconds(written(ExportInput.of_exact(exact.form), "c"), exact.states)
    return (
        f"| {name} | {count.total} ({count.multiplications} + {count.additions}) | {theirs.operations} | "
        f"{theirs.operations / count.total:.0f} | {seconds:.1f} | {theirs.seconds:g} | "
        f"{_rounded(timed)} |"
    )


def rows() -> Iterator[Row]:
    """Simplify under every profile and budget."""
    for profile, share, quantile in product(PROFILES, SHARES, QUANTILES):
        model, seconds, fresh = simplified(SIMPLIFIED, profile, share, quantile)
        timed = nanoseconds(export(model, "c"), dynamics_of(SIMPLIFIED, profile).states)
        yield Row(SIMPLIFIED, profile, share, quantile, model, seconds, fresh, timed)


def _rounded(value: float | None) -> str:
    return "" if value is None else f"{value:.0f}"


def told(words: str) -> None:
    """Say how far it is."""
    print(f"{time.strftime('%H:%M:%S')} {words}", file=sys.stderr, flush=True)


def report() -> str:
    """Write the study as Markdown."""
    exact, simple = [], []
    for name in PUBLISHED:
        exact.append(exact_line(name))
        told(exact[-1])
    for row in rows():
        simple.append(row.line)
        told(row.line)
    return "\n".join(
        [
            "# PSDM's arms under PSDM's measure",
            "",
            made_with(),
            "",
            "Generated by `python analysis/psdm_measure.py`; do not edit. Seconds and nanoseconds vary with the machine.",
            "",
            "Lloyd, Irani and Ahmadi (2021) derive expanded equations numerically and simplify them until the norm of the "
            "torque error is a share of the norm of the torque at 95 % or 99.9 % of sampled states. Here are the three arms "
            "of their Table 1 at the same norms; the budget, a share of each joint's peak torque, is scaled until the norm is just kept. Over "
            f"{STATES} states drawn evenly: joints over the full circle, velocities and accelerations up to "
            + " or ".join(f"{rate:g} and {most:g} ({name})" for name, (rate, most) in PROFILES.items())
            + " in rad, m and s. No drives, as with them. Operations are multiplications and additions, sines and cosines "
            "apart; those of PSDM are as published, and so are its seconds and nanoseconds, on an Intel i7 of 3.2 GHz with "
            f"C by gcc. Ours: seconds of processor time of Python {platform.python_version()}, nothing kept from runs before; "
            f"nanoseconds of the program as straight-line C, as `gd-analyze export` prints it, gcc -O2, {machine()}, sines and cosines "
            "included, the least of 200 passes over all states.",
            "",
            "## Exact",
            "",
            "| arm | operations (mult + add) | PSDM | times fewer | seconds | PSDM | nanoseconds |",
            "|---|---|---|---|---|---|---|",
            *exact,
            "",
            "## Simplified",
            "",
            "`share`: the largest share of the norm at so many of the states; `elsewhere`: the same at as many states drawn with "
            "another seed. `largest`: the largest error of any joint at any state, over the joint's peak torque. The norm is "
            "dominated by the joints with the largest torques, and little may be left of the others. Models are sums of terms.",
            "",
            "| arm | profile | error | of states | operations | share | elsewhere | largest | seconds | nanoseconds |",
            "|" + "---|" * 10,
            *simple,
            "",
            "The SCARA's revolute joints have a norm in N m, its prismatic joint one in N. PSDM puts both into one norm, which "
            "depends on the units chosen; here the larger share of the two counts, which implies theirs in any units. The "
            "error is sampled in either tool; [a certificate](../docs/certificate.md) bounds ours for all states.",
            "",
        ]
    )


def made_with() -> str:
    """State version and date, which say how old a study is."""
    return f"Made with gd-analyze {__version__} on {date.today()}."


def machine() -> str:
    """Name the processor, as far as the system tells; family and model tell generations of one name apart."""
    about = Path("/proc/cpuinfo")
    if not about.exists():
        return platform.machine()
    parts = [line.partition(":") for line in about.read_text().splitlines()]
    values = {key.strip(): value.strip() for key, _, value in parts}
    if "model name" not in values:
        return platform.machine()
    return f"{values['model name']} (family {values.get('cpu family')}, model {values.get('model')})"


if __name__ == "__main__":
    # So that seconds are those of a first time.
    with without_cache():
        Path(__file__).with_suffix(".md").write_text(report(), encoding="utf-8")
