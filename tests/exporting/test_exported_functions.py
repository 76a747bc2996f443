"""What is exported, before it is printed: functions that are the model's, the exact dynamics', the parts."""

from __future__ import annotations

import numpy as np
import pytest
from exported_cases import LINKS, MODELS, states, subject
from rounded_programs import inputs_of

import gd_analyze as gd
from gd_analyze.dynamics.decomposition import decompose_states, torque_of
from gd_analyze.errors import UsageError
from gd_analyze.exporting.c import float_digits
from gd_analyze.exporting.export import export, export_decomposition, printed
from gd_analyze.exporting.export_input import subject_of_model
from gd_analyze.exporting.languages import LANGUAGES
from made_models import ROUND_OFF, exact_model


def values(function, drawn):
    """Its results by name, (states, ...)."""
    rows = function.program.run(inputs_of(drawn)).T
    found, begin = {}, 0
    for result in function.results:
        found[result.name] = rows[:, begin : begin + result.size].reshape(-1, *result.shape)
        begin += result.size
    return found


def assert_close(found, wanted):
    assert found.shape == wanted.shape
    assert np.abs(found - wanted).max() <= ROUND_OFF * max(1.0, np.abs(wanted).max())


@pytest.mark.parametrize("case", MODELS)
def test_functions_of_a_model_are_the_models(case):
    what, drawn = subject(case), states(case.split()[0])
    model = what.model
    found = {}
    for function in what.functions:
        found |= values(function, drawn)
    np.testing.assert_array_equal(found["tau"], model.torque(*drawn.arrays))
    np.testing.assert_array_equal(found["D"], model.inertia(drawn.q))
    np.testing.assert_array_equal(found["h"], model.coriolis_centrifugal(drawn.q, drawn.qd))
    np.testing.assert_array_equal(found["c"], model.gravity_loading(drawn.q))


@pytest.mark.parametrize("name", LINKS)
def test_functions_of_an_arm_are_its_exact_dynamics(name):
    what, drawn = subject(name), states(name)
    numeric = decompose_states(what.arm, drawn, christoffel=False, drives=what.drives)
    drives = np.diag(what.arm.drive_inertia) if what.drives else 0.0
    wanted = {
        "tau": torque_of(what.arm, drawn, drives=what.drives),
        "D": numeric["inertia"].sum(axis=1) + drives,
        "h": numeric["coriolis_centrifugal"].sum(axis=1),
        "c": numeric["gravity_loading"],
    }
    for function in what.functions:
        for key, found in values(function, drawn).items():
            assert_close(found, wanted[key])


@pytest.mark.parametrize("name", LINKS)
def test_parts_are_those_of_the_decomposition_and_sum_to_the_whole(name):
    (function,) = subject(f"{name} decomposition").functions
    drawn = states(name)
    numeric = decompose_states(subject(name).arm, drawn, christoffel=False, drives=False)
    parts = values(function, drawn)
    for k, effect in enumerate(("tran", "rot")):
        assert_close(parts[f"D_{effect}"], numeric["inertia"][:, k])
        assert_close(parts[f"h_{effect}"], numeric["coriolis_centrifugal"][:, k])
    assert_close(parts["c"], numeric["gravity_loading"])
    inertia, h = parts["D_tran"] + parts["D_rot"], parts["h_tran"] + parts["h_rot"]
    torque = np.einsum("tij,tj->ti", inertia, drawn.qdd) + h + parts["c"]
    assert_close(torque, torque_of(subject(name).arm, drawn, drives=False))


def test_an_arm_is_named_or_given(two_link):
    for given in ("two_link", two_link):
        assert list(export(given, ["c", "python"]).files) == ["two_link.h", "two_link.c", "two_link.py"]
    assert list(export_decomposition("two_link", "c", name="parts").files) == ["parts.h", "parts.c"]
    exported = gd.export("two_link", "c")
    assert repr(exported) == "Exported('two_link', two_link.h, two_link.c)"
    assert "gravity_loading" in exported._repr_html_()


def test_every_language_has_files_of_its_own():
    names = [name for language in LANGUAGES.values() for name in language.names("x")]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("case", ["two_link element", "two_link decomposition", "stanford"])
def test_the_same_is_printed_again(case, tmp_path):
    what = subject(case)
    languages = [x for x in LANGUAGES if x != "latex" or what.torque]
    assert printed(what, languages).files == printed(what, languages).files


@pytest.mark.parametrize("level", ["element", "term", "recursive", "energy"])
def test_a_model_from_its_file_prints_the_same(two_link, swing, level, tmp_path):
    model = gd.simplify(two_link, swing, budget="5%", level=level, effort=0.1)
    gd.save_model(model, tmp_path / "model.json")
    again = gd.load_model(tmp_path / "model.json")
    assert export(model, tuple(LANGUAGES)).files == export(again, tuple(LANGUAGES)).files


@pytest.mark.parametrize(
    ("words", "what", "found"),
    [
        ({"languages": "fortran"}, "nothing is printed in fortran", "fortran"),
        ({"languages": ["c", "rust"]}, "nothing is printed in rust", "rust"),
        ({"languages": "c", "scalar": "half"}, "there is no such type of numbers", "half in c"),
        ({"languages": "python", "scalar": "float"}, "there is no such type of numbers", "float in python"),
        ({"languages": "c", "name": "a b"}, "the name is no identifier in every language", "a b"),
        ({"languages": "c", "name": "double"}, "the name is no identifier in every language", "double"),
        ({"languages": "c", "name": ""}, "the name is no identifier in every language", ""),
        ({"languages": "c", "name": "x" * 41}, "the name is no identifier in every language", "x" * 41),
        ({"languages": "c", "name": "a__b"}, "the name is no identifier in every language", "a__b"),
        ({"languages": "c", "name": "json"}, "the name is no identifier in every language", "json"),
    ],
)
def test_what_cannot_be_printed_is_said(words, what, found):
    for call in (export, export_decomposition):
        with pytest.raises(UsageError) as caught:
            call("two_link", **words)
        assert caught.value.what == what
        assert caught.value.details.get("found", "") == found
        assert caught.value.details["expected"]


def test_a_name_that_is_advised_is_taken():
    for name in ("a b", "double", "", "7", "x" * 60, "a__b", "double" * 9, "Ω"):
        with pytest.raises(UsageError) as caught:
            export("two_link", "c", name=name)
        advised = caught.value.details["next"].removesuffix(" would do")
        assert export("two_link", "c", name=advised).subject.name == advised


def test_a_certificate_of_another_arm_or_of_a_tube_is_refused(two_link, swing):
    model = exact_model(two_link)
    other = subject("stanford energy").certificate
    with pytest.raises(UsageError, match="the certificate does not fit the model") as caught:
        subject_of_model(model, None, other)
    assert caught.value.details["expected"] == "bounds of 2 joints over a box"
    assert caught.value.details["found"] == "bounds of 6 joints over a box"
    tube = gd.certify(model, gd.Tube.along(two_link, swing))
    with pytest.raises(UsageError, match="the certificate does not fit the model"):
        subject_of_model(model, None, tube)


def test_a_decomposition_has_no_equations_of_its_own():
    with pytest.raises(UsageError, match="the decomposition is no document") as caught:
        export_decomposition("two_link", "latex")
    assert "gd-analyze equations" in caught.value.details["next"]


def test_too_large_a_number_for_single_precision_is_refused():
    assert float_digits(0.1) == "0.1f"
    assert float_digits(-2.0) == "(-2.0f)"
    assert float(np.float32(float_digits(1 / 3)[:-1])) == float(np.float32(1 / 3))
    with pytest.raises(UsageError, match="a number of the model is beyond single precision") as caught:
        float_digits(1e39)
    assert caught.value.details["next"] == "take double"
