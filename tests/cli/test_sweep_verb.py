"""`gd-analyze sweep`: what it prints, what it writes, and what it refuses."""

from __future__ import annotations

import re

import xarray as xr

import gd_analyze as gd


def test_what_is_printed_and_written(run, here, motion, two_link):
    line = "sweep two_link gentle.csv --vary link2.mass=0.5..4:6 --out made"
    words = run(line).words
    assert "link2.mass 0.5 to 4 kg" in words
    assert {path.name for path in (here / "made").iterdir()} == {
        f"sweep.{x}" for x in ("h5", "html", "pdf", "json")
    }
    with xr.open_dataset(here / "made" / "sweep.h5", engine="h5netcdf") as stored:
        found = gd.sweep(two_link, gd.read_trajectory(motion, two_link), "link2.mass=0.5..4:6")
        assert (stored.verdict == found.verdict).all()
        xr.testing.assert_allclose(stored.contribution, found.contribution, rtol=1e-12)
    json = run("sweep two_link gentle.csv --vary link2.mass=0.5..4:6 --json").json
    assert json["low"] == [0.5]
    assert [row["element"] for row in json["changes"]] == found.change_element.values.tolist()
    assert [row["at"] for row in json["changes"]] == found.change_at.values[:, 0].tolist()
    other = run("sweep two_link gentle.csv --vary link2.mass=0.5..3:6 --out made")
    assert other.code == 2
    assert "--overwrite" in other.err


def test_every_kind_of_sweep_has_its_page(run, here, motion):
    for k, vary in enumerate((
        "--vary link2.mass=0.5..4:3 --vary speed=0.5..2:3",
        "--vary link2.mass=0.5..4:2 --vary speed=0.5..2:2 --vary joint1.a=0.5..1:2",
        "--vary link2.mass=0.5..4 --vary speed=0.5..2 --samples 30",
    )):  # fmt: skip
        assert run(
            f"sweep two_link gentle.csv {vary} --operations none --out made{k} --format html,pdf"
        ).words
        page = (here / f"made{k}" / "sweep.html").read_text()
        assert "Peak torque" in page
    assert (here / "made0" / "sweep.html").read_text().count("<svg") >= 2
    # Above a map of a verdict stands no unit: that of the number upward is at its own axis.
    run("sweep two_link gentle.csv --vary speed=0.5..2:3 --vary link2.mass=0.5..4:3 --out maps --format html")
    page = (here / "maps" / "sweep.html").read_text()
    assert re.findall(r">([\d.]+ kg)</text>", page)
    assert ", kg</tspan>" not in page


def test_bad_sweeps_write_nothing(run, motion, listing):
    before = listing()
    for line, says in {
        "sweep two_link gentle.csv": "--vary",
        "sweep two_link gentle.csv --vary link2.mas=1..2": "link2.mass",
        "sweep two_link gentle.csv --vary link2.mass=2..1": "link2.mass=2..1",
        "sweep two_link gentle.csv --vary link2.mass=-1..1": "mass",
        "sweep two_link gentle.csv --vary link2.mass=1..2:3 --samples 5": ":COUNT",
        "sweep two_link gentle.csv --vary link2.mass=1..2 --jobs 0": "--jobs",
    }.items():
        result = run(f"{line} --out made")
        assert (result.code, result.out) == (2, ""), line
        assert says in result.err
        assert "Traceback" not in result.err
    assert listing() == before
