"""JUnit XML, read back: a case per motion and joint, failures, and names that are anybody's."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.studies.junit import junit_xml
from gd_analyze.studies.validate import Validation, validate
from several_motions import swung


@pytest.fixture(scope="module")
def rough(two_link) -> SimplifiedModel:
    return gd.simplify(two_link, swung(6.0, "slow"), "5%")


def counted(element: ElementTree.Element) -> dict[str, int]:
    return {name: int(element.attrib[name]) for name in ("tests", "failures", "errors", "skipped")}


def read(found: Validation) -> ElementTree.Element:
    return ElementTree.fromstring(junit_xml(found).encode())


def test_a_case_per_motion_and_joint(rough):
    found = validate(rough, [swung(6.0, "slow"), swung(1.0, "fast")], fail_over="promise")
    root = read(found)
    assert root.tag == "testsuites"
    assert counted(root) == {"tests": 4, "failures": len(found.failures), "errors": 0, "skipped": 0}
    assert [suite.attrib["name"] for suite in root] == ["slow", "fast"]
    for suite, one in zip(root, found.motions, strict=True):
        cases = suite.findall("testcase")
        assert [case.attrib["name"] for case in cases] == ["joint 1 shoulder", "joint 2 elbow"]
        assert {case.attrib["classname"] for case in cases} == {one.name}
        assert [case.find("failure") is not None for case in cases] == one.fails.tolist()
        assert counted(suite)["failures"] == int(one.fails.sum())
        for joint, case in enumerate(cases):
            failure = case.find("failure")
            told = case.findtext("system-out") if failure is None else failure.attrib["message"]
            assert told == one.error_told(joint)
    about = {p.attrib["name"]: p.attrib["value"] for p in root[1].iter("property")}
    assert about["fail over"] == "promise"
    assert about["set points outside the box"] == str(int(found.motions[1].outside.sum()))


def test_a_failure_says_how_large_when_and_what_was_allowed(rough):
    (one,) = validate(rough, swung(1.0, "fast"), fail_over="0.5").motions
    told = one.error_told(0)
    size = one.evaluation.errors.largest[0]
    assert told.startswith(f"largest torque error {size:.3g} N m at {one.at[0]:.6g} s, ")
    assert told.endswith(f", {size / 0.5:.4g} times the 0.5 N m it may be")


def test_nobody_fails_unless_asked(rough):
    root = read(validate(rough, swung(1.0, "fast")))
    assert counted(root)["failures"] == 0
    assert not list(root.iter("failure"))


HOSTILE = (
    "<b>&\"'",
    "]]>",
    "--><!--",
    "</testcase><failure/>",
    "&#0;&lt;",
    "Ünïcødé \U0001f916",
    "\x00\x01\x08\x1b[2J",
    "line\nbreak\r\ttab",
    "\ufffe\uffff\ud800\u202e",
    "",
)


@pytest.mark.parametrize("name", HOSTILE, ids=range(len(HOSTILE)))
def test_hostile_names_stay_in_their_place(rough, name):
    form = rough.form
    joints = form.arm.joints
    # An arm refuses what does not show; where it can be had, joint and arm bear the name, too.
    arm = form.arm
    if name and name.isprintable():
        arm = replace(arm, name=name, joints=(replace(joints[0], name=name), joints[1]))
    model = replace(rough, form=ExactForm(arm, form.drives))
    found = validate(model, swung(1.0, name), fail_over="1%")
    text = junit_xml(found)
    text.encode("utf-8")
    assert not any(ord(sign) < 32 and sign != "\n" for sign in text)
    root = ElementTree.fromstring(text.encode())
    assert [element.tag for element in root] == ["testsuite"]
    assert len(root.findall("testsuite/testcase")) == counted(root)["tests"] == 2
    assert len(list(root.iter("failure"))) == counted(root)["failures"]
    shown = root[0].attrib["name"]
    assert "\n" not in shown
    if name.isprintable():
        assert shown == name
    if arm is not form.arm:
        assert root.findall("testsuite/testcase")[0].attrib["name"] == f"joint 1 {name}"


def test_the_same_input_gives_the_same_file(rough):
    texts = {junit_xml(validate(rough, swung(1.0, "fast"), fail_over="1%")) for _ in range(2)}
    assert len(texts) == 1


def test_an_error_without_torque_is_told(two_link, rough):
    """Of a joint that needs no torque at all any share is infinite, and still a sentence."""
    found = validate(rough, swung(1.0, "fast"), fail_over="1%")
    (one,) = found.motions
    errors = replace(one.evaluation.errors, peak_torque=np.zeros(2))
    told = replace(one, evaluation=replace(one.evaluation, errors=errors)).error_told(0)
    assert "∞ of its peak" in told
