"""The results file: open to plain xarray and h5py, exact, and never half there."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from hypothesis import assume, given
from hypothesis import strategies as st

from gd_analyze.certification import Box, certify
from gd_analyze.errors import OutputError, StoreError
from gd_analyze.levels import TERM, Budget, ExactDynamics
from gd_analyze.main_job.folder import write_findings
from gd_analyze.results import hdf5_writer, load_findings, load_results, save_results, store
from gd_analyze.results.hdf5_layout import OF_SCALES
from gd_analyze.results.seal import seal
from gd_analyze.schema import GROUPS, require_numbers
from gd_analyze.search import rank_terms, trade_off
from gd_analyze.search.budget_path import budget_path
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
        assert inertia.attrs["equation"].decode() == "[FGL87] Eq. (3.4-25)"
        assert inertia.attrs["dims"].decode() == "time effect joint joint_j"
        assert file["decomposition/effect"].asstr()[:].tolist() == ["translation", "rotation"]
        assert file.attrs["command"].decode() == "gd-analyze puma560"
        check = file["cross_check"]
        assert (check["largest_difference"][:] <= check["round_off_bound"][:]).all()
        assert file.attrs["warnings"].decode().startswith("odd")
        assert file.attrs["gd_analyze"]


def test_every_declared_attribute_is_stored(stored):
    with h5py.File(stored) as file:
        for group, variables in GROUPS.items():
            for name, variable in variables.items():
                if name == "drive_torque" or f"{group}/{name}" in file:
                    attributes = file[f"{group}/{name}"].attrs
                    for key, value in variable.attributes([True] * 6).items():
                        assert attributes[key].decode() == value, (group, name, key)


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


def test_what_is_not_known_may_be_no_number(swing_findings):
    for group, table in swing_findings.tables.items():
        for name, array in table.variables.items():
            require_numbers(array.values, str(name), group)
    require_numbers(np.array([np.nan]), "certified", "beyond")
    with pytest.raises(StoreError):
        require_numbers(np.array([np.inf]), "certified", "beyond")


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
    path = budget_path(exact, Budget(), puma_findings.model)
    factors, through = curve["factor"].values.tolist(), {(TERM, False): path}
    for point in trade_off(exact, factors=factors, thorough=False, through=through):
        kind = f"{point.level} refit" if point.refit else point.level.name
        assert curve.sel(kind=kind, factor=point.factor) == point.operations.total
    assert tree["budgets"]["operations"].values.tolist() == [model.operations.total for model in path]
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
from test_store import MUTATIONS

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


def test_an_exception_while_writing_keeps_the_old_file(swing_findings, tmp_path, monkeypatch):
    path = tmp_path / "analysis.h5"
    save_results(swing_findings, path)
    old = path.read_bytes()

    def fail(path, *_):
        path.write_bytes(b"half")
        raise RuntimeError("midway")

    monkeypatch.setattr(store, "write_tables", fail)
    with pytest.raises(RuntimeError, match="midway"):
        save_results(swing_findings, path)
    assert path.read_bytes() == old
    assert names_in(tmp_path) == ["analysis.h5"]


def test_unwritable(swing_findings, blocked_folder):
    with pytest.raises(OutputError):
        save_results(swing_findings, blocked_folder / "analysis.h5")


KILLED_MIDWAY = """
import sys
import gd_analyze as gd
from gd_analyze.results import store

write = store.write_tables

def stall(path, *rest):
    write(path, *rest)
    with open(path, "r+b") as file:
        file.truncate(1000)
    print("writing", flush=True)
    sys.stdin.read()

arm = gd.load_arm("two_link")
findings = gd.find(arm, gd.read_trajectory("two-link-swing", arm))
store.write_tables = stall
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
