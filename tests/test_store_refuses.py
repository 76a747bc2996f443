"""What is no sound results file is refused, whatever was done to it."""

from __future__ import annotations

import dataclasses
import hashlib
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from hypothesis import assume, given
from hypothesis import strategies as st

from gd_analyze.errors import StoreError
from gd_analyze.results import hdf5_writer, store
from gd_analyze.results.seal import seal
from gd_analyze.results.store import load_results, save_results
from strategies import examples, names_in


def refused(path: Path) -> StoreError:
    with pytest.raises(StoreError) as caught:
        load_results(path)
    assert str(path) in caught.value.details["where"]
    assert caught.value.details["next"]
    return caught.value


def test_unreadable(small, tmp_path, monkeypatch):
    def fail(path):
        raise PermissionError(13, "Permission denied")

    (tmp_path / "analysis.h5").write_bytes(small)
    monkeypatch.setattr(store, "require_sealed", fail)
    error = refused(tmp_path / "analysis.h5")
    assert (error.what, error.details["found"]) == ("cannot read the results file", "Permission denied")


def test_missing(tmp_path):
    assert "no such results file" in refused(tmp_path / "none.h5").what
    assert "no such results file" in refused(tmp_path).what


DAMAGED = {
    "signature only": b"\x89HDF\r\n\x1a\n",
    "signature and noise": b"\x89HDF\r\n\x1a\n" + np.random.default_rng(1).bytes(5000),
}


OTHER = {"empty": b"", "text": b"time,q1\n0,1\n", "random": np.random.default_rng(0).bytes(5000)}


@pytest.mark.parametrize("content", DAMAGED.values(), ids=DAMAGED.keys())
def test_hdf5_without_a_digest(tmp_path, content):
    path = tmp_path / "analysis.h5"
    path.write_bytes(content)
    assert "not as gd-analyze wrote it" in refused(path).what
    assert "no digest" in refused(path).details["found"]
    seal(path)
    assert "the results file is damaged" in refused(path).what


@pytest.mark.parametrize("content", OTHER.values(), ids=OTHER.keys())
def test_not_hdf5(tmp_path, content):
    path = tmp_path / "analysis.h5"
    path.write_bytes(content)
    assert "damaged or not HDF5" in refused(path).what


def test_the_digest_is_that_of_what_comes_before(stored):
    """So that it can be checked without us, as the page says."""
    content, _, line = stored.read_bytes().rpartition(b"\ngd-analyze sha256 ")
    assert line == hashlib.sha256(content).hexdigest().encode() + b"\n"


def test_an_edited_file_is_refused(stored, tmp_path):
    def change(file):
        file["decomposition/torque"][0, 0] += 1.0

    path = _altered(stored, tmp_path, change, again=False)
    assert "not as gd-analyze wrote it" in refused(path).what
    raw = bytearray(stored.read_bytes())
    raw[len(raw) // 2] ^= 1
    path.write_bytes(raw)
    assert "was edited since" in refused(path).what


@examples(25)
@given(st.floats(0.0, 0.999))
def test_truncated(small, tmp_path_factory, share):
    path = tmp_path_factory.mktemp("cut") / "analysis.h5"
    path.write_bytes(small[: int(share * len(small))])
    refused(path)


MUTATIONS = {
    "flip": lambda raw, at, rng: raw[:at] + bytes([raw[at] ^ 1 << int(rng.integers(8))]) + raw[at + 1 :],
    "zero": lambda raw, at, rng: raw[:at] + bytes(16) + raw[at + 16 :],
    "noise": lambda raw, at, rng: raw[:at] + rng.bytes(64) + raw[at + 64 :],
    "cut": lambda raw, at, rng: raw[:at],
    "lose": lambda raw, at, rng: raw[:at] + raw[at + 8 :],
    "repeat": lambda raw, at, rng: raw[: at + 32] + raw[at:],
}


@examples(200)
@given(st.sampled_from([*MUTATIONS]), st.floats(0.0, 0.999), st.integers(0, 2**32 - 1))
def test_any_damage_is_refused(small, tmp_path_factory, kind, share, seed):
    path = tmp_path_factory.mktemp("damaged", numbered=True) / "analysis.h5"
    raw = MUTATIONS[kind](small, int(share * len(small)), np.random.default_rng(seed))
    assume(raw != small)
    path.write_bytes(raw)
    refused(path)


# Mutations with the digest made anew, from a seed: in another process, as what loops in C cannot be stopped.
FORGED = """
import sys
from pathlib import Path
import numpy as np
from gd_analyze.errors import StoreError
from gd_analyze.results import load_findings
from gd_analyze.results.seal import seal
from test_store_refuses import MUTATIONS

path, count = Path(sys.argv[1]), int(sys.argv[2])
body, rng = path.read_bytes().rpartition(b"\\ngd-analyze sha256 ")[0], np.random.default_rng(0)
original = load_findings(path)
heaps = [k for k in range(len(body) - 4) if body[k : k + 4] == b"GCOL"]
for k in range(count):
    kind = list(MUTATIONS)[k % len(MUTATIONS)]
    # The heap of values of varying lengths is where the library is known to loop.
    place = heaps[k % len(heaps)] + int(rng.integers(512)) * 8 if k % 4 == 0 else int(rng.integers(len(body)))
    path.write_bytes(MUTATIONS[kind](body, min(place, len(body) - 1), rng))
    seal(path)
    try:
        read = load_findings(path)
    except StoreError as error:
        assert error.details["next"]
    else:  # what was damaged is not in use
        assert read.provenance == original.provenance
        assert all(read.tables[group].identical(table) for group, table in original.tables.items())
print("done")
"""


def test_forged_files_neither_hang_nor_crash(small, tmp_path):
    path = tmp_path / "analysis.h5"
    path.write_bytes(small)
    ran = subprocess.run(
        [sys.executable, "-c", FORGED, str(path), "300"],
        capture_output=True,
        text=True,
        timeout=120,  # of two seconds it takes
        cwd=Path(__file__).parent,
        check=False,
    )
    assert ran.stdout == "done\n", ran.stderr


def test_foreign_hdf5(tmp_path):
    path = tmp_path / "other.h5"
    with h5py.File(path, "w") as file:
        file["numbers"] = np.arange(3)
    seal(path)
    assert "does not hold gd-analyze results" in refused(path).what
    xr.Dataset({"torque": ("time", [1.0, 2.0])}).to_netcdf(path, engine="h5netcdf")
    assert "no digest" in refused(path).details["found"]
    seal(path)
    assert "does not hold gd-analyze results" in refused(path).what


def _altered(stored: Path, tmp_path: Path, change, again: bool = True) -> Path:
    """Edit a copy, with a digest of what it holds then."""
    path = tmp_path / "analysis.h5"
    path.write_bytes(stored.read_bytes())
    with h5py.File(path, "r+") as file:
        change(file)
    if again:
        seal(path)
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


@pytest.mark.parametrize("schema", [None, np.bytes_("first")])
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


def _varying(file):
    del file["dominance/element"]
    file["dominance/element"] = ["D11", "D12"]
    file["dominance/element"].attrs.create("dims", np.bytes_("element"))


def _larger(file):
    del file["decomposition/q"]
    made = file["decomposition"].create_dataset("q", (2**40, 6), "f8", chunks=(4096, 6), fletcher32=True)
    made.attrs.create("dims", np.bytes_("time joint"))


def _outside(file):
    del file["decomposition/q"]
    made = file["decomposition"].create_dataset("q", (31, 6), "f8", external=[("/etc/passwd", 0, 1488)])
    made.attrs.create("dims", np.bytes_("time joint"))


def _linked(file):
    del file["decomposition/q"]
    file["decomposition/q"] = h5py.ExternalLink("elsewhere.h5", "/q")


def _group(file):
    del file["decomposition/q"]
    file["decomposition"].create_group("q").attrs.create("dims", np.bytes_("time joint"))


def _described(file):
    file["decomposition"].attrs["arm"] = "a string whose length varies"


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (_varying, "element is not stored as variables are"),
        (_larger, "q is larger than what is stored of it"),
        (_outside, "q is not stored as variables are"),
        (_linked, "q of /decomposition is a link"),
        (_group, "q is not stored as variables are"),
        (_described, "attribute arm of /decomposition is of a kind"),
    ],
)
def test_what_is_never_written_is_not_read(stored, tmp_path, change, found):
    error = refused(_altered(stored, tmp_path, change))
    assert error.what == "the results file is damaged"
    assert found in error.details["found"]


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize(("group", "name"), [("decomposition", "inertia"), ("trajectory", "time")])
def test_what_is_no_number_is_neither_written_nor_read(
    swing_findings, tmp_path, monkeypatch, value, group, name
):
    table = swing_findings.tables[group].copy(deep=True)
    values = table[name].values.copy()
    values.flat[3] = value
    broken = (
        table.assign_coords(time=values)
        if name == "time"
        else table.assign({name: (table[name].dims, values)})
    )
    findings = dataclasses.replace(swing_findings, tables=swing_findings.tables | {group: broken})
    with pytest.raises(StoreError, match=f"{name} of {group} holds what is no finite number") as caught:
        save_results(findings, tmp_path / "analysis.h5")
    assert caught.value.details["found"].startswith(f"{value}, entry ")
    assert names_in(tmp_path) == []
    monkeypatch.setattr(hdf5_writer, "require_numbers", lambda *_: None)
    save_results(findings, tmp_path / "analysis.h5")
    assert f"{name} of {group} holds" in refused(tmp_path / "analysis.h5").details["found"]
