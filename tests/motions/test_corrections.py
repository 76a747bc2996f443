"""Corrections of a log: what was done to its numbers is undone, and options that fit no arm are refused."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.errors import GdAnalyzeError, UsageError
from gd_analyze.types import Reading

EPS = float(np.finfo(float).eps)


def corrections_of(**words):
    return Reading.of(**words).corrections


def arrays(n: int, rows: int = 50) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(0)
    return {role: rng.normal(size=(rows, n)) for role in ("q", "qd", "qdd", "torque")}


@pytest.mark.parametrize("couple", ["q3=q3-q2", "q3=q2+q3", "q2=0.5*q1-q2", "q1=2*q1"])
@given(signs=st.lists(st.sampled_from([-1.0, 1.0]), min_size=6, max_size=6))
def test_power_stays(puma, couple, signs):
    """Coupled and reversed joints do the same work."""
    logged = arrays(6)
    corrected = corrections_of(couple=couple, position_sign=signs).applied(np.arange(50.0), logged, puma)
    before, after = ((x["torque"] * x["qd"]).sum(axis=1) for x in (logged, corrected))
    # Six products of numbers of some units, and as many sums in the coupled ones.
    assert np.abs(before - after).max() < 100 * EPS * np.abs(logged["torque"] * logged["qd"]).max()
    assert np.linalg.matrix_rank(corrected["q"]) == 6


def test_each_does_what_it_says(puma):
    """Signs, an offset by number and by name, and the sum that names a joint."""
    logged, time = arrays(6), np.arange(50.0)
    name = puma.joints[2].name
    corrected = corrections_of(offset=["2=90deg", f"{name}=0.5"], torque_sign="-1").applied(
        time, logged, puma
    )
    assert np.array_equal(corrected["torque"], -logged["torque"])
    assert np.array_equal(corrected["qd"], logged["qd"])
    assert np.allclose(corrected["q"] - logged["q"], [0, np.pi / 2, 0.5, 0, 0, 0], atol=10 * EPS)
    corrected = corrections_of(couple=["q3=q3-q2"]).applied(time, logged, puma)
    assert np.array_equal(corrected["q"][:, 2], logged["q"][:, 2] - logged["q"][:, 1])
    assert np.array_equal(corrected["torque"][:, 1], logged["torque"][:, 1] + logged["torque"][:, 2])


@pytest.mark.parametrize("lag", ["4ms", "-20ms", "0.03s", "2000us"])
def test_late_torques_come_earlier(puma, lag):
    """A line is shifted exactly; beyond the log's ends there is nothing."""
    time = np.arange(0.0, 2.0, 0.01)
    torque = np.outer(time, np.arange(1.0, 7.0))
    corrections = corrections_of(lag=lag)
    corrected = corrections.applied(time, {"q": torque, "torque": torque}, puma)["torque"]
    expected = np.outer(time + corrections.lag, np.arange(1.0, 7.0))
    is_finite = np.isfinite(corrected)
    assert is_finite.sum() >= 6 * (200 - 4)
    # Interpolation between numbers up to 12.
    assert np.abs(corrected - expected)[is_finite].max() < 100 * EPS


@pytest.mark.parametrize(
    ("words", "option"),
    [
        ({"torque_sign": "1,2"}, "--torque-sign"), ({"torque_sign": "1,-1"}, "--torque-sign"),
        ({"position_sign": "x"}, "--position-sign"), ({"offset": ["7=1"]}, "--offset"),
        ({"offset": ["elbow"]}, "--offset"), ({"offset": ["2=much"]}, "--offset"),
        ({"offset": ["2=10mm"]}, "--offset"), ({"offset": ["2=90"]}, "--offset"),
        ({"offset": {"2": 90.0}}, "--offset"), ({"offset": ["2=4ms"]}, "--offset"),
        ({"couple": ["q3=q2"]}, "--couple"), ({"couple": ["q3=q3-q9"]}, "--couple"),
        ({"couple": ["q3=q3 q2"]}, "--couple"), ({"lag": "4"}, "--lag"), ({"lag": "1000s"}, "--lag"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(puma, words, option):
    with pytest.raises(UsageError) as caught:
        corrections_of(**words).applied(np.arange(50.0), arrays(6), puma)
    assert option in str(caught.value)
    # The options that the next step shows are accepted.
    shown = re.findall(r"(--[a-z-]+) ([^\s,;]+(?:,-?1)*)", caught.value.details["next"])
    assert shown
    for name, word in shown:
        key = name.removeprefix("--").replace("-", "_")
        value = word if key in ("lag", "torque_sign", "position_sign") else [word]
        if key.endswith("sign") and word.count(",") == 2:
            continue  # of an arm of three joints
        corrections_of(**{key: value}).applied(np.arange(50.0), arrays(6), puma)


def test_an_offset_without_a_unit_is_one_of_its_joint():
    """90 of a joint that turns and 200 of one that slides are asked for; with a unit they are taken."""
    arm = gd.load_arm("scara")
    slide = next(k for k, revolute in enumerate(arm.is_revolute, 1) if not revolute)
    q = np.zeros((5, arm.n_joints))
    for word in (f"{slide}=200", f"{slide}=90deg", "1=20mm", "1=7"):
        with pytest.raises(UsageError):
            corrections_of(offset=[word]).applied(np.arange(5.0), {"q": q}, arm)
    corrected = corrections_of(offset=[f"{slide}=200mm", "1=400deg", "2=-1.5"]).applied(
        np.arange(5.0), {"q": q}, arm
    )
    expected = np.zeros(arm.n_joints)
    expected[[0, 1, slide - 1]] = np.radians(400), -1.5, 0.2
    np.testing.assert_allclose(corrected["q"][0], expected, rtol=1e-15)


def test_no_torques_to_correct(puma):
    logged = {"q": arrays(6)["q"]}
    for words in ({"lag": "4ms"}, {"torque_sign": "-1"}):
        with pytest.raises(UsageError):
            corrections_of(**words).applied(np.arange(50.0), logged, puma)


def test_a_log_says_how_it_was_corrected(two_link, tmp_path):
    """Options go into the motion's origin, and the words can be typed again."""
    path = tmp_path / "log.csv"
    time = np.arange(0.0, 2.0, 0.01)
    rows = np.column_stack([time, np.sin(time), np.cos(time), 2 * time, 3 * time])
    np.savetxt(path, rows, delimiter=",", header="time,q1,q2,tau1,tau2", comments="")
    reading = gd.types.Reading.of(torque_sign="-1,1", offset=["1=90deg"], measured=True)
    motion = gd.read_trajectory(path, two_link, reading)
    assert "--torque-sign -1,1 --offset 1=1.5708" in motion.origin
    assert motion.recording is not None
    assert motion.recording.torque is not None
    assert np.allclose(motion.recording.torque, np.column_stack([-2 * time, 3 * time]))


@pytest.mark.parametrize(
    "words",
    [
        *({"time_unit": "min"}, {"rate": 0.0}, {"rate": 0.004}, {"rate": 1e6}, {"torque_constant": "1,x"}),
        {"torque_constant": "1,0,1"},
        *({"rate": 5.0, "time_unit": "s"}, {"family": "x=y"}, {"map": ["q"]}, {"columns": "q6..q1"}),
        *({"torque_sign": "up"}, {"lag": "4"}, {"offset": ["3"]}, {"offset": ["3=x"]}),
    ],
)
def test_every_option_of_reading_that_cannot_be_read_says_what_to_type(words):
    with pytest.raises(GdAnalyzeError) as caught:
        Reading.of(**words)
    assert caught.value.details["next"]
    assert caught.value.details["expected"]
