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
from gd_analyze import Trajectory, load_model, save_model
from gd_analyze.certification.holding import simplify_held
from gd_analyze.errors import ModelError
from gd_analyze.harmonics.expansion import TooLongError
from gd_analyze.operations.program import plain_program
from gd_analyze.simplification import model_claims, model_file
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.model import exactly
from gd_analyze.simplification.model_claims import measured_at, require_terms_computed
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
    error = refused(changed(shipped, path, lambda document: document["errors"][1].pop("rms_error")))
    assert error.details["where"].endswith("errors.1.rms_error")
    assert error.details["expected"] == "a field rms_error"


def test_missing_file_folder_and_a_file_too_large(tmp_path, monkeypatch):
    for missing in (tmp_path / "none.json", tmp_path):
        assert refused(missing).details["where"] == str(missing)
    monkeypatch.setattr(model_file, "LARGEST_FILE", 1000)
    assert refused(Path("/dev/zero")).details["found"].startswith("a file of more")


def scale(joint: int, **factors: float) -> Callable[[Document], None]:
    def change(document: Document) -> None:
        for name, factor in factors.items():
            document["errors"][joint][name] *= factor

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


def constant(place: int, value: Any) -> Callable[[Document], None]:
    """Another word in the first step that multiplies by a constant."""

    def change(document: Document) -> None:
        steps = (step for step in document["steps"] if step[0] == "multiply")
        next(step for step in steps if any(isinstance(x, float) for x in step))[place] = value

    return change


def cosine(*multiples: int, power: int = 1, kind: str = "cos") -> Callable[[Document], None]:
    def change(document: Document) -> None:
        next(term for term in document["terms"] if term["i"] >= 0)["factors"] = [[kind, multiples, power]]

    return change


# Each change fits the types, or nearly, and the digest is set right again.
CONTRADICTIONS = {
    "a term less": lambda d: d["terms"].pop(),
    "another level": at("level", "element"),
    "a key less": lambda d: d.pop("budget"),
    "a key more": at("colour", "red"),
    "a negative mass": at("arm links 1 mass", -1.0),
    "a link less": lambda d: d["arm"]["links"].pop(),
    "a skewed rotation": at("arm links 0 frame rotation 0 0", 2.0),
    "drives of an arm without": at("drives", True),
    "a negative error": scale(0, largest_error=-1.0, rms_error=-1.0),
    "a negative peak": at("errors 1 peak_torque", -1.0),
    "a root mean square above the largest": scale(1, rms_error=1e3),
    "a largest error above the allowed": scale(0, largest_error=1e3),
    "allowed what the budget does not": scale(0, allowed_error=1e6),
    "a peak that the budget is no share of": scale(0, peak_torque=1e9),
    "a budget of words": at("budget", "as agreed"),
    "not finite": at("errors 0 rms_error", float("nan")),
    "errors too few": lambda d: d["errors"].pop(),
    "errors of other joints": lambda d: d["errors"].reverse(),
    "operations, which follow": at("operations", 1),
    "a negative gamma": at("gamma", -0.1),
    "gamma in words": at("gamma", "below 1"),
    "states of nothing": at("fitted_on", {"moon": "full"}),
    "a term twice": lambda d: d["terms"].append(d["terms"][0]),
    "another row": at("terms 0 row", 2),
    "velocity of another joint": at("terms 0 velocities", [[2, 2]]),
    "a jerk": at("terms 0 velocities", [[3, 0]]),
    "weight beyond all masses": at("terms 0 weight", 1.7976931348623157e308),
    "a constant changed": constant(1, 0.123),
    "a constant beyond all masses": constant(1, 1.5e308),
    "code": constant(0, "__import__"),
    "a later step": constant(2, "s999"),
    "an unknown input": at("steps 0", ["input", "q7"]),
    "an output less": lambda d: d["outputs"].pop(),
    "outputs exchanged": lambda d: d["outputs"].reverse(),
}
OF_ENERGY = {
    "below the diagonal": at("terms 0 j", -1),
    "another coefficient": at("terms 0 coefficient", 0.123),
    "unknown kind": cosine(0, 1, kind="tan"),
    "too few multiples": cosine(1),
    "of nothing": cosine(0, 0),
    "beyond the degree": cosine(0, 3),
    "a high power": cosine(0, 1, power=3),
    "a turning joint's variable": cosine(0, 1, kind="power"),
}


def test_edited_without_a_new_digest(shipped, path):
    for edit in (lambda d: d["terms"].pop(), at("errors 1 largest_error", 1e-9)):
        refused(changed(shipped, path, edit, finish=dict))


@pytest.mark.parametrize("change", CONTRADICTIONS.values(), ids=CONTRADICTIONS.keys())
def test_a_contradiction_is_refused(own, path, change):
    refused(changed(own, path, change))


@pytest.mark.parametrize("change", OF_ENERGY.values(), ids=OF_ENERGY.keys())
def test_impossible_energy_terms(energies, path, change):
    refused(changed(energies, path, change))


@pytest.mark.parametrize(
    "change",
    [at("budget", "1% or 20% friction"), at("arm drives 0 coulomb", [1.0, -1.0]), at("arm drives", [])],
    ids=["budget", "friction", "no drives"],
)
def test_what_does_not_come_to_the_allowed_error_is_refused(pick_and_place, path, change):
    refused(changed(of_puma(unknown(pick_and_place), "1% or 10% friction"), path, change))


@pytest.mark.parametrize(
    "factors",
    [
        {"largest_error": 0.5, "rms_error": 0.5},
        {"peak_torque": 1e9, "allowed_error": 1e9},
        {"rms_error": 0.9},
    ],
)
def test_errors_are_measured_again_where_the_states_are_at_hand(two_link, shipped, path, factors):
    for model in (shipped, gd.simplify(two_link, states_in_box(two_link, 300, 5), "40%")):
        for joint in (0, 1):
            details = refused(changed(model, path, scale(joint, **factors))).details
            assert f"joint {joint + 1}" in details["where"]
            assert "measured at" in details["expected"]


def test_a_consistent_lie_is_a_statement_until_the_states_are_there(own, path, swing):
    stated = load_model(changed(own, path, scale(0, peak_torque=1e9, allowed_error=1e9)))
    assert not stated.accuracy.measured
    with pytest.raises(ModelError, match="impossible errors") as caught:
        measured_at(stated, states_of(swing))
    assert "peak_torque of joint 1" in caught.value.details["where"]
    save_model(own, path)
    assert measured_at(load_model(path), states_of(swing)).accuracy.measured


def test_gamma_is_at_least_that_of_the_states(pick_and_place, path):
    """Of the torque-only model a file could otherwise say that its D is fit for feedback."""
    model = of_puma(pick_and_place, "10%")
    save_model(model, path)
    assert load_model(path).accuracy.gamma == model.accuracy.gamma > 0.0
    for forged in (0.0, 0.99 * model.accuracy.gamma):
        details = refused(changed(model, path, at("gamma", forged))).details
        assert details["where"].endswith("gamma")
        assert "measured at" in details["expected"]
    refused(changed(model, path, at("gamma", -1.0)))
    # Near the states it may be larger; a file that does not say so is asked no more.
    assert load_model(changed(model, path, at("gamma", 2.0))).is_torque_only
    unsaid = load_model(changed(model, path, at("gamma", None))).accuracy.gamma
    assert unsaid == pytest.approx(model.accuracy.gamma, rel=1e-9)


def test_gamma_is_a_statement_until_the_states_are_there(pick_and_place, path):
    model = of_puma(unknown(pick_and_place), "10%")
    stated = load_model(changed(model, path, at("gamma", 0.0)))
    assert (stated.accuracy.gamma, stated.accuracy.measured) == (0.0, False)
    with pytest.raises(ModelError, match="impossible errors") as caught:
        measured_at(stated, states_of(pick_and_place))
    assert caught.value.details["where"] == "gamma"


# Where each is noticed, in a model for two motions.
OF_SEVERAL = {
    "largest_error along slow of joint 1": at("motions 0 errors 0 largest_error", 1e3),
    "allowed_error along fast of joint 2": at("motions 1 errors 1 allowed_error", 1e3),
    "peak_torque along slow of joint 1": lambda d: d["motions"][0]["errors"][0].update(
        peak_torque=1e4, allowed_error=2000.0
    ),
    "joints of errors": lambda d: d["motions"][0]["errors"].pop(),
    "set_points of motions": lambda d: d["motions"].pop(),
    "motions": lambda d: d.pop("motions"),
}


@pytest.mark.parametrize("where", OF_SEVERAL)
def test_motions_that_contradict_one_another_are_refused(two_link, path, where):
    model = gd.simplify(two_link, [swung(20.0, "slow"), swung(2.2, "fast")], "20%")
    assert where in refused(changed(model, path, OF_SEVERAL[where])).details["where"]


def test_the_uncertainty_is_measured_again(pick_and_place, path):
    def lie(document: Document) -> None:
        for joint in range(6):
            scale(joint, uncertainty=2.0, allowed_error=2.0)(document)

    error = refused(changed(of_puma(pick_and_place, "uncertainty"), path, lie))
    assert "uncertainty of joint 1" in error.details["where"]


def test_a_trajectory_is_looked_for_by_name_only_among_those_shipped(own, path, tmp_path):
    """No file and no standard input is read because a model names it."""
    motion = tmp_path / "motion.csv"
    motion.write_text("this would be refused\n", encoding="utf-8")
    for name in ("-", "/dev/zero", str(motion)):
        assert not load_model(changed(own, path, at("fitted_on trajectory", name))).accuracy.measured


@pytest.fixture(scope="module", params=LEVELS)
def of_level(request, two_link) -> SimplifiedModel:
    return exact_model(two_link, level=LEVELS[request.param])


class Steps:
    """The steps of a document, to be added to; what is there already is used again."""

    def __init__(self, document: Document) -> None:
        self.document = document

    def __call__(self, operation: str, *arguments: Any) -> str:
        step, steps = [operation, *arguments], self.document["steps"]
        if step not in steps:
            steps.append(step)
        return f"s{steps.index(step)}"


def a_high_power(step: Steps) -> str:
    x = step("input", "q1")
    for _ in range(12):
        x = step("multiply", x, x)
    return x


def nothing_at_known_states(step: Steps) -> str:
    """Zero at the states of a seed, and large elsewhere."""
    product: Any = 1.0
    for known in np.random.default_rng(0).uniform(-1.0, 1.0, (3, 5, 2))[0, :, 1]:
        product = step("multiply", product, step("subtract", step("input", "q2"), float(known)))
    return product


def a_small_term(step: Steps) -> str:
    return step("multiply", 1e-5, step("sin", step("input", "q1")))


def a_term_lost_in_rounding(step: Steps) -> str:
    """1e20 cos q1 - (1e20 cos q1 - 1e-3): what is left is rounded away."""
    large = step("multiply", 1e20, step("cos", step("input", "q1")))
    return step("subtract", large, step("subtract", large, 1e-3))


def an_overflow(step: Steps) -> str:
    x = step("cos", step("input", "q1"))
    for _ in range(4):
        x = step("multiply", 1e99, x)
    return x


def zero_everywhere(step: Steps) -> str:
    """c (sin^2 + cos^2 - 1)."""
    squares = [step("multiply", x, x) for x in (step(kind, step("input", "q1")) for kind in ("sin", "cos"))]
    return step("multiply", 1e-6, step("subtract", step("add", *squares), 1.0))


def with_added(model: SimplifiedModel, path: Path, what: Callable[[Steps], str]) -> Path:
    """Write a model whose first output has something added."""

    def change(document: Document) -> None:
        step = Steps(document)
        document["outputs"][0] = step("add", what(step), document["outputs"][0])

    return changed(model, path, change)


ELSE = [a_high_power, nothing_at_known_states, a_small_term, a_term_lost_in_rounding, an_overflow]


@pytest.fixture(params=["written out", "too long"])
def compared(request, monkeypatch) -> None:
    """Programs too long to be written out are compared at states."""

    def refuse(program: Any, prismatic: Any) -> None:
        raise TooLongError("the program is too long to be written out")

    if request.param == "too long":
        monkeypatch.setattr(model_claims, "expanded", refuse)


@pytest.mark.usefixtures("compared")
@pytest.mark.parametrize("what", ELSE)
def test_what_computes_anything_else_is_refused(of_level, path, what):
    assert refused(with_added(of_level, path, what)).what in (
        "the program does not compute the terms",
        "the program does not compute a torque of an arm: it uses an angle outside of sines and cosines",
        "the program does not compute a torque of an arm: its numbers overflow",
    )


@pytest.mark.usefixtures("compared")
def test_what_is_zero_everywhere_may_be_added(of_level, path):
    again = load_model(with_added(of_level, path, zero_everywhere))
    assert again.operations.total > of_level.operations.total


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


def test_a_bound_near_a_motion_lowered_to_the_sampled_errors_is_refused(around, path):
    def lowered(document: Document) -> None:
        for row, sampled in zip(document["certificate"]["joints"], document["errors"], strict=True):
            row["certified"] = sampled["largest_error"]

    assert "certificate of joint" in refused(changed(around, path, lowered)).details["where"]


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (lambda stated: stated.update(trajectory_fingerprint="0" * 64), "trajectory_fingerprint"),
        (lambda stated: stated["joints"][0].update(piece=None), ""),
        (
            lambda stated: stated["joints"][1]["piece"][1][0].__setitem__(0, 9.0),
            "piece of certificate of joint 2",
        ),
        (lambda stated: stated["joints"][1]["piece"].reverse(), "piece of certificate of joint 2"),
        (
            lambda stated: stated["joints"][0]["piece"].__setitem__(1, stated["joints"][0]["piece"][0]),
            "joint 1",
        ),
        (lambda stated: stated["joints"][0]["piece"][0].append([0.0, 0.0]), "certificate.joints.0.piece"),
        (lambda stated: stated["joints"][0]["piece"][0][0].append(0.0), ""),
    ],
)
def test_pieces_of_a_tube_that_cannot_be_are_refused(around, path, change, where):
    forged = changed(around, path, lambda document: change(document["certificate"]))
    assert where in refused(forged).details["where"]


@pytest.mark.parametrize("which", ["certified", "around"])
@pytest.mark.parametrize(
    ("change", "where"),
    [
        (lambda joint: joint.update(certified=1e-9), "certificate of joint 1"),
        (lambda joint: joint.update(lower=9.0), "certificate of joint 1"),
        (lambda joint: joint.update(certified=-1.0), "certificate.joints.0.certified"),
        (lambda joint: joint.update(joint="another"), "joints of certificate"),
    ],
)
def test_a_certificate_that_cannot_be_is_refused(request, path, which, change, where):
    model = request.getfixturevalue(which)
    forged = changed(model, path, lambda document: change(document["certificate"]["joints"][0]))
    assert where in refused(forged).details["where"]


@pytest.mark.parametrize("which", ["certified", "around"])
@pytest.mark.parametrize("words", ["every state", "the arm's limits", "9° of swing"])
def test_words_of_the_states_follow_from_the_numbers(request, path, which, words):
    model = request.getfixturevalue(which)
    if model.accuracy.certificate.where == words:
        words = "the box"
    forged = changed(model, path, lambda document: document["certificate"].update(where=words))
    assert refused(forged).details["where"] == f"{forged}: certificate.where"


def test_words_are_no_certificate(own, path):
    forged = changed(own, path, lambda document: document.update(budget=f"{document['budget']}, certified"))
    assert refused(forged)


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
def test_what_the_tool_writes_fits_however_it_is_written(arm, level, effort, seed):
    random = np.random.default_rng(seed)
    form = ExactForm(arm)
    kept = {term: number for term, number in level.terms(form).items() if random.random() < 0.8}
    require_terms_computed(model_of(form, level, kept, effort))
