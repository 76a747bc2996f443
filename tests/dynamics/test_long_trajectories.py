"""A long trajectory takes memory for its motion and torques alone; what is found is the same."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import gd_analyze as gd
from gd_analyze.arrays import CHUNK
from gd_analyze.dynamics import decomposition
from gd_analyze.dynamics.decomposition import MOST_KEPT, decompose_on_demand
from gd_analyze.figures import run
from gd_analyze.figures.run import STRETCHES, drawn
from gd_analyze.report.html import page_of
from gd_analyze.report.main_report import main_report
from gd_analyze.results.run_facts import run_headline
from gd_analyze.studies.steps import collect, read, set_points
from gd_analyze.studies.steps.set_points import LongMotion
from long_cases import long
from recordings import recorded

LONG = MOST_KEPT + CHUNK + 17
SETTINGS = gd.types.Settings(level="element", budget="20%")


def swinging(n_joints: int, count: int) -> gd.Trajectory:
    """Every joint at a frequency of its own, so that extremes fall anywhere."""
    time, omega = np.linspace(0.0, 10.0, count), np.linspace(0.5, 1.5, n_joints)
    sin, cos = np.sin(np.outer(time, omega)), np.cos(np.outer(time, omega))
    return gd.Trajectory(time, 0.5 * sin, 0.5 * omega * cos, -0.5 * omega**2 * sin, "swinging")


@pytest.fixture(scope="module")
def long_swing() -> gd.Trajectory:
    return swinging(2, LONG)


@pytest.fixture(scope="module")
def long_findings(two_link, long_swing):
    return gd.analyze(two_link, long_swing, settings=SETTINGS)


@pytest.mark.parametrize("options", [{"christoffel": False}, {"by_link": True, "terms": True}])
def test_what_is_evaluated_on_demand_is_what_is_kept(puma, options):
    trajectory = swinging(6, LONG)
    kept, read = gd.decompose(puma, trajectory, **options), decompose_on_demand(puma, trajectory, **options)
    some = np.array([0, 5, CHUNK - 1, CHUNK, LONG - 1])
    assert read.attrs == kept.attrs
    assert [*read.variables] == [*kept.variables]
    for name in kept.variables:
        assert read[name].attrs == kept[name].attrs
        assert read[name].dtype == kept[name].dtype
    # Blocks begin elsewhere: vectorised arithmetic may round its last entries otherwise, a few roundings of
    # the largest number.
    for name, variable in kept.isel(time=some).data_vars.items():
        allowed = 8e-16 * float(np.abs(kept[name]).max())
        np.testing.assert_allclose(read[name].isel(time=some), variable, rtol=0, atol=allowed, err_msg=name)


def test_any_part_can_be_read_and_nothing_long_is_kept(two_link, long_swing):
    kept, read = gd.decompose(two_link, long_swing), decompose_on_demand(two_link, long_swing)
    for index in (
        {"time": 3},
        {"time": slice(None, None, 1000), "joint": 1},
        {"time": [0, LONG - 1], "joint": [1, 0], "joint_j": [0]},
        {"time": slice(5, 5)},
        {"effect": 0, "joint": slice(1, 2), "joint_j": 1},
    ):
        xr.testing.assert_allclose(read.inertia.isel(index), kept.inertia.isel(index), rtol=1e-14)
    lazy = {name for name, variable in read.variables.items() if not variable._in_memory}
    assert lazy >= {"inertia", "coriolis_centrifugal", "christoffel"}  # having been read changes nothing
    short = decompose_on_demand(two_link, swinging(2, MOST_KEPT))
    assert all(variable._in_memory for variable in short.variables.values())


def test_the_findings_are_those_of_a_decomposition_that_is_kept(
    two_link, long_swing, long_findings, monkeypatch
):
    for module in (decomposition, read, set_points, collect, run):
        monkeypatch.setattr(module, "MOST_KEPT", LONG)
    kept = gd.analyze(two_link, long_swing, settings=SETTINGS)
    assert kept.trajectory.n_set_points == LONG
    assert long_findings.trajectory.n_set_points <= MOST_KEPT
    assert long_findings.trajectory.n_stated == LONG
    assert long_findings.trajectory.fingerprint == long_swing.fingerprint
    assert long_findings.model.operations == kept.model.operations
    # Sums of as many squares are taken in another order.
    for group in ("dominance", "parts", "budgets", "by_verdicts"):
        xr.testing.assert_allclose(long_findings.tables[group], kept.tables[group], rtol=1e-10, atol=1e-10)
    for name in ("allowed_error", "peak_torque", "largest_error", "rms_error"):
        ours, theirs = (one.tables["simplified_model"][name] for one in (long_findings, kept))
        xr.testing.assert_allclose(ours, theirs, rtol=1e-10, atol=1e-10)
    assert run_headline(long_findings) == run_headline(kept)


def test_what_is_said_of_a_recording_is_of_all_its_readings(two_link, monkeypatch):
    """A torque is off for 20 of 12 305 readings, between evenly spaced set points."""
    log = recorded(two_link, count=LONG, friction=(0.1, 0.02, 0.0), noise=0.01, cutoff=8.0)
    torque = log.recording.torque.copy()
    torque[6000:6020, 1] += 10.0
    log = dataclasses.replace(
        log, recording=dataclasses.replace(log.recording, torque=torque, torque_filtered=torque)
    )
    shown = gd.analyze(two_link, log, settings=SETTINGS)
    for module in (decomposition, read, set_points, collect, run):
        monkeypatch.setattr(module, "MOST_KEPT", LONG)
    kept = gd.analyze(two_link, log, settings=SETTINGS)
    assert (shown.trajectory.n_set_points < LONG / 4, kept.trajectory.n_set_points) == (True, LONG)
    assert shown.tables["diagnosis"].equals(kept.tables["diagnosis"])
    places = np.searchsorted(log.time, shown.trajectory.time)
    for group in ("measured_torque", "recording"):
        assert shown.tables[group].attrs == kept.tables[group].attrs
        xr.testing.assert_allclose(shown.tables[group], kept.tables[group].isel(time=places), rtol=1e-10)
    differences = [
        np.abs(found.tables["measured_torque"].filtered - found.decomposition.torque).max("time")
        for found in (shown, kept)
    ]
    xr.testing.assert_allclose(*differences, rtol=1e-10)
    assert float(differences[0][1]) > 9.0
    assert "cover all, as does the noise; so do the differences of measured torque" in page_of(
        main_report(shown)
    )


@pytest.mark.parametrize(
    ("level", "at_set_points"), [long("element", False), long("term", True), ("term", False)]
)
def test_the_budget_holds_where_the_first_search_did_not_look(
    two_link, long_swing, level, at_set_points, monkeypatch, tmp_path
):
    """Of two set points and nothing else the first model breaks its budget elsewhere."""
    searches = []
    monkeypatch.setattr(set_points, "EVENLY_SEARCHED", 2)
    of = LongMotion.of

    def blind(*given):
        found = of(*given)
        peaks = np.abs(gd.decompose(two_link, long_swing).torque.values).argmax(axis=0)
        few = long_swing.at(np.unique([0, *peaks, LONG - 1]))
        return dataclasses.replace(found, dataset=gd.decompose(two_link, few, christoffel=False))

    monkeypatch.setattr(LongMotion, "of", blind)
    exceeding = LongMotion._exceeding
    monkeypatch.setattr(LongMotion, "_exceeding", lambda *given: searches.append(1) or exceeding(*given))
    found = gd.analyze(two_link, long_swing, level=level, budget="3%", at_set_points=at_set_points)
    assert (len(searches) > 1) == (level == "term")
    for model in (found.model, found.element_model):
        torque = model.torque(long_swing.q, long_swing.qd, long_swing.qdd)
        errors = np.abs(torque - gd.decompose(two_link, long_swing).torque.values).max(axis=0)
        assert (errors <= model.accuracy.allowed).all()
        np.testing.assert_allclose(model.accuracy.errors.largest, errors, rtol=1e-10, atol=1e-12)
        assert model.accuracy.fitted_on["set_points"] == LONG
    gd.tables.save_results(found, tmp_path / "analysis.h5")
    assert gd.load_findings(tmp_path / "analysis.h5").model.operations == found.model.operations


def test_every_extreme_is_drawn(two_link, long_swing):
    dataset = gd.decompose(two_link, long_swing)
    points, shown = drawn(dataset)
    assert [points[0], points[-1]] == [0, LONG - 1]
    assert (np.diff(points) > 0).all()
    assert len(points) < LONG
    length = -(-LONG // STRETCHES)
    for name in ("inertia", "coriolis_centrifugal", "coriolis", "gravity_loading"):
        whole, some = dataset[name].values, shown[name].values
        for start in range(0, LONG, length):
            inside, every = some[(points >= start) & (points < start + length)], whole[start : start + length]
            np.testing.assert_array_equal(inside.min(axis=0), every.min(axis=0))
            np.testing.assert_array_equal(inside.max(axis=0), every.max(axis=0))


def test_it_comes_back_from_its_file_and_later_damage_is_named(two_link, long_swing, long_findings, tmp_path):
    path = tmp_path / "analysis.h5"
    gd.tables.save_results(long_findings, path)
    read = gd.load_findings(path)
    every = read.tables["every_set_point"]
    assert not any(variable._in_memory for variable in every.data_vars.values())
    kept = gd.decompose(two_link, long_swing, christoffel=False)
    for name in set(every.data_vars) & set(kept.data_vars):
        # Blocks begin elsewhere, as above.
        np.testing.assert_allclose(every[name], kept[name], rtol=0, atol=8e-16 * abs(kept[name]).max())
    torque = read.model.torque(long_swing.q, long_swing.qd, long_swing.qdd)
    np.testing.assert_allclose(every.simplified_torque, torque, rtol=1e-13)
    assert "christoffel" not in every
    assert page_of(main_report(dataclasses.replace(read, proof=long_findings.proof))) == page_of(
        main_report(long_findings)
    )
    gd.tables.save_results(read, path)  # over the file that is being read
    read = gd.load_findings(path)
    every = read.tables["every_set_point"]
    assert every.inertia.shape[0] == LONG
    # What was read once would be taken from HDF5's cache.
    written = long_findings.tables["every_set_point"].inertia
    values = written.isel(time=slice(LONG - 9, LONG - 7)).values.tobytes()
    raw = bytearray(path.read_bytes())
    raw[raw.rindex(values)] ^= 1
    path.write_bytes(raw)
    with pytest.raises(gd.GdAnalyzeError) as caught:
        every.inertia.load()
    assert str(path) in caught.value.details["where"]


def test_what_is_stored_of_a_long_motion_can_be_chosen(two_link, long_swing, monkeypatch):
    every = gd.analyze(two_link, long_swing, level="element", christoffel=True)
    assert {"christoffel", "inertia"} <= {*every.tables["every_set_point"]}
    some = gd.analyze(two_link, long_swing, level="element", every_set_point=False)
    assert "every_set_point" not in some.tables
    monkeypatch.setattr(set_points, "MOST_STORED", LONG - 1)
    assert "every_set_point" not in gd.analyze(two_link, long_swing, level="element").tables


PEAK = """
import resource, sys
import gd_analyze as gd
from test_long_trajectories import swinging

arm = gd.load_arm("puma560")
motion = swinging(6, int(sys.argv[1]))
gd.analyze(arm, motion, sys.argv[2], level="element", budget="20%", formats=("h5", "json", "csv", "html"))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="ru_maxrss has other units elsewhere")
def test_the_peak_does_not_grow_with_the_decomposition(tmp_path):
    """Per set point of a six-joint arm there stay 8 bytes each of
    - time, q, qd and qdd: 19 numbers, as made and in the trajectory, and 12 sines and cosines.
    That is 400 bytes; blocks and searches take the same of any motion, but for some MB. D, h and h_ijk by
    effect are 540 numbers, 4 320 bytes, and what each part makes of torque 324 numbers, 2 592 bytes.
    """
    few, many = 10_000, 40_000
    peaks = []
    for count in (few, many):
        command = [sys.executable, "-c", PEAK, str(count), str(tmp_path / str(count))]
        folder = Path(__file__).parent
        shared = {
            "PYTHONPATH": os.pathsep.join([str(folder.parent / "helpers"), os.environ.get("PYTHONPATH", "")])
        }
        ran = subprocess.run(
            command, capture_output=True, text=True, check=True, cwd=folder, env=os.environ | shared
        )
        peaks.append(int(ran.stdout))
    assert peaks[1] - peaks[0] < 970 * (many - few)
