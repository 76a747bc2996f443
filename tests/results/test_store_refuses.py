"""What is no sound results file is refused, whatever was done to it."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr
from hypothesis import assume, given
from hypothesis import strategies as st

from gd_analyze import load_findings
from gd_analyze.errors import StoreError
from gd_analyze.results.store import seal
from gd_analyze.schema import ATTRIBUTES, COORDINATES
from gd_analyze.tables import load_results, save_results
from strategies import examples, names_in

Edit = Callable[[h5py.File], Any]


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


# Mutations with the digest made anew, from a seed: in another process, as what loops in C cannot be stopped.
FORGED = """
import sys
from pathlib import Path
import numpy as np
from gd_analyze.errors import StoreError
from gd_analyze.results.store import load_findings
from gd_analyze.results.store import seal
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


@pytest.mark.slow
def test_forged_files_neither_hang_nor_crash(small, tmp_path):
    path = tmp_path / "analysis.h5"
    path.write_bytes(small)
    ran = subprocess.run(
        [sys.executable, "-c", FORGED, str(path), "40"],
        capture_output=True,
        text=True,
        timeout=120,  # of two seconds it takes
        cwd=Path(__file__).parent,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        check=False,
    )
    assert ran.stdout == "done\n", ran.stderr


def test_foreign_hdf5(stored, tmp_path):
    gone = refused(_altered(stored, tmp_path, lambda file: file.__delitem__("dominance")))
    assert "dominance" not in gone.details["found"].split(", ")
    assert "dominance" in gone.details["expected"].split(", ")
    path = tmp_path / "other.h5"
    xr.Dataset({"torque": ("time", [1.0, 2.0])}).to_netcdf(path, engine="h5netcdf")
    seal(path)
    assert "dominance" in refused(path).details["expected"]


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


def remade(name: str, make: Edit) -> Edit:
    """Put something else in the place of a variable, with the same dimensions."""

    def edit(file: h5py.File) -> None:
        dims = file[name].attrs["dims"]
        del file[name]
        if isinstance(made := make(file), (h5py.Dataset, h5py.Group)):
            made.attrs["dims"] = dims

    return edit


Q, NEVER = "decomposition/q", "q is not stored with a checksum"
UNWRITTEN: dict[str, tuple[Edit, str]] = {
    "varying lengths": (
        remade(
            "dominance/element", lambda file: file.create_dataset("dominance/element", data=["D11", "D12"])
        ),
        "element is not stored with a checksum",
    ),
    "larger than the file": (
        remade(Q, lambda file: file.create_dataset(Q, (2**40, 6), "f8", chunks=(4096, 6), fletcher32=True)),
        "is larger than its stored data",
    ),
    "data elsewhere": (
        remade(Q, lambda file: file.create_dataset(Q, (31, 6), "f8", external=[("/etc/passwd", 0, 1488)])),
        NEVER,
    ),
    "a link": (
        remade(Q, lambda file: file.__setitem__(Q, h5py.ExternalLink("elsewhere.h5", "/q"))),
        "q of /decomposition is a link",
    ),
    "a group": (remade(Q, lambda file: file.create_group(Q)), NEVER),
    "an attribute of varying length": (
        lambda file: file["decomposition"].attrs.__setitem__("arm", "any"),
        "attribute arm of /decomposition has a type",
    ),
}


@pytest.mark.parametrize(("edit", "found"), UNWRITTEN.values(), ids=UNWRITTEN.keys())
def test_what_is_never_written_is_not_read(stored, tmp_path, edit, found):
    error = refused(_altered(stored, tmp_path, edit))
    assert found in error.details["found"]


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


def made_again(name: str, values: Any) -> Edit:
    """Put other values in the place of a variable, described and stored in the same way."""

    def edit(file: h5py.File) -> None:
        kept = {
            key: file[name].attrs[key] for key in ("dims", "units", "units_in") if key in file[name].attrs
        }
        del file[name]
        made = file.create_dataset(name, data=values, chunks=np.shape(values), fletcher32=True)
        for key, value in kept.items():
            made.attrs.create(key, np.bytes_(value))

    return edit


def entry(name: str, value: Any, place: Any = 0) -> Edit:
    return lambda file: file[name].__setitem__(place, value)


def attribute(name: str, key: str, value: Any) -> Edit:
    return lambda file: file[name].attrs.create(key, value)


def document(change: Callable[[dict[str, Any]], Any]) -> Edit:
    def edit(file: h5py.File) -> None:
        tree = json.loads(file["documents/json"][()].tobytes())
        change(tree)
        made_again("documents/json", np.frombuffer(json.dumps(tree).encode(), dtype=np.uint8))(file)

    return edit


# What was edited, and the name that the message must have.
EDITS: dict[str, tuple[Edit, str]] = {
    "text as numbers": (made_again("dominance/verdict", np.zeros(7)), "verdict of dominance"),
    "half a precision": (made_again("trajectory/time", np.arange(61, dtype="f2")), "time"),
    "a verdict of its own": (entry("dominance/verdict", b"good"), "verdict of dominance"),
    "a joint too many": (entry("dominance/torque_joint", 3), "torque_joint of dominance"),
    "a joint twice": (entry("decomposition/joint", 2), "joint of decomposition"),
    "another unit": (attribute("decomposition/torque", "units", np.bytes_("N")), "torque of decomposition"),
    "another shape": (attribute("dominance", "threshold", np.zeros(2)), "threshold of dominance"),
    "another kind": (attribute("simplified_model", "drives", 0.0), "drives of simplified_model"),
    "no number": (attribute("dominance", "threshold", np.nan), "threshold of dominance"),
    "a variable less": (lambda file: file.__delitem__("decomposition/torque"), "torque"),
    "a coordinate more": (lambda file: file.copy("dominance/unit", "dominance/colour"), "colour"),
    "an attribute less": (lambda file: file["tube"].attrs.__delitem__("note"), "note"),
    "a negative error": (entry("simplified_model/rms_error", -1.0), "rms_error of simplified_model"),
    "too large": (entry("decomposition/torque", -1e200, (0, 0)), "torque of decomposition"),
    "no model": (document(lambda tree: tree.pop("model")), "model"),
    "a verdict of one motion": (entry("motions/verdict", b"fine", (0, 0)), "verdict of motions"),
}


@pytest.fixture(scope="module")
def everything_stored(everything_found, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("edited") / "analysis.h5"
    save_results(everything_found, path)
    return path


@pytest.mark.parametrize(("edit", "named"), EDITS.values(), ids=EDITS.keys())
def test_what_no_report_can_be_made_of_is_refused(everything_stored, tmp_path, edit, named):
    path = _altered(everything_stored, tmp_path, edit)
    with pytest.raises(StoreError) as caught:
        load_findings(path)
    assert named in caught.value.details["found"]
    assert str(path) in caught.value.details["where"]


def test_every_coordinate_and_attribute_is_declared(measured_findings):
    for group, table in measured_findings.tables.items():
        assert set(table.coords) <= set(COORDINATES[group])
        assert set(table.attrs) - set(ATTRIBUTES.get(group, {})) <= set(measured_findings.provenance)
