"""The results file: open to plain xarray and h5py, exact, and never half there."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.certification import Box, certify
from gd_analyze.errors import OutputError, StoreError
from gd_analyze.levels import ExactDynamics
from gd_analyze.main_job.folder import write_findings
from gd_analyze.results import load_findings, load_results, save_results
from gd_analyze.schema import GROUPS
from gd_analyze.search import rank_terms, trade_off
from strategies import examples, names_in


@pytest.fixture(scope="module")
def stored(puma_findings, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("store") / "analysis.h5"
    save_results(puma_findings, path)
    return path


@pytest.fixture(scope="module")
def small(swing_findings, tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("store") / "analysis.h5"
    save_results(swing_findings, path)
    return path.read_bytes()


def refused(path: Path) -> StoreError:
    with pytest.raises(StoreError) as caught:
        load_results(path)
    assert str(path) in caught.value.details["where"]
    assert caught.value.details["next"]
    return caught.value


def test_round_trip_is_exact(stored, puma_findings):
    read = load_results(stored)
    assert set(read.children) == set(GROUPS)
    for group, table in puma_findings.tables.items():
        xr.testing.assert_identical(read[group].to_dataset().drop_attrs(), table.drop_attrs())
    for name, attribute in puma_findings.provenance.items():
        assert read.attrs[name] == attribute, name


@pytest.mark.parametrize("which", ["puma_findings", "swing_findings"])
def test_findings_come_back(which, request, tmp_path):
    """What is read makes the same reports and the same model file, byte by byte."""
    found = request.getfixturevalue(which)
    save_results(found, tmp_path / "analysis.h5")
    read = load_findings(tmp_path / "analysis.h5")
    assert read.ranked_terms == found.ranked_terms
    assert [*read.ranked_terms] == [*found.ranked_terms]
    assert (read.warnings, read.provenance) == (found.warnings, found.provenance)
    for group, table in found.tables.items():
        xr.testing.assert_equal(read.tables[group], table)
        assert [*read.tables[group].attrs] == [*table.attrs]
    for findings, folder in ((found, tmp_path / "found"), (read, tmp_path / "read")):
        write_findings(findings, folder, ("json", "csv", "html", "pdf"))
    for path in (tmp_path / "found").iterdir():
        assert path.read_bytes() == (tmp_path / "read" / path.name).read_bytes(), path.name


def test_plain_xarray_opens_it(stored, puma_findings):
    with xr.open_datatree(stored) as tree:
        np.testing.assert_array_equal(tree["decomposition/torque"], puma_findings.decomposition.torque)
        assert tree["decomposition/torque"].attrs["units"] == "N m"
        assert tree["decomposition"].attrs["arm"] == "puma560"
        assert tree["dominance"].attrs["threshold"] == 0.1
        assert tree["trajectory"].attrs["name"] == "pick-and-place"
        assert tree["parts/kept"].dtype == bool
        kept = tree["parts"]["part"].values[tree["parts/kept"].values]
        assert set(kept) == {part.label for part in puma_findings.element_model.terms}


def test_plain_h5py_opens_it(stored, puma_findings):
    with h5py.File(stored) as file:
        assert set(file) == set(GROUPS)
        inertia = file["decomposition/inertia"]
        assert inertia.shape == (31, 2, 6, 6)
        np.testing.assert_array_equal(inertia[()], puma_findings.decomposition.inertia)
        assert inertia.attrs["equation"] == "[FGL87] Eq. (3.4-25)"
        assert file["decomposition/effect"].asstr()[:].tolist() == ["translation", "rotation"]
        assert file.attrs["command"] == "gd-analyze puma560"
        check = file["cross_check"]
        assert (check["largest_difference"][:] <= check["round_off_bound"][:]).all()
        assert file.attrs["warnings"].startswith("odd")
        assert file.attrs["gd_analyze"]


def test_every_declared_attribute_is_stored(stored):
    with h5py.File(stored) as file:
        for group, variables in GROUPS.items():
            for name, variable in variables.items():
                if name == "drive_torque" or f"{group}/{name}" in file:
                    attributes = file[f"{group}/{name}"].attrs
                    for key, value in variable.attributes([True] * 6).items():
                        assert attributes[key] == value, (group, name, key)


def test_model_errors_are_stored_with_the_model(stored, puma_findings):
    model = load_results(stored)["simplified_model"]
    error = np.abs(model["torque_error"].values).max(axis=0)
    # ErrorTable takes a share of 1e-12 of the largest torque for no error.
    slack = 1e-12 * np.abs(puma_findings.exact_torque).max()
    assert np.abs(model["largest_error"].values - error).max() <= slack
    assert (model["largest_error"].values <= model["allowed_error"].values).all()
    assert model.attrs["multiplications"] == puma_findings.model.operations.multiplications


def test_ranking_curve_and_certificate_are_stored(stored, puma_findings):
    tree = load_results(stored)
    exact = ExactDynamics.of(puma_findings.arm, puma_findings.trajectory, drives=True)
    ranking = rank_terms(exact)
    assert [term.term for term in ranking.terms] == [*puma_findings.ranked_terms]
    assert tree["terms"]["weight"].values.tolist() == [*puma_findings.ranked_terms.values()]
    # The ranking is repeated from set points of which the decomposition was not at hand.
    np.testing.assert_allclose(
        tree["terms"]["without_share"].values, [term.without_share for term in ranking.terms], rtol=1e-9
    )
    assert tree["terms"].attrs["not_worth_keeping"] == ranking.not_worth_keeping
    curve = tree["trade_off"]["operations"]
    assert set(curve["kind"].values) == {"element", "term", "term refit", "energy", "energy refit"}
    for point in trade_off(exact, factors=curve["factor"].values.tolist(), thorough=False):
        kind = f"{point.level} refit" if point.refit else point.level.name
        assert curve.sel(kind=kind, factor=point.factor) == point.operations.total
    beyond = tree["beyond"]
    certificate = certify(puma_findings.model, Box.around(*exact.states.arrays), effort=5_000)
    np.testing.assert_allclose(beyond["certified"], certificate.certified, rtol=1e-9)
    assert (beyond["certified"].values >= tree["simplified_model"]["largest_error"].values * (1 - 1e-9)).all()
    assert beyond["torque_per_kg"].attrs["units"] == "N m/kg"


def test_lean_results_are_stored_too(swing_findings, tmp_path):
    save_results(swing_findings, tmp_path / "analysis.h5")
    tree = load_results(tmp_path / "analysis.h5")
    assert "inertia_by_link" not in tree["decomposition"]
    assert tree.attrs["warnings"] == ""


def test_missing(tmp_path):
    assert "no such results file" in refused(tmp_path / "none.h5").what
    assert "no such results file" in refused(tmp_path).what


DAMAGED = {
    "empty": b"",
    "text": b"time,q1\n0,1\n",
    "random": np.random.default_rng(0).bytes(5000),
    "signature only": b"\x89HDF\r\n\x1a\n",
    "signature and noise": b"\x89HDF\r\n\x1a\n" + np.random.default_rng(1).bytes(5000),
}


@pytest.mark.parametrize("content", DAMAGED.values(), ids=DAMAGED.keys())
def test_not_hdf5(tmp_path, content):
    path = tmp_path / "analysis.h5"
    path.write_bytes(content)
    assert "damaged or not HDF5" in refused(path).what


@examples(25)
@given(st.floats(0.0, 0.999))
def test_truncated(small, tmp_path_factory, share):
    path = tmp_path_factory.mktemp("cut") / "analysis.h5"
    path.write_bytes(small[: int(share * len(small))])
    refused(path)


@examples(30)
@given(st.floats(0.0, 0.99), st.integers(0, 2**32 - 1))
def test_noise_inside_is_refused_or_left_out_but_never_crashes(small, tmp_path_factory, share, seed):
    """Metadata that make no sense are refused; numbers carry no checksum and may be read as they are."""
    raw = bytearray(small)
    start = int(share * len(raw))
    raw[start : start + 64] = np.random.default_rng(seed).bytes(min(64, len(raw) - start))
    path = tmp_path_factory.mktemp("noise") / "analysis.h5"
    path.write_bytes(raw)
    try:
        read = set(load_results(path).children)
    except StoreError:
        read = set(GROUPS)
    assert read >= set(GROUPS)


def test_foreign_hdf5(tmp_path):
    path = tmp_path / "other.h5"
    with h5py.File(path, "w") as file:
        file["numbers"] = np.arange(3)
    assert "does not hold gd-analyze results" in refused(path).what
    xr.Dataset({"torque": ("time", [1.0, 2.0])}).to_netcdf(path, engine="h5netcdf")
    assert "does not hold gd-analyze results" in refused(path).what


def _altered(stored: Path, tmp_path: Path, change) -> Path:
    path = tmp_path / "analysis.h5"
    path.write_bytes(stored.read_bytes())
    with h5py.File(path, "r+") as file:
        change(file)
    return path


def test_a_group_is_gone(stored, tmp_path):
    def change(file):
        del file["dominance"]

    assert "does not hold" in refused(_altered(stored, tmp_path, change)).what


@pytest.mark.parametrize("schema", [0, 1, 99])
def test_other_schema_version(stored, tmp_path, schema):
    def change(file):
        file.attrs["schema"] = schema

    error = refused(_altered(stored, tmp_path, change))
    assert "another schema version" in error.what
    assert error.details["found"] == str(schema)


@pytest.mark.parametrize("schema", [None, "first"])
def test_schema_version_no_number(stored, tmp_path, schema):
    def change(file):
        del file.attrs["schema"]
        if schema is not None:
            file.attrs["schema"] = schema

    assert "another schema version" in refused(_altered(stored, tmp_path, change)).what


def test_a_variable_is_gone(stored, tmp_path):
    def change(file):
        del file["decomposition/torque"]

    refused(_altered(stored, tmp_path, change))


def test_an_exception_while_writing_keeps_the_old_file(swing_findings, tmp_path, monkeypatch):
    path = tmp_path / "analysis.h5"
    save_results(swing_findings, path)
    old = path.read_bytes()

    def fail(self, file, **options):
        file.write(b"half")
        raise RuntimeError("midway")

    monkeypatch.setattr(xr.DataTree, "to_netcdf", fail)
    with pytest.raises(RuntimeError, match="midway"):
        save_results(swing_findings, path)
    assert path.read_bytes() == old
    assert names_in(tmp_path) == ["analysis.h5"]


def test_unwritable(swing_findings, blocked_folder):
    with pytest.raises(OutputError):
        save_results(swing_findings, blocked_folder / "analysis.h5")


KILLED_MIDWAY = """
import sys
import xarray as xr
import gd_analyze as gd

write = xr.DataTree.to_netcdf

def stall(self, file, **options):
    write(self, file, **options)
    with open(file.name, "r+b") as again:
        again.truncate(1000)
    print("writing", flush=True)
    sys.stdin.read()

arm = gd.load_arm("two_link")
findings = gd.find(arm, gd.read_trajectory("two-link-swing", arm))
xr.DataTree.to_netcdf = stall
gd.save_results(findings, sys.argv[1])
"""


@pytest.mark.skipif(os.name != "posix", reason="SIGKILL is a matter of POSIX")
def test_a_killed_run_leaves_no_half_file(tmp_path):
    path = tmp_path / "analysis.h5"
    with subprocess.Popen(
        [sys.executable, "-c", KILLED_MIDWAY, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"writing\n"
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
    assert not path.exists()
