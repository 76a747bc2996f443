"""Model files: exact round trip; damaged, foreign and edited files are refused with a way out."""

from __future__ import annotations

import json
import pickle
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from computed_terms import assert_computes
from gd_analyze import Trajectory, load_model, save_model
from gd_analyze.certification.holding import simplify_held
from gd_analyze.errors import ModelError
from gd_analyze.operations.program import plain_program
from gd_analyze.simplification import model_file
from gd_analyze.simplification.element import ELEMENT, model_by_verdicts
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.model import exactly
from gd_analyze.simplification.model_file import measured_at
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.simplification.torque_program import COUNTING, FINAL, ROUGH
from gd_analyze.studies.proof import proven_again
from gd_analyze.tables import states_in_box, states_of
from gd_analyze.types import LEVELS, ExactForm, SimplifiedModel, States
from made_models import assert_same, exact_model, model_of, signed
from recordings import swung
from strategies import arms, arms_with_states, examples

Document = dict[str, Any]


@pytest.fixture
def path(tmp_path) -> Path:
    return tmp_path / "model.json"


@pytest.fixture(scope="module")
def shipped(two_link, swing) -> SimplifiedModel:
    """Made for a shipped trajectory, at which errors can be measured again."""
    return gd.simplify(two_link, swing, "40%", level="term")


@pytest.fixture(scope="module")
def own(two_link, swing) -> SimplifiedModel:
    """Made for a trajectory that only its maker has."""
    return gd.simplify(two_link, unknown(swing), "40%")


@pytest.fixture(scope="module")
def energies(two_link) -> SimplifiedModel:
    return exact_model(two_link, level=ENERGY)


def unknown(motion: Trajectory) -> States:
    known = states_of(motion)
    mine = {"trajectory": "my-own", "trajectory_fingerprint": "0" * 64}
    return States(*known.arrays, {**known.described, **mine})


def changed(
    model: SimplifiedModel, path: Path, change: Callable[[Document], Any], finish: Any = signed
) -> Path:
    """Write a model, change its document, and set the digest right again."""
    save_model(model, path)
    document = json.loads(path.read_text(encoding="utf-8"))
    change(document)
    path.write_text(json.dumps(finish(document)), encoding="utf-8")
    return path


def refused(path: Path) -> ModelError:
    """It must be refused with the file's name and a way out."""
    with pytest.raises(ModelError) as caught:
        load_model(path)
    assert str(path) in caught.value.details["where"]
    assert caught.value.details["next"]
    return caught.value


@pytest.mark.parametrize("level", LEVELS.values(), ids=str)
@examples(3)
@given(case=arms_with_states(max_joints=3))
def test_round_trip_of_any_arm_is_exact(tmp_path_factory, case, level):
    arm, states = case
    model = exact_model(arm, level=level)
    path = tmp_path_factory.mktemp("model") / "model.json"
    save_model(model, path)
    with warnings.catch_warnings(action="ignore", category=gd.GdAnalyzeWarning):  # of links without mass
        again = load_model(path)
    assert_same(model, again, states)


def test_a_searched_one_comes_back(shipped, path, swing):
    save_model(shipped, path)
    again = load_model(path)
    assert_same(shipped, again, states_of(swing))
    assert again.accuracy.steps == shipped.accuracy.steps != ()


# A model that saves nothing is the exact one, whose D, h and c are programs of their own.
BUDGETS = ("10%", "1%", "0.01%")
QUICK = SearchOptions(thorough=False, effort=0.01)


@pytest.mark.parametrize("where", ["motion", "limits"])
@pytest.mark.parametrize(
    "name",
    ["two_link", *(pytest.param(name, marks=pytest.mark.slow) for name in ("scara", "stanford", "puma560"))],
)
def test_every_model_that_is_written_is_read(name, where, tmp_path):
    """Of all shipped arms, levels and budgets; what follows from a file is as its writer had it."""
    arm = gd.load_arm(name)
    states = states_in_box(arm, 12)
    if where == "motion":
        box = gd.types.Box.of(arm)
        start, end = (box.lower + share * (box.upper - box.lower) for share in (0.4, 0.6))
        states = states_of(gd.plan(arm, start, end, 3.0, n_set_points=12))
    exact = gd.types.ExactDynamics.of(arm, states)
    cases = [(level, budget) for level in (TERM, ENERGY) for budget in BUDGETS] + [(ELEMENT, None)]
    saving = set()
    for number, (level, budget) in enumerate(cases):
        if level is ELEMENT:
            model = model_by_verdicts(exact)
        else:
            model = simplify_exact(exact, budget, replace(QUICK, level=level))
        saving.add(model.saves)
        path = tmp_path / f"{number}.json"
        save_model(model, path)
        again = load_model(path)
        assert_same(model, again, states)
        for stated, read in zip(model.functions, again.functions, strict=True):
            assert plain_program(stated) == plain_program(read)
        assert (again.saves, again.is_exact) == (model.saves, model.is_exact)
    assert False in saving


def of_puma(motion, budget: str) -> SimplifiedModel:
    exact = gd.types.ExactDynamics.of("puma560", motion)
    return simplify_exact(exact, budget, SearchOptions(thorough=False))


@pytest.mark.parametrize(
    ("budget", "is_shipped"),
    [("1% or 10% friction", True), ("0.5% limit or 0.01 N m, 1%, 1%, 1%, uncertainty, friction", False)],
)
def test_budgets_are_read_back(pick_and_place, path, budget, is_shipped):
    model = of_puma(pick_and_place if is_shipped else unknown(pick_and_place), budget)
    save_model(model, path)
    again = load_model(path)
    assert again.accuracy.budget == model.accuracy.budget == budget
    assert again.accuracy.measured == is_shipped
    np.testing.assert_array_equal(again.accuracy.allowed, model.accuracy.allowed)
    np.testing.assert_array_equal(again.accuracy.uncertainty, model.accuracy.uncertainty)
    assert again.arm.drives == model.arm.drives
    assert (again.drives, again.notice) == (True, model.notice)


FOREIGN = {
    "empty": b"",
    "truncated": b'{"format": "gd-analyze simplified model", "version": 3,',
    "list": b"[]",
    "other format": b'{"format": "gd-analyze results"}',
    "other version": b'{"format": "gd-analyze simplified model", "version": 2}',
    "nested beyond reason": b"[" * 100_000,
    "thousands of digits": b'{"format": ' + b"9" * 5000 + b"}",
    "binary": bytes(range(256)),
    "a pickle": pickle.dumps(Path),
}


@pytest.mark.parametrize("content", FOREIGN.values(), ids=FOREIGN.keys())
def test_foreign(path, content):
    path.write_bytes(content)
    error = refused(path)
    assert "JSON" not in error.what or "line 1, column" in error.details["where"]


def test_what_is_cut_off_or_lacks_a_field_is_named(shipped, path):
    save_model(shipped, path)
    whole = path.read_text()
    path.write_text(whole[: len(whole) // 2])
    assert "line " in refused(path).details["where"]
    error = refused(changed(shipped, path, lambda document: document.pop("provenance")))
    assert error.details["expected"] == "a field provenance"
    error = refused(changed(shipped, path, lambda document: document["accuracy"]["errors"].pop("rms")))
    assert error.details["where"].endswith("accuracy.errors.rms")
    assert error.details["expected"] == "a field rms"


def test_missing_file_folder_and_a_file_too_large(tmp_path, monkeypatch):
    for missing in (tmp_path / "none.json", tmp_path):
        assert refused(missing).details["where"] == str(missing)
    monkeypatch.setattr(model_file, "LARGEST_FILE", 1000)
    assert refused(Path("/dev/zero")).details["found"].startswith("a file of more")


def scale(joint: int, **factors: float) -> Callable[[Document], None]:
    """Other errors of a joint."""

    def change(document: Document) -> None:
        for name, factor in factors.items():
            document["accuracy"]["errors"][name][joint] *= factor

    return change


def at(place: str, value: Any) -> Callable[[Document], None]:
    """Another value at a place such as "arm links 1 mass"."""

    def change(document: Document) -> None:
        *way, last = (int(key) if key.isdigit() else key for key in place.split())
        inner: Any = document
        for key in way:
            inner = inner[key]
        inner[last] = value

    return change


# Each change fits the types, or nearly, and the digest is set right again; and where it is noticed.
FAULTS = {
    "another level": (at("level", "element"), "terms.0"),
    "other velocities": (at("velocities", "own"), "velocities"),
    "a key less": (lambda d: d["accuracy"].pop("budget"), "accuracy.budget"),
    "a key more": (at("colour", "red"), "colour"),
    "a key more of the accuracy": (at("accuracy operations", 1), "accuracy.operations"),
    "a program, which follows": (at("steps", [["input", "q1"]]), "steps"),
    "a negative mass": (at("arm links 1 mass", -1.0), "arm.links[2].mass"),
    "a link less": (lambda d: d["arm"]["links"].pop(), ""),
    "a length in words": (at("arm joints 0 a", "long"), "arm.joints[1].a"),
    "a key more of the arm": (at("arm links 0 colour", "red"), "arm.links[1].colour"),
    "drives of an arm without": (at("drives", True), ""),
    "a negative error": (at("accuracy errors largest 0", -1.0), "accuracy.errors.largest"),
    "a negative peak": (at("accuracy errors peak_torque 1", -1.0), "accuracy.errors.peak_torque"),
    "a budget of words": (at("accuracy budget", "as agreed"), ""),
    "a budget of friction that the arm does not state": (at("accuracy budget", "10% friction"), ""),
    "not finite": (at("accuracy errors rms 0", float("nan")), "accuracy.errors.rms"),
    "an error in words": (at("accuracy errors rms 0", "0.1"), "accuracy.errors.rms"),
    "errors too few": (lambda d: d["accuracy"]["errors"]["rms"].pop(), "rms"),
    "uncertainties too few": (at("accuracy uncertainty", [1.0]), "uncertainty"),
    "a negative gamma": (at("accuracy gamma", -0.1), "accuracy.gamma"),
    "gamma in words": (at("accuracy gamma", "below 1"), "accuracy.gamma"),
    "states of nothing": (at("accuracy fitted_on", {"moon": "full"}), "accuracy.fitted_on"),
    "states in words": (at("accuracy fitted_on set_points", "all"), "accuracy.fitted_on"),
    "a norm of more than all states": (at("accuracy norms", [[0.1, 1.5]]), "accuracy.norms"),
    "a term twice": (lambda d: d["terms"].append(d["terms"][0]), "terms."),
    "terms in words": (at("terms", "some"), "terms"),
    "another row": (at("terms 0 row", 2), "terms.0"),
    "velocity of another joint": (at("terms 0 velocities", [[2, 2]]), "terms.0"),
    "a jerk": (at("terms 0 velocities", [[3, 0]]), "terms.0"),
    "another weight, which follows": (at("terms 0 weight", 1.0), "terms.0"),
    "a factor of nothing": (at("terms 0 factors", [["cos", [0, 0], 1]]), "terms.0"),
    "code": (at("terms 0", "__import__('os')"), "terms.0"),
}


def test_edited_without_a_new_digest(shipped, path):
    for edit in (lambda d: d["terms"].pop(), at("accuracy errors largest 1", 1e-9)):
        assert "digest" in refused(changed(shipped, path, edit, finish=dict)).details["expected"]


@pytest.mark.parametrize("name", FAULTS)
def test_what_cannot_be_is_refused(own, path, name):
    change, where = FAULTS[name]
    assert where in refused(changed(own, path, change)).details["where"]


def test_terms_of_an_energy_are_those_of_the_arm(two_link, path):
    model = model_of(ExactForm(two_link), ENERGY, dict([*ENERGY.terms(ExactForm(two_link)).items()][1:]))
    for change in (at("terms 0 j", -1), at("terms 0 factors", [["tan", [0, 1], 1]])):
        assert "terms.0" in refused(changed(model, path, change)).details["where"]


def test_all_terms_are_one_word(two_link, path):
    """Which terms there are of very small ones, round-off decides: the exact model does not list its own."""
    save_model(exact_model(two_link), path)
    assert json.loads(path.read_text())["terms"] == "all"
    assert load_model(path).drops_nothing


# What a file states, and what is measured again.


@pytest.mark.parametrize("factors", [{"largest": 0.5, "rms": 0.5}, {"peak_torque": 1e9}, {"rms": 0.9}])
def test_errors_are_measured_again_where_the_states_are_at_hand(two_link, shipped, path, factors):
    for model in (shipped, gd.simplify(two_link, states_in_box(two_link, 300, 5), "40%")):
        again = load_model(changed(model, path, scale(1, **factors)))
        assert again.accuracy.measured
        for name in ("peak_torque", "largest", "rms"):
            ours, theirs = (getattr(x.accuracy.errors, name) for x in (model, again))
            np.testing.assert_allclose(theirs, ours, rtol=1e-12)
        np.testing.assert_allclose(again.accuracy.allowed, model.accuracy.allowed, rtol=1e-12)


def test_a_model_that_misses_its_budget_is_refused(shipped, path):
    error = refused(changed(shipped, path, at("accuracy budget", "0.001%")))
    assert "joint" in error.details["where"]
    assert float(error.details["found"]) > 0.0


def test_a_lie_is_a_statement_until_the_states_are_there(own, path, swing):
    stated = load_model(changed(own, path, scale(0, peak_torque=1e9)))
    assert not stated.accuracy.measured
    assert stated.accuracy.errors.peak_torque[0] == 1e9 * own.accuracy.errors.peak_torque[0]
    measured = measured_at(stated, states_of(swing)).accuracy
    assert measured.measured
    np.testing.assert_allclose(measured.errors.peak_torque, own.accuracy.errors.peak_torque, rtol=1e-12)
    with pytest.raises(ModelError, match="misses its budget"):
        measured_at(load_model(changed(own, path, at("accuracy budget", "0.001%"))), states_of(swing))


@pytest.mark.parametrize("allowed", [1e6, 0.0])
def test_what_a_budget_allows_follows_from_it(own, path, allowed):
    again = load_model(changed(own, path, at("accuracy allowed 0", allowed)))
    np.testing.assert_array_equal(again.accuracy.allowed, own.accuracy.allowed)


def test_a_claim_to_be_measured_or_proven_is_not_believed(around, path, swing):
    """A file has no way to say so."""
    for name, place in (("measured", "accuracy measured"), ("proven", "accuracy certificate proven_here")):
        again = load_model(changed(around, path, at(place, True))).accuracy
        assert not again.certificate.proven_here, name
    unmeasured = replace(around, accuracy=replace(around.accuracy, fitted_on=unknown(swing).described))
    assert not load_model(changed(unmeasured, path, at("accuracy measured", True))).accuracy.measured


def test_gamma_is_at_least_that_of_the_states(pick_and_place, path):
    """Of the torque-only model a file could otherwise say that its D is fit for feedback."""
    model = of_puma(pick_and_place, "10%")
    save_model(model, path)
    gamma = load_model(path).accuracy.gamma
    assert gamma == model.accuracy.gamma > 0.0
    for stated in (0.0, 0.99 * gamma, None):
        again = load_model(changed(model, path, at("accuracy gamma", stated))).accuracy
        assert again.gamma == pytest.approx(gamma, rel=1e-9)
    # Near the states it may be larger.
    assert load_model(changed(model, path, at("accuracy gamma", 2.0))).is_torque_only


def test_gamma_is_a_statement_until_the_states_are_there(pick_and_place, path):
    model = of_puma(unknown(pick_and_place), "10%")
    stated = load_model(changed(model, path, at("accuracy gamma", 0.0)))
    assert (stated.accuracy.gamma, stated.accuracy.measured) == (0.0, False)
    measured = measured_at(stated, states_of(pick_and_place)).accuracy
    assert measured.gamma == pytest.approx(model.accuracy.gamma, rel=1e-9)


def test_several_motions_come_back(two_link, path):
    model = gd.simplify(two_link, [swung(20.0, "slow"), swung(2.2, "fast")], "20%")
    save_model(model, path)
    again = load_model(path).accuracy
    for ours, theirs in zip(model.accuracy.motions, again.motions, strict=True):
        assert (ours.name, ours.fingerprint, ours.set_points) == (
            theirs.name,
            theirs.fingerprint,
            theirs.set_points,
        )
        np.testing.assert_array_equal(theirs.errors.largest, ours.errors.largest)
        # In memory it is a quotient of weights.
        np.testing.assert_allclose(theirs.allowed, ours.allowed, rtol=1e-15 * 8)
    for change in (
        at("accuracy motions 0 errors largest", [1.0]),
        at("accuracy motions 1 set_points", "all"),
        at("accuracy motions 0 colour", "red"),
    ):
        assert "motion" in refused(changed(model, path, change)).details["where"]


def test_the_uncertainty_is_measured_again(pick_and_place, path):
    model = of_puma(pick_and_place, "uncertainty")
    twice = [2.0 * x for x in model.accuracy.uncertainty.tolist()]
    again = load_model(changed(model, path, at("accuracy uncertainty", twice))).accuracy
    np.testing.assert_allclose(again.uncertainty, model.accuracy.uncertainty, rtol=1e-12)
    np.testing.assert_allclose(again.allowed, model.accuracy.allowed, rtol=1e-12)


def test_a_trajectory_is_looked_for_by_name_only_among_those_shipped(own, path, tmp_path):
    """No file and no standard input is read because a model names it."""
    motion = tmp_path / "motion.csv"
    motion.write_text("this would be refused\n", encoding="utf-8")
    for name in ("-", "/dev/zero", str(motion)):
        place = "accuracy fitted_on trajectory"
        assert not load_model(changed(own, path, at(place, name))).accuracy.measured


def test_the_exact_torque_comes_back_by_its_parts(two_link, swing, path):
    """As the main job stores it of an arm of too many terms."""
    exact = gd.types.ExactDynamics.of(two_link, swing)
    model = exactly(exact, ELEMENT, exact.allowed("1%"), "1%")
    save_model(model, path)
    again = load_model(path)
    assert_same(model, again, states_of(swing))
    assert again.is_exact
    assert again.functions.operations == exact.form.functions.operations


# What is proven of a model stands in its file as data.


@pytest.fixture(scope="module")
def certified(two_link) -> SimplifiedModel:
    """Without h: its error is largest at two corners of the velocities, which no drawn state comes near."""
    exact = gd.types.ExactDynamics.of(two_link, gd.tables.states_in_box(two_link, 50))
    model = simplify_held(exact, "40%", gd.types.Box.of(two_link), certified=True)[0]
    assert {term.quantity for term in model.terms} == {"inertia", "gravity_loading"}
    return model


@pytest.fixture(scope="module")
def around(two_link, swing) -> SimplifiedModel:
    exact = gd.types.ExactDynamics.of(two_link, swing)
    return simplify_held(exact, "60%", gd.types.Tube.along(two_link, swing, "0.5deg"), certified=True)[0]


@pytest.mark.parametrize("which", ["certified", "around"])
def test_a_certificate_comes_back_and_is_proven_again(request, path, which):
    model = request.getfixturevalue(which)
    save_model(model, path)
    again = load_model(path)
    assert (model.accuracy.certificate.proven_here, again.accuracy.certificate.proven_here) == (True, False)
    stated = replace(model.accuracy.certificate, proven_here=False)
    for name, value in vars(stated).items():
        np.testing.assert_array_equal(getattr(again.accuracy.certificate, name), value)
    result, holds = proven_again(again)
    assert holds
    assert result.headline == "The certificate holds"

    # A tube's boxes are halved until they reach what is stated, which takes more than that to fail.
    stated = model.accuracy.certificate
    smaller = replace(stated, certified=stated.certified * (0.9999 if which == "certified" else 0.99))
    worse = replace(model, accuracy=replace(model.accuracy, certificate=smaller))
    assert proven_again(worse)[0].headline.startswith("The certificate does not hold")
    assert not proven_again(worse)[1]


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (lambda stated: stated.update(pieces=None), "certificate pieces"),
        (lambda stated: stated["pieces"][0][0].append([0.0, 0.0]), "certificate.pieces"),
        (lambda stated: stated["pieces"].pop(), "certificate pieces"),
        (lambda stated: stated.update(margin="wide"), ""),
        (lambda stated: stated["certified"].__setitem__(0, -1.0), "certificate.certified"),
        (lambda stated: stated["lower"].__setitem__(0, float("inf")), "certificate.lower"),
        (lambda stated: stated["upper"].pop(), "certificate upper"),
        (lambda stated: stated.update(effort=0), "certificate.effort"),
    ],
)
def test_a_certificate_that_cannot_be_is_refused(around, path, change, where):
    forged = changed(around, path, lambda document: change(document["accuracy"]["certificate"]))
    assert where in refused(forged).details["where"]


@pytest.mark.parametrize("which", ["certified", "around"])
@pytest.mark.parametrize("words", ["every state", "the arm's limits", "9° of swing"])
def test_words_of_the_states_follow_from_the_numbers(request, path, which, words):
    model = request.getfixturevalue(which)
    forged = changed(model, path, lambda document: document["accuracy"]["certificate"].update(where=words))
    assert load_model(forged).accuracy.certificate.where == model.accuracy.certificate.where


def test_a_certificate_of_any_size_is_proven_again(around, path):
    """A larger error than any torque of an arm is a bound, too."""

    def loose(document: Document) -> None:
        document["accuracy"]["certificate"]["certified"] = [1e13, 1e13]

    assert proven_again(load_model(changed(around, path, loose)))[1]


@pytest.mark.parametrize("key", ["provenance", "motion"])
def test_text_that_no_file_can_hold_is_refused(own, path, key):
    def halved(document: Document) -> None:
        if key == "provenance":
            document["provenance"]["run"] = "\ud800"
        else:
            document["accuracy"]["fitted_on"]["trajectory"] = "swing \udfff"

    assert "is no text" in refused(changed(own, path, halved)).what


def test_words_are_no_certificate(own, path):
    def words(document: Document) -> None:
        document["accuracy"]["budget"] += ", certified"

    assert refused(changed(own, path, words))


def test_a_certificate_is_about_its_own_motion(two_link, around, path, swing):
    faster = replace(swing, time=swing.time * 2.0, qd=swing.qd / 2.0, qdd=swing.qdd / 4.0, name="slow")
    with pytest.raises(gd.GdAnalyzeError, match="another motion"):
        proven_again(around, faster)
    assert proven_again(around, swing)[1]
    with pytest.raises(gd.GdAnalyzeError, match="states no certificate"):
        proven_again(exact_model(two_link))


@pytest.mark.parametrize("level", [LEVELS["term"], LEVELS["energy"]], ids=str)
@pytest.mark.parametrize("effort", [ROUGH, COUNTING, FINAL])
@examples(3)
@given(arm=arms(max_joints=4), seed=st.integers(0, 2**32 - 1))
def test_what_is_written_computes_its_terms_however_it_is_written(arm, level, effort, seed):
    random = np.random.default_rng(seed)
    form = ExactForm(arm)
    kept = {term: number for term, number in level.terms(form).items() if random.random() < 0.8}
    assert_computes(level.write(form, kept, effort), form, level, kept)
