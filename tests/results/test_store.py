"""The results file: open to plain xarray and h5py, exact, and never half there."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest
import xarray as xr

from gd_analyze import load_findings
from gd_analyze.results.hdf5 import OF_SCALES
from gd_analyze.schema import GROUPS
from gd_analyze.simplification.accuracy import PROVEN, STATED
from gd_analyze.studies.study_files import write_findings
from gd_analyze.tables import load_results, save_results
from long_cases import long
from strategies import names_in

# The PUMA states uncertainties.
STORED = set(GROUPS) - {"diagnosis", "every_set_point", "measured_torque", "motions", "recording"}


def test_round_trip_is_exact(stored, puma_findings):
    read = load_results(stored)
    assert set(read.children) == STORED
    for group, table in puma_findings.tables.items():
        xr.testing.assert_identical(read[group].to_dataset().drop_attrs(), table.drop_attrs())
    for name, attribute in puma_findings.provenance.items():
        assert read.attrs[name] == attribute, name


@pytest.mark.parametrize("which", [long("puma_findings"), "everything_found"])
def test_findings_come_back(which, request, tmp_path):
    """What is read makes the same files again, byte by byte."""
    found = request.getfixturevalue(which)
    save_results(found, tmp_path / "analysis.h5")
    read = load_findings(tmp_path / "analysis.h5")
    assert [*read.ranked_terms.items()] == [*found.ranked_terms.items()]
    assert (read.warnings, read.provenance) == (found.warnings, found.provenance)
    assert read.trajectory.motions == found.trajectory.motions
    assert read.trajectory.fingerprint == found.trajectory.fingerprint
    # But for what is said of bounds that a file states.
    assert (found.proof, read.proof) == (PROVEN, STATED)
    proven = dataclasses.replace(read, proof=found.proof)
    for findings, folder in ((found, tmp_path / "found"), (proven, tmp_path / "read")):
        write_findings(findings, folder, ("h5", "json", "csv", "html"))
    for path in (tmp_path / "found").iterdir():
        assert path.read_bytes() == (tmp_path / "read" / path.name).read_bytes(), path.name


def test_plain_xarray_opens_it(stored, puma_findings):
    with xr.open_datatree(stored) as tree:
        np.testing.assert_array_equal(tree["decomposition/torque"], puma_findings.decomposition.torque)
        assert tree["decomposition/torque"].attrs["units"] == "N m"
        assert tree["decomposition"].attrs["arm"] == "puma560"
        kept = tree["parts"]["part"].values[tree["parts/kept_by_element"].values]
        assert set(kept) == {part.label for part in puma_findings.element_model.terms}


def test_plain_h5py_opens_it(stored, puma_findings):
    with h5py.File(stored) as file:
        assert set(file) == STORED
        inertia = file["decomposition/inertia"]
        np.testing.assert_array_equal(inertia[()], puma_findings.decomposition.inertia)
        assert inertia.attrs["equation"].decode() == "[FGL87] Eq. (3.4-25)"
        assert inertia.attrs["dims"].decode() == "time effect joint joint_j"
        assert file["decomposition/effect"].asstr()[:].tolist() == ["translation", "rotation"]
        assert file.attrs["command"].decode() == "gd-analyze puma560"
        assert file.attrs["warnings"].decode().startswith("odd")


def test_everything_has_a_checksum_and_a_fixed_length(stored):
    """Else damage goes unseen, or makes the HDF5 library loop; what xarray alone reads is the exception."""

    def check(name, item):
        for key in set(item.attrs) - OF_SCALES:
            assert item.attrs.get_id(key).dtype.kind in "iufS", (name, key)
        if isinstance(item, h5py.Dataset) and "dims" in item.attrs:
            assert item.fletcher32, name
            assert item.dtype.kind in "iufS", name

    with h5py.File(stored) as file:
        check("/", file)
        file.visititems(check)
    # The superblock of HDF5 1.10, the first whose every structure can have a checksum.
    assert stored.read_bytes()[8] >= 3


def test_equal_findings_make_equal_files(stored, puma_findings, tmp_path):
    time.sleep(1.1)  # the file must not tell when it was written: HDF5 would, to the second
    save_results(puma_findings, tmp_path / "again.h5")
    assert (tmp_path / "again.h5").read_bytes() == stored.read_bytes()


def test_text_beyond_ascii(swing_findings, tmp_path):
    odd = "Größe θ → 関節"
    save_results(dataclasses.replace(swing_findings, warnings=(odd, "b")), tmp_path / "analysis.h5")
    assert load_findings(tmp_path / "analysis.h5").warnings == (odd, "b")
    with xr.open_datatree(tmp_path / "analysis.h5") as tree:
        assert tree.attrs["warnings"] == f"{odd}\nb"


FULL = """
import resource, signal, sys
import gd_analyze as gd

findings, size = gd.load_findings(sys.argv[1]), int(sys.argv[3])
resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
try:
    gd.tables.save_results(findings, sys.argv[2])
except gd.GdAnalyzeError as error:
    print(type(error).__name__, error.details["found"])
"""


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="limits on file size are a matter of POSIX")
@pytest.mark.parametrize("size", [long(0), 100_000, long(400_000)])
def test_a_file_that_does_not_fit_is_refused_before_it_is_written(stored, tmp_path, size):
    """In a process of its own: a limit on the size of files stands for a disk that is full."""
    assert stored.stat().st_size > size
    command = [sys.executable, "-c", FULL, str(stored), str(tmp_path / "analysis.h5"), str(size)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == "StorageError File too large\n"
    assert names_in(tmp_path) == []


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="elsewhere free space is compared")
def test_the_room_asked_for_is_enough(stored, puma_findings, tmp_path, monkeypatch):
    reserved = []
    fallocate = os.posix_fallocate
    monkeypatch.setattr(os, "posix_fallocate", lambda *given: reserved.append(given[2]) or fallocate(*given))
    save_results(puma_findings, tmp_path / "analysis.h5")
    assert stored.stat().st_size < reserved[0]
