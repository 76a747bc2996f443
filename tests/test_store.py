"""The results file: open to plain xarray and h5py, exact, and never half there."""

from __future__ import annotations

import dataclasses
import time

import h5py
import numpy as np
import pytest
import xarray as xr

from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import certify
from gd_analyze.errors import StoreError
from gd_analyze.results.hdf5_layout import OF_SCALES
from gd_analyze.results.store import load_findings, load_results, save_results
from gd_analyze.schema import GROUPS, OPTIONAL_GROUPS, require_numbers
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.ranking import rank_terms
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.term import TERM
from gd_analyze.simplification.trade_off import KINDS, budget_path, trade_off
from gd_analyze.studies.folder import write_findings


def test_round_trip_is_exact(stored, puma_findings):
    read = load_results(stored)
    assert set(read.children) == set(GROUPS) - OPTIONAL_GROUPS
    for group, table in puma_findings.tables.items():
        xr.testing.assert_identical(read[group].to_dataset().drop_attrs(), table.drop_attrs())
    for name, attribute in puma_findings.provenance.items():
        assert read.attrs[name] == attribute, name


@pytest.mark.parametrize("which", ["puma_findings", "swing_findings", "measured_findings"])
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
        assert set(file) == set(GROUPS) - OPTIONAL_GROUPS
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
    # The curve of a recursion only where that is the model.
    assert set(curve["kind"].values) == {"element", "term", "term refit", "energy", "energy refit"}
    path = budget_path(exact, Budget(), puma_findings.model)
    factors, through = curve["factor"].values.tolist(), {(TERM, False): path}
    kinds = [kind for kind in KINDS if kind[0] is not RECURSIVE]
    for point in trade_off(exact, factors=factors, kinds=kinds, thorough=False, through=through):
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
