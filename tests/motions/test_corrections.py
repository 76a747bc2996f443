"""Corrections of a log: what was done to its numbers is undone, and options that fit no arm are refused."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.errors import GdAnalyzeError, UsageError, in_options
from gd_analyze.motions.correction import Correction
from gd_analyze.motions.corrections import as_options, typed
from gd_analyze.types import Reading
from remedies import typed as read_again

EPS = float(np.finfo(float).eps)


def correction_of(arm, **words) -> Correction:
    reading = Reading.of(**words)
    return reading.corrections.of_arm(arm, reading.torque_constant or ())


def arrays(n: int, rows: int = 50) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(0)
    return {role: rng.normal(size=(rows, n)) for role in ("q", "qd", "qdd", "torque")}


@pytest.mark.parametrize("couple", ["q3=q3-q2", "q3=q2+q3", "q2=0.5*q1-q2", "q1=2*q1"])
@given(signs=st.lists(st.sampled_from([-1.0, 1.0]), min_size=6, max_size=6))
def test_power_stays(puma, couple, signs):
    """Coupled and reversed joints do the same work."""
    logged = arrays(6)
    corrected = correction_of(puma, couple=couple, position_sign=signs).applied(np.arange(50.0), logged)
    before, after = ((x["torque"] * x["qd"]).sum(axis=1) for x in (logged, corrected))
    # Six products of numbers of some units, and as many sums in the coupled ones.
    assert np.abs(before - after).max() < 100 * EPS * np.abs(logged["torque"] * logged["qd"]).max()
    assert np.linalg.matrix_rank(corrected["q"]) == 6


def test_each_does_what_it_says(puma):
    """Signs, an offset by number and by name, and the sum that names a joint."""
    logged, time = arrays(6), np.arange(50.0)
    name = puma.joints[2].name
    corrected = correction_of(puma, offset=["2=90deg", f"{name}=0.5"], torque_sign="-1").applied(time, logged)
    assert np.array_equal(corrected["torque"], -logged["torque"])
    assert np.array_equal(corrected["qd"], logged["qd"])
    assert np.allclose(corrected["q"] - logged["q"], [0, np.pi / 2, 0.5, 0, 0, 0], atol=10 * EPS)
    corrected = correction_of(puma, couple=["q3=q3-q2"]).applied(time, logged)
    assert np.array_equal(corrected["q"][:, 2], logged["q"][:, 2] - logged["q"][:, 1])
    assert np.array_equal(corrected["torque"][:, 1], logged["torque"][:, 1] + logged["torque"][:, 2])


@pytest.mark.parametrize("lag", ["4ms", "-20ms", "0.03s", "2000us"])
def test_late_torques_come_earlier(puma, lag):
    """A line is shifted exactly; beyond the log's ends there is nothing."""
    time = np.arange(0.0, 2.0, 0.01)
    torque = np.outer(time, np.arange(1.0, 7.0))
    correction = correction_of(puma, lag=lag)
    corrected = correction.applied(time, {"q": torque, "torque": torque})["torque"]
    expected = np.outer(time + correction.lag, np.arange(1.0, 7.0))
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
        ({"couple": ["q3=q3 q2"]}, "--couple"), ({"couple": ["q1=q1+1e20*q2"]}, "--couple"),
        ({"couple": ["q1=q1+1000*q2", "q2=q2+1000*q1"]}, "--couple"),
        ({"torque_constant": "10,10"}, "--torque-constant"),
        ({"lag": "4"}, "--lag"), ({"lag": "1000s"}, "--lag"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(puma, words, option):
    with pytest.raises(GdAnalyzeError) as caught:
        correction_of(puma, **words)
    assert option in caught.value.with_options()
    if "torque_constant" in words:
        return  # the next step shows none
    # The options that the next step shows are accepted.
    shown = re.findall(r"(--[a-z-]+) ([^\s,;]+(?:,-?1)*)", in_options(caught.value.details["next"]))
    assert shown
    for name, word in shown:
        key = name.removeprefix("--").replace("-", "_")
        value = word if key in ("lag", "torque_sign", "position_sign") else [word]
        if key.endswith("sign") and word.count(",") == 2:
            continue  # of an arm of three joints
        correction_of(puma, **{key: value})


def test_an_offset_without_a_unit_is_one_of_its_joint():
    """90 of a joint that turns and 200 of one that slides are asked for; with a unit they are taken."""
    arm = gd.load_arm("scara")
    slide = next(k for k, revolute in enumerate(arm.is_revolute, 1) if not revolute)
    q = np.zeros((5, arm.n_joints))
    for word in (f"{slide}=200", f"{slide}=90deg", "1=20mm", "1=7"):
        with pytest.raises(UsageError):
            correction_of(arm, offset=[word])
    correction = correction_of(arm, offset=[f"{slide}=200mm", "1=400deg", "2=-1.5"])
    corrected = correction.applied(np.arange(5.0), {"q": q})
    expected = np.zeros(arm.n_joints)
    expected[[0, 1, slide - 1]] = np.radians(400), -1.5, 0.2
    np.testing.assert_allclose(corrected["q"][0], expected, rtol=1e-15)


@pytest.mark.parametrize("words", [{"lag": "4ms"}, {"torque_sign": "-1"}])
def test_no_torques_to_correct(two_link, words, tmp_path):
    path = tmp_path / "log.csv"
    time = np.arange(0.0, 2.0, 0.01)
    rows = np.column_stack([time, np.sin(time), np.cos(time)])
    np.savetxt(path, rows, delimiter=",", header="time,q1,q2", comments="")
    with pytest.raises(UsageError):
        gd.read_trajectory(path, two_link, Reading.of(**words, measured=True))


FACTORS = st.one_of(
    st.sampled_from([1.0, -1.0, 0.0174532925, 1e-3]), st.floats(0.2, 5.0), st.floats(-5.0, -0.2)
)
SIGNS = st.one_of(st.just([]), st.lists(st.sampled_from([1.0, -1.0]), min_size=6, max_size=6))


@st.composite
def words_of_corrections(draw: st.DrawFn) -> dict:
    """Words for an arm of six joints whose third slides."""
    sums = []
    for _ in range(draw(st.integers(0, 4))):
        i, j = draw(st.permutations(range(1, 7)))[:2]
        own, other = draw(FACTORS), draw(st.one_of(st.just(0.0), FACTORS))
        sums.append(f"q{i}={own:.9f}*q{i}{other:+.9f}*q{j}")
    angles, lengths = st.floats(-6.0, 6.0), st.floats(-9.0, 9.0)
    return {
        "torque_constant": draw(st.one_of(st.none(), st.lists(FACTORS, min_size=6, max_size=6))),
        "couple": sums,
        "position_sign": draw(SIGNS),
        "torque_sign": draw(SIGNS),
        "offset": [f"1={draw(angles)!r}rad", f"3={draw(lengths)!r}m"] if draw(st.booleans()) else [],
        "lag": draw(st.one_of(st.just(0.0), st.floats(-0.1, 0.1))),
    }


@given(words=words_of_corrections())
def test_a_correction_is_typed_as_it_was(words):
    """Words of options become numbers, and these words of options which make the same numbers again."""
    arm = gd.load_arm("stanford")
    correction = correction_of(arm, **words)
    reading = read_again(as_options(typed(correction, arm.is_revolute))) or Reading()
    again = reading.corrections.of_arm(arm, reading.torque_constant or ())
    # Twelve digits of every factor; torques go by an inverse, of sums that go by another.
    tolerance = 1e-11 * np.linalg.cond(correction.position) ** 2
    for name in ("position", "torque"):
        before, after = getattr(correction, name), getattr(again, name)
        assert np.abs(before - after).max() <= tolerance * np.abs(before).max()
    assert np.array_equal(again.offset, correction.offset)
    assert again.lag == correction.lag


def test_a_log_says_how_it_was_corrected(two_link, tmp_path):
    """Options go into the motion's origin, and the words can be typed again."""
    path = tmp_path / "log.csv"
    time = np.arange(0.0, 2.0, 0.01)
    rows = np.column_stack([time, np.sin(time), np.cos(time), 2 * time, 3 * time])
    np.savetxt(path, rows, delimiter=",", header="time,q1,q2,tau1,tau2", comments="")
    reading = gd.types.Reading.of(torque_sign="-1,1", offset=["1=90deg"], measured=True)
    motion = gd.read_trajectory(path, two_link, reading)
    assert "--torque-sign -1,1 --offset 1=90deg" in motion.origin
    assert motion.recording is not None
    assert motion.recording.torque is not None
    assert np.allclose(motion.recording.torque, np.column_stack([-2 * time, 3 * time]))


@pytest.mark.parametrize(
    "words",
    [
        *({"torque_constant": "1,x"}, {"torque_constant": "1,0,1"}, {"map": ["q"]}, {"map": ["time=none"]}),
        *({"torque_sign": "up"}, {"lag": "4"}, {"offset": ["3"]}, {"offset": ["3=x"]}),
    ],
)
def test_every_option_of_reading_that_cannot_be_read_says_what_to_type(words):
    with pytest.raises(GdAnalyzeError) as caught:
        Reading.of(**words)
    assert caught.value.details["next"]
    assert caught.value.details["expected"]
