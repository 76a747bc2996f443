"""The results file: open to plain xarray and h5py, exact, and never half there."""

from __future__ import annotations

import dataclasses
import time

import h5py
import numpy as np
import pytest
import xarray as xr

from gd_analyze.results.hdf5 import OF_SCALES, sound_file
from gd_analyze.results.store import load_findings, load_results, save_results
from gd_analyze.schema import GROUPS, OPTIONAL_GROUPS
from gd_analyze.studies.study_files import write_findings

# The PUMA states uncertainties.
STORED = set(GROUPS) - OPTIONAL_GROUPS | {"robustness", "stops"}


def test_round_trip_is_exact(stored, puma_findings):
    read = load_results(stored)
    assert set(read.children) == STORED
    for group, table in puma_findings.tables.items():
        xr.testing.assert_identical(read[group].to_dataset().drop_attrs(), table.drop_attrs())
    for name, attribute in puma_findings.provenance.items():
        assert read.attrs[name] == attribute, name


@pytest.mark.parametrize("which", ["puma_findings", "everything_found"])
def test_findings_come_back(which, request, tmp_path):
    """What is read makes the same files again, byte by byte."""
    found = request.getfixturevalue(which)
    save_results(found, tmp_path / "analysis.h5")
    read = load_findings(tmp_path / "analysis.h5")
    assert [*read.ranked_terms.items()] == [*found.ranked_terms.items()]
    assert (read.warnings, read.provenance) == (found.warnings, found.provenance)
    assert read.trajectory.motions == found.trajectory.motions
    assert read.trajectory.fingerprint == found.trajectory.fingerprint
    for findings, folder in ((found, tmp_path / "found"), (read, tmp_path / "read")):
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


@pytest.fixture
def limited():
    """Files end at a size, as on a disk that is full."""
    resource = pytest.importorskip("resource", reason="limits on file size are a matter of POSIX")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_what_is_written_can_be_read_whether_it_fits_or_not(tmp_path, limited, rng):
    """Writes and reads anywhere, as on a file in memory."""
    limited(100_000)
    size = 400_000
    expected = np.zeros(size, np.uint8)
    with pytest.raises(OSError, match="File too large"), sound_file(tmp_path / "x") as file:  # noqa: PT012 - the block is the test
        for _ in range(300):
            start, stop = sorted(rng.integers(0, size, 2).tolist())
            data = rng.integers(0, 256, stop - start, dtype=np.uint8)
            file.seek(start)
            assert file.write(data) == len(data)
            assert file.tell() == stop
            expected[start:stop] = data
            start, stop = sorted(rng.integers(0, size, 2).tolist())
            if file.failure is not None:
                read = bytearray(stop - start)
                file.seek(start)
                assert file.readinto(read) == stop - start
                assert bytes(read) == expected[start:stop].tobytes()
        assert file.failure is not None


@pytest.mark.parametrize("size", [0, 100_000, 3_000_000])
def test_hdf5_closes_a_file_that_did_not_fit(tmp_path, limited, rng, size):
    """Larger than the cache of HDF5, which reads again what it wrote; noise, so that it stays large."""
    limited(size)
    numbers = rng.normal(size=20_000)
    with (  # noqa: PT012 - the block is the test
        pytest.raises(OSError, match="File too large"),
        sound_file(tmp_path / "x.h5") as file,
        h5py.File(file, "w") as written,
    ):
        for k in range(30):
            written.create_dataset(f"group/of/{k}", data=numbers, chunks=(500,), compression=1)
        assert (written["group/of/3"][:] == numbers).all()
    assert (tmp_path / "x.h5").stat().st_size <= size
