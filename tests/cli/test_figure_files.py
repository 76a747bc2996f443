"""`gd-analyze figures`: files in every format, and the numbers behind them."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest

import gd_analyze as gd

PUMA = "figures puma560 pick-and-place"


def test_files_are_written_in_every_format(run, here):
    found = run(f"{PUMA} --to svg,pdf,png,csv --out figs --json").json
    names = {path.name for path in (here / "figs").iterdir()}
    quantities = ("inertia", "coriolis_centrifugal", "gravity_loading", "dominance")
    assert names == {f"{name}.{form}" for name in quantities for form in ("svg", "pdf", "png")} | {
        "dominance.csv"
    }
    assert len(found["files"]) == len(names)
    folder = here / "figs"
    assert (folder / "inertia.pdf").read_bytes().startswith(b"%PDF")
    assert (folder / "inertia.png").read_bytes().startswith(b"\x89PNG")
    drawing = ElementTree.fromstring((folder / "inertia.svg").read_text())
    titles = [text.text for text in drawing.iter("{http://www.w3.org/2000/svg}text")]
    assert sum(bool(re.fullmatch("D[₀-₉]{2}", title or "")) for title in titles) == 21
    numbers = pd.read_csv(folder / "dominance.csv")
    assert len(numbers) == 33 * 31
    row = numbers[(numbers.element == "D25") & (numbers.time == 1.2)].iloc[0]
    dataset = gd.decompose("puma560", "pick-and-place")
    expected = dataset.inertia.sel(time=1.2, joint=2, joint_j=5).values
    assert np.allclose(row[["translation", "rotation"]].astype(float), expected, rtol=1e-12)
    assert row.verdict == "rotation"


def test_some_elements_over_set_points(run, here):
    run(f"{PUMA} --element D12 --element h4 --x set-point --effects translation --no-marks --out f")
    assert {path.name for path in (here / "f").iterdir()} == {"inertia.svg", "coriolis_centrifugal.svg"}
    drawn = (here / "f" / "inertia.svg").read_text()
    assert "set point" in drawn
    assert "both together" not in drawn


@pytest.mark.parametrize(
    "words", ["--element D99", "--element x", "--effects drag", "--to gif", "--dominance 2"]
)
def test_what_cannot_be_drawn_is_refused(run, here, words):
    assert run(f"{PUMA} {words} --out f").code == 2
    assert not (here / "f").exists()
