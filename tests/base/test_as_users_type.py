"""What a user types first, task by task, and the near misses with the word that helps."""

from __future__ import annotations

import re

import matplotlib
import numpy as np
import pytest
import xarray as xr
from matplotlib import pyplot

import gd_analyze as gd

matplotlib.use("agg")

Q, QD, QDD = np.random.default_rng(0).uniform(-1.0, 1.0, (3, 5, 2))
ARM, MOTION = "two_link", "two-link-swing"


@pytest.fixture(scope="module")
def model() -> gd.types.SimplifiedModel:
    return gd.simplify(ARM, MOTION, budget=0.05)


@pytest.fixture(scope="module")
def dynamics() -> gd.types.ArmDynamics:
    return gd.types.ArmDynamics(ARM)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("load", "gd.load_arm"),
        ("simplifies", "gd.simplify"),
        ("exports", "gd.export"),
        ("log", "gd.read_log"),
        ("dominance", "gd.rank"),
        ("box", "gd.types.Box"),
        ("states_in_boxes", "gd.tables.states_in_box"),
        ("gravity", "gd.types.ArmDynamics(arm).gravity_loading(q)"),
    ],
)
def test_a_name_that_gd_lacks(name, meant):
    with pytest.raises(AttributeError, match=re.escape(f"did you mean {meant}?")):
        getattr(gd, name)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("gravity", "gravity_loading(q)"),
        ("h", "coriolis_centrifugal(q, qd)"),
        ("mass_matrix", "inertia(q)"),
        ("rnea", "torque(q, qd, qdd)"),
    ],
)
def test_dynamics_by_the_names_of_others(model, dynamics, name, meant):
    for value in (model, dynamics):
        with pytest.raises(AttributeError, match=re.escape(f"{name}; did you mean {meant}?")):
            getattr(value, name)
    with pytest.raises(AttributeError, match=re.escape(f"did you mean gd.types.ArmDynamics(arm).{meant}?")):
        getattr(gd.load_arm(ARM), name)


def test_parts_of_d(dynamics):
    with pytest.raises(AttributeError, match="by_effect=True"):
        _ = dynamics.D_tran
    translation, rotation = np.moveaxis(dynamics.inertia(Q, by_effect=True), 1, 0)
    np.testing.assert_allclose(translation + rotation, dynamics.inertia(Q))


def test_what_is_asked_of_any_object_is_answered_as_python_does(model, dynamics):
    for value in (gd.load_arm(ARM), dynamics, model):
        assert not hasattr(value, "_repr_mimebundle_")
        assert not hasattr(value, "__array_interface__")
        with pytest.raises(AttributeError, match=r"has no colour$"):
            _ = value.colour


def test_a_number_is_a_share_of_peak(model):
    assert model.accuracy.budget == "5%"
    assert gd.types.Settings(budget=0.01).asked == gd.types.Budget.parse("1%")
    assert gd.evaluate(model, MOTION, fail_over=0.9).verdict == "passed"
    for wrong in (5, -0.01, True, float("nan")):
        with pytest.raises(gd.GdAnalyzeError, match="share of peak torque from 0 to 1"):
            gd.simplify(ARM, MOTION, budget=wrong)


def test_equations_of_an_arm_and_of_a_model(model):
    assert str(gd.equations(ARM, "D12")) == "D12 = 0.5 C2 + 0.333"
    assert str(gd.equations(model)) == str(model.equations)
    written = str(gd.equations(model, ["D12", "h"])).splitlines()
    whole = str(model.equations).splitlines()
    assert [line for line in whole if line.startswith(("D12", "h"))] == written[:3]
    with pytest.raises(gd.GdAnalyzeError, match="D11, D12"):
        gd.equations(model, "D13")


def test_methods_are_the_functions(model, tmp_path):
    model.save(tmp_path / "model.json")
    gd.save_model(model, tmp_path / "again.json")
    assert (tmp_path / "model.json").read_bytes() == (tmp_path / "again.json").read_bytes()
    by_method, by_function = model.export("c", tmp_path / "c"), gd.export(model, "c")
    assert by_method.files == by_function.files
    assert {path.name for path in (tmp_path / "c").iterdir()} == by_method.files.keys()


def test_one_word_or_several_of_them():
    exported = gd.export(ARM, "c++", what=("torque", "derivatives"))
    assert exported.files == gd.export(ARM, ["cpp"], what="derivatives").files
    with pytest.raises(gd.GdAnalyzeError, match="did you mean 'regressor'"):
        gd.export(ARM, "c", what="regresor")


def test_dominance_of_an_arm_along_a_motion():
    ranking = gd.rank(ARM, MOTION, threshold=0.2)
    assert ranking.identical(gd.rank(gd.decompose(ARM, MOTION), threshold=0.2))
    with pytest.raises(gd.GdAnalyzeError, match=re.escape("0.01 is 1%")):
        gd.rank(ARM, MOTION, budget="1%")


def test_one_element_is_drawn():
    dataset = gd.decompose(ARM, MOTION)
    (axes,) = dataset.gd.plot.inertia("D12", effects="rotation")
    assert "D₁₂" in axes.get_title(loc="left")
    pyplot.close("all")


def test_a_results_file_says_where_its_tables_are(tmp_path):
    gd.analyze(ARM, MOTION, tmp_path, budget="5%", formats="h5")
    with xr.open_dataset(tmp_path / "analysis.h5") as root:
        assert "dominance" in root.attrs["groups"].split(", ")
        assert eval(root.attrs["open_with"], {"xarray": xr, "file": tmp_path / "analysis.h5"}).verdict.size
        assert "groups" in repr(root)


def test_one_list_of_verdicts():
    findings = gd.analyze(ARM, MOTION, budget="5%")
    frame = findings.decomposition.gd.ranking(budget=0.05)
    (listed,) = re.findall(r"^Gravity +(.*)$", str(findings), re.MULTILINE)
    assert listed.split(", ") == frame.index[frame.verdict == "gravity"].tolist() != []


@pytest.mark.parametrize("drives", [False, True])
def test_the_regressor_times_the_base_parameters_is_the_torque(puma, drives):
    q, qd, qdd = np.random.default_rng(1).uniform(-1.0, 1.0, (3, 2, 4, 6))
    base = gd.base_parameters(puma, drives)
    numbers = np.array([parameter.number for parameter in base])
    columns = gd.regressor("puma560", q, qd, qdd, drives=drives)
    assert columns.shape == (2, 4, 6, len(base))
    torque = gd.types.ArmDynamics(puma).torque(q, qd, qdd, drives=drives)
    # Some hundred products of numbers as large as the torque.
    np.testing.assert_allclose(columns @ numbers, torque, atol=1e-12 * np.abs(torque).max())


def test_an_error_advises_arguments():
    with pytest.raises(gd.GdAnalyzeError) as caught:
        gd.types.Reading.of(map="time=250Hz", offset=["elbow"])
    assert "`offset=['3=90deg']`" in str(caught.value)
    assert "--" not in str(caught.value)
    assert "--offset 3=90deg" in caught.value.with_options({"offset": "--offset"})
