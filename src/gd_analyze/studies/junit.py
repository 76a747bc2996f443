"""A validation as JUnit XML, which machines that run tests read."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree import ElementTree

from gd_analyze.studies.along import ValidatedMotion
from gd_analyze.studies.validate import Validation
from gd_analyze.text import joint_name, visible


def junit_xml(validation: Validation) -> str:
    """Write a suite per motion and in it a case per joint; a joint that fails is a failure with its error.

    Names may be anybody's: what XML cannot hold or what acts on a terminal is written out, the rest escaped.
    """
    about = {"name": "gd-analyze validate"} | _counts(validation.motions)
    root = ElementTree.Element("testsuites", about)
    for one in validation.motions:
        suite = ElementTree.SubElement(root, "testsuite", {"name": visible(one.name)} | _counts([one]))
        properties = ElementTree.SubElement(suite, "properties")
        for name, value in _about(validation, one).items():
            ElementTree.SubElement(properties, "property", name=name, value=visible(value))
        for i, joint in enumerate(validation.model.arm.joints):
            _add_case(suite, one, i, f"joint {joint_name(i + 1, joint.name)}")
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True).decode() + "\n"


def _add_case(suite: ElementTree.Element, one: ValidatedMotion, joint: int, name: str) -> None:
    case = ElementTree.SubElement(suite, "testcase", classname=visible(one.name), name=visible(name))
    told = one.error_told(joint)
    if one.fails[joint]:
        ElementTree.SubElement(case, "failure", type="torque error", message=told).text = told
    else:
        ElementTree.SubElement(case, "system-out").text = told


def _counts(motions: Sequence[ValidatedMotion]) -> dict[str, str]:
    tests = sum(len(one.fails) for one in motions)
    failures = sum(int(one.fails.sum()) for one in motions)
    return {"tests": str(tests), "failures": str(failures), "errors": "0", "skipped": "0"}


def _about(validation: Validation, one: ValidatedMotion) -> dict[str, str]:
    model = validation.model
    return {
        "arm": model.arm.name,
        "budget": model.accuracy.budget,
        "fail over": "" if validation.fail_over is None else str(validation.fail_over),
        "set points": str(one.trajectory.n_set_points),
        "box": validation.box.where,
        "set points outside the box": str(int(one.outside.sum())),
        "joints beyond the promise": str(int((~one.keeps_promise).sum())),
    }
