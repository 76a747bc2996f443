"""What is no sound results file is refused, whatever was done to it."""

from __future__ import annotations

import dataclasses
import hashlib
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from hypothesis import assume, given
from hypothesis import strategies as st

from gd_analyze.errors import StoreError
from gd_analyze.results.store import seal
from gd_analyze.tables import load_results, save_results
from strategies import examples, names_in


def refused(path: Path) -> StoreError:
    with pytest.raises(StoreError) as caught:
        load_results(path)
    assert str(path) in caught.value.details["where"]
    assert caught.value.details["next"]
    return caught.value


NOISE = np.random.default_rng(1).bytes(5000)


def test_missing_or_unreadable(tmp_path):
    for path in (tmp_path / "none.h5", tmp_path):
        assert refused(path).details["where"] == str(path)
    memory = Path("/proc/self/mem")  # whose first bytes nobody may read
    if memory.exists():
        assert "cannot read" in refused(memory).what


@pytest.mark.parametrize(
    "content", [b"", b"time,q1\n0,1\n", b"\x89HDF\r\n\x1a\n", b"\x89HDF\r\n\x1a\n" + NOISE]
)
def test_what_no_run_wrote(tmp_path, content):
    path = tmp_path / "analysis.h5"
    path.write_bytes(content)
    is_hdf5 = content.startswith(b"\x89HDF")
    assert ("no digest" if is_hdf5 else "another kind") in refused(path).details["found"]
    seal(path)
    assert refused(path).details["where"] == str(path)


def test_the_digest_is_that_of_what_comes_before(stored):
    """So that it can be checked without us, as the page says."""
    content, _, line = stored.read_bytes().rpartition(b"\ngd-analyze sha256 ")
    assert line == hashlib.sha256(content).hexdigest().encode() + b"\n"


def test_an_edited_file_is_refused(stored, tmp_path):
    def change(file):
        file["decomposition/torque"][0, 0] += 1.0

    path = _altered(stored, tmp_path, change, again=False)
    assert "not as" in refused(path).what
    raw = bytearray(stored.read_bytes())
    raw[len(raw) // 2] ^= 1
    path.write_bytes(raw)
    assert "was edited since" in refused(path).what


MUTATIONS = {
    "flip": lambda raw, at, rng: raw[:at] + bytes([raw[at] ^ 1 << int(rng.integers(8))]) + raw[at + 1 :],
    "zero": lambda raw, at, rng: raw[:at] + bytes(16) + raw[at + 16 :],
    "noise": lambda raw, at, rng: raw[:at] + rng.bytes(64) + raw[at + 64 :],
    "cut": lambda raw, at, rng: raw[:at],
    "lose": lambda raw, at, rng: raw[:at] + raw[at + 8 :],
    "repeat": lambda raw, at, rng: raw[: at + 32] + raw[at:],
}


@pytest.mark.parametrize("kind", MUTATIONS)
@examples(8)
@given(share=st.floats(0.0, 0.999), seed=st.integers(0, 2**32 - 1))
def test_any_damage_is_refused(small, tmp_path_factory, kind, share, seed):
    path = tmp_path_factory.mktemp("damaged", numbered=True) / "analysis.h5"
    raw = MUTATIONS[kind](small, int(share * len(small)), np.random.default_rng(seed))
    assume(raw != small)
    path.write_bytes(raw)
    refused(path)


def test_foreign_hdf5(tmp_path):
    path = tmp_path / "other.h5"
    xr.Dataset({"torque": ("time", [1.0, 2.0])}).to_netcdf(path, engine="h5netcdf")
    assert "another program" in refused(path).details["found"]


def _altered(stored: Path, tmp_path: Path, change, again: bool = True) -> Path:
    """Edit a copy, with a digest of what it holds then."""
    path = tmp_path / "analysis.h5"
    path.write_bytes(stored.read_bytes())
    with h5py.File(path, "r+") as file:
        change(file)
    if again:
        seal(path)
    return path


@pytest.mark.parametrize("schema", [1, 99, np.bytes_("first")])
def test_another_schema_version(stored, tmp_path, schema):
    error = refused(_altered(stored, tmp_path, lambda file: file.attrs.__setitem__("schema", schema)))
    assert "another schema version" in error.what


@pytest.mark.parametrize("value", [np.nan, -np.inf, 1e200])
@pytest.mark.parametrize(("group", "name"), [("decomposition", "inertia"), ("trajectory", "time")])
def test_what_is_no_number_is_not_written(swing_findings, tmp_path, value, group, name):
    table = swing_findings.tables[group].copy(deep=True)
    values = table[name].values.copy()
    values.flat[3] = value
    broken = table.assign({name: (table[name].dims, values)})
    findings = dataclasses.replace(swing_findings, tables=swing_findings.tables | {group: broken})
    with pytest.raises(StoreError, match=f"{name} of {group}"):
        save_results(findings, tmp_path / "analysis.h5")
    assert names_in(tmp_path) == []
