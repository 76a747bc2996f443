"""An argument of a wrong type is refused with what is expected, by every public function."""

from __future__ import annotations

import inspect
from typing import Any

import numpy as np
import pytest

import gd_analyze as gd

# Values that no argument below takes.
WRONG: list[Any] = [object(), 3.5, {"a": 1}, b"bytes"]


@pytest.fixture(scope="module")
def right(two_link, swing, swing_dataset, swing_findings) -> dict[str, Any]:
    """Right values by the names of arguments."""
    model = swing_findings.model
    return {
        "arm": two_link,
        "trajectory": swing,
        "motions": [swing],
        "model": model,
        "dataset": swing_dataset,
        "exact": gd.types.ExactDynamics.of(two_link, swing),
        "states": gd.tables.states_in_box(two_link, 5),
        "findings": swing_findings,
        "logs": ["log.csv"],
        "path": "nowhere",
        "start": [0.0, 0.0],
        "goal": [1.0, 1.0],
        "torque": lambda t, q, qd: 0.0 * q,
        "duration": 5.0,
        "mass": 0.5,
        "position": [0.0, 0.0, 0.1],
        "languages": "c",
        "table": [{"arm": "two_link", "trajectory": "two-link-swing"}],
        "over_time": gd.tables.dominance_over_time(swing_dataset),
    }


# Arguments of each function, in order.
CALLS: dict[str, str] = {
    "analyze": "arm trajectory",
    "certify": "model",
    "certify_positive_definite": "model",
    "compare_torque": "arm trajectory",
    "decompose": "arm trajectory",
    "diagnose": "arm logs",
    "equations": "arm",
    "evaluate": "model motions",
    "exciting_motion": "arm duration",
    "export": "model languages",
    "export_decomposition": "arm languages",
    "identify": "arm logs",
    "load_arm": "path",
    "load_findings": "path",
    "load_model": "path",
    "plan": "arm start goal duration",
    "pool": "motions",
    "rank": "dataset",
    "regressor": "arm start start start",
    "read_log": "path arm",
    "read_trajectory": "path arm",
    "save_arm": "arm path",
    "save_model": "model path",
    "simplify": "arm trajectory",
    "batch": "table path",
    "trade_off": "exact",
    "write_trajectory": "trajectory path",
    "base_parameters": "arm",
    "tables.cross_check": "arm dataset",
    "tables.decompose_states": "arm states",
    "tables.dominance_over_time": "dataset",
    "tables.harmonics_of": "arm",
    "tables.joint_accelerations": "arm start start goal",
    "tables.load_results": "path",
    "tables.payload_effect": "model states",
    "tables.rank_terms": "exact",
    "tables.robustness": "arm trajectory",
    "tables.save_results": "findings path",
    "tables.simulate": "arm torque start goal duration",
    "tables.states_in_box": "arm",
    "tables.states_of": "trajectory",
    "tables.torque_uncertainty": "arm states",
    "tables.verdicts": "over_time",
    "tables.with_payload": "arm mass position",
}
# Functions of no arguments, or of one that may be any text.
OTHERS = {"builtin_arms", "tables.text_verdicts"}


def test_every_function_is_tried():
    jobs = {name for name in gd.__all__ if inspect.isfunction(getattr(gd, name))}
    steps = {f"tables.{name}" for name in gd.tables.__all__}
    assert jobs | steps == CALLS.keys() | OTHERS


@pytest.mark.parametrize("name", CALLS)
def test_a_wrong_argument_is_refused(name, right, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function: Any = gd
    for part in name.split("."):
        function = getattr(function, part)
    arguments = CALLS[name].split()
    for k, argument in enumerate(arguments):
        for wrong in WRONG:
            if argument in ("duration", "mass") and wrong == 3.5:
                continue
            values = [wrong if j == k else right[other] for j, other in enumerate(arguments)]
            with pytest.raises(gd.GdAnalyzeError) as caught:
                function(*values)
            assert {"where", "expected", "found"} & caught.value.details.keys(), (argument, wrong)
    assert [*tmp_path.iterdir()] == []


# Options of functions, by the function's name: each is refused with the place that it has.
OPTIONS: list[tuple[str, str, Any]] = [
    ("read_trajectory", "reading", {"degrees": True}),
    ("read_trajectory", "treatment", "smooth"),
    ("export", "name", 3),
    ("export", "what", None),
    ("export", "what", [3]),
    ("export", "scalar", 3),
    ("export", "certificate", "proven"),
    ("certify", "effort", "much"),
    ("analyze", "out", 3),
    ("analyze", "formats", 3),
    ("analyze", "settings", "1%"),
    ("analyze", "dominance", "a tenth"),
    ("analyze", "margin", 3j),
    ("simplify", "margin", {"q": 1}),
    ("simplify", "seconds", "long"),
    ("tables.robustness", "samples", "many"),
    ("tables.robustness", "samples", -2),
]


@pytest.mark.parametrize(("name", "option", "wrong"), OPTIONS)
def test_a_wrong_option_is_refused(name, option, wrong, right):
    function: Any = gd
    for part in name.split("."):
        function = getattr(function, part)
    path_of_motion = {"path": "two-link-swing"}
    values = [(right | path_of_motion)[argument] for argument in CALLS[name].split()]
    with pytest.raises(gd.GdAnalyzeError) as caught:
        function(*values, **{option: wrong})
    assert {"where", "expected", "found"} <= caught.value.details.keys()


def flags(of: Any) -> list[str]:
    """Arguments, or fields, that are True or False."""
    parameters = inspect.signature(of).parameters.items()
    return [name for name, value in parameters if value.annotation in ("bool", "bool | None")]


def function_named(name: str) -> Any:
    function: Any = gd
    for part in name.split("."):
        function = getattr(function, part)
    return function


FLAGS = [(name, flag) for name in CALLS for flag in flags(function_named(name))]
SETTINGS = ("Settings", "Reading", "Treatment", "Link")


@pytest.mark.parametrize(("name", "flag"), FLAGS)
def test_what_counts_as_true_is_not_true(name, flag, right):
    """Texts such as "no" count as true, and numbers as one or the other."""
    values = [(right | {"path": "two-link-swing"})[argument] for argument in CALLS[name].split()]
    for wrong in ("no", "", 0, 1, [False]):
        with pytest.raises(gd.GdAnalyzeError) as caught:
            function_named(name)(*values, **{flag: wrong})
        details = caught.value.details
        assert (details["where"], "True" in details["expected"]) == (flag, True)
        assert "False" in details["expected"]


@pytest.mark.parametrize(
    ("name", "flag"), [(name, flag) for name in SETTINGS for flag in flags(getattr(gd.types, name))]
)
def test_what_counts_as_true_is_no_setting(name, flag):
    usual = {"name": "a", "mass": 1.0, "com": np.zeros(3), "inertia_com": np.eye(3)} if name == "Link" else {}
    for wrong in ("no", 0, 1):
        with pytest.raises(gd.GdAnalyzeError) as caught:
            getattr(gd.types, name)(**usual, **{flag: wrong})
        assert caught.value.details["where"] == flag


def test_flags_of_every_kind_are_tried():
    """Public functions have these and no others; NumPy's own True is one."""
    assert {"overwrite", "strict", "drives", "at_set_points", "physical", "allow_violations"} <= {
        x for _, x in FLAGS
    }
    assert gd.types.Settings(at_set_points=np.True_).at_set_points


@pytest.mark.parametrize(
    "name", [name for name in CALLS if "progress" in inspect.signature(function_named(name)).parameters]
)
def test_a_function_is_no_progress(name, right):
    values = [(right | {"path": "two-link-swing"})[argument] for argument in CALLS[name].split()]
    for wrong in (print, None):
        with pytest.raises(gd.GdAnalyzeError) as caught:
            function_named(name)(*values, progress=wrong)
        assert (caught.value.details["where"], "Progress" in caught.value.details["expected"]) == (
            "progress",
            True,
        )


# Arguments that are one of some words, by function.
WORDS = [
    ("analyze", "level"),
    ("analyze", "verdicts"),
    ("analyze", "formats"),
    ("batch", "formats"),
    ("batch", "to"),
    ("evaluate", "fail_over"),
    ("export", "scalar"),
    ("export", "what"),
    ("export_decomposition", "scalar"),
    ("plan", "profile"),
    ("simplify", "level"),
    ("simplify", "verdicts"),
    ("tables.joint_accelerations", "method"),
]


@pytest.mark.parametrize(("name", "argument"), WORDS)
@pytest.mark.parametrize("wrong", ["nonsense", "", 3, True, ["nonsense"], [3], b"term"])
def test_another_word_is_refused(name, argument, wrong, right, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if argument in ("formats", "what", "to") and wrong == "":
        wrong = [""]
    values = [right[other] for other in CALLS[name].split()]
    with pytest.raises(gd.GdAnalyzeError) as caught:
        function_named(name)(*values, **{argument: wrong})
    assert {"where", "expected"} <= caught.value.details.keys()


def test_no_logs_are_refused(two_link):
    with pytest.raises(gd.GdAnalyzeError, match="no logs"):
        gd.identify(two_link, None)


def test_wrong_types_of_values_are_refused():
    time, q = [0.0, 1.0, 2.0], [[0.0], [0.5], [1.0]]
    with pytest.raises(gd.GdAnalyzeError, match="gaps is of a wrong type"):
        gd.Trajectory(time, q, q, q, gaps=("a",))
    with pytest.raises(gd.GdAnalyzeError, match="wrong type"):
        gd.types.Budget.parse(None)


def test_values_and_methods_of_an_arm_take_no_text_for_true(two_link):
    state, dynamics = np.zeros(2), gd.types.ArmDynamics(two_link)
    for call in (
        lambda: gd.types.ExactForm(two_link, "no"),
        lambda: gd.types.ExactDynamics.of(two_link, "two-link-swing", "no"),
        lambda: gd.types.Drivetrain(friction="no"),
        lambda: two_link.counts_drives("no"),
        lambda: dynamics.inertia(state, drives="no"),
        lambda: dynamics.coriolis_centrifugal(state, state, by_effect="no"),
        lambda: dynamics.torque(state, state, state, drives="no"),
        lambda: dynamics.forward_dynamics(state, state, state, drives="no"),
    ):
        with pytest.raises(gd.GdAnalyzeError) as caught:
            call()
        assert "no" in caught.value.details["found"]
