"""Exported C against the same text with the C library's sine and cosine in place of our own, of one run.

Run with `python -m pytest benchmarks/test_exported_sines.py -s`.
"""

from __future__ import annotations

import re
import shutil
import warnings

import numpy as np
import pytest

import gd_analyze as gd
from exported_c import FLAGS, arm_named, simplified
from gd_analyze.exporting.export import written
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.motions.states import states_in_box
from gd_analyze.simplification.exact import ExactForm
from peers.exported import DRIVER
from peers.timed import library, nanoseconds, way

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
ROUNDS = 100
# Least of 100 rounds still differ by a few per cent on a machine that others use.
SLACK = 1.1


def with_the_librarys(source: str) -> str:
    """Put the library's sine and cosine, angle by angle, in place of ours for one state."""
    choice = re.compile(r"    if \(any_far\(angle, (\d+)\)\) \{\n.*?\n    \}\n", re.DOTALL)

    def angles(match: re.Match[str]) -> str:
        function = match.string[: match.start()].rpartition("\nvoid ")[2]
        needed = [k for k in range(int(match[1])) if f"angle[{k}] = 0.0;" not in function]
        return "".join(f"    sine[{k}] = sin(angle[{k}]), cosine[{k}] = cos(angle[{k}]);\n" for k in needed)

    return choice.sub(angles, source)


@pytest.mark.parametrize("name", ["PUMA 560 with drives", "KR6", "LBR7", "UR10", "Panda"])
def test_our_sines_are_never_slower_than_the_librarys(benchmark, tmp_path, name) -> None:
    arm = arm_named(name)
    if arm is None:
        pytest.skip("example-robot-data is not installed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
        states = states_in_box(arm, 1000, seed=1)
    model = simplified(arm, states=500, effort=0.05)
    subjects = {
        "exact": ExportInput.of_exact(ExactForm(arm, model.drives), "arm"),
        "simplified": ExportInput.of_model(model, "arm"),
    }
    ways = []
    for what, subject in subjects.items():
        ours = dict(written(subject, "c").files)
        theirs = ours | {"arm.c": with_the_librarys(ours["arm.c"])}
        assert theirs["arm.c"] != ours["arm.c"]
        for whose, files in (("ours", ours), ("libm", theirs)):
            for flags in FLAGS:
                folder = tmp_path / f"{what}{whose}{flags}".replace(" ", "")
                sources = files | {"driver.c": DRIVER.format(n=arm.n_joints)}
                made = library(folder, sources, "gcc", *flags.split())
                ways.append(way(f"{what}, {whose}, {flags}", made.one, states))
    found = benchmark.pedantic(lambda: nanoseconds(ways, ROUNDS), rounds=1)
    print(f"\n{name}: " + "; ".join(f"{key} {ns:.1f}" for key, ns in found.items()))
    by_name = {each.name: each.torque for each in ways}
    for flags in FLAGS:
        for what in subjects:
            ours, theirs = (f"{what}, {whose}, {flags}" for whose in ("ours", "libm"))
            # Sines are off by some roundings of 1, which a few hundred operations carry on.
            close = 1e-12 * np.abs(by_name[theirs]).max()
            np.testing.assert_allclose(by_name[ours], by_name[theirs], rtol=0, atol=close)
            benchmark.extra_info[f"{what}, {flags}: times faster than libm"] = found[theirs] / found[ours]
            assert found[ours] <= SLACK * found[theirs]
        assert found[f"simplified, ours, {flags}"] <= SLACK * found[f"exact, ours, {flags}"]
