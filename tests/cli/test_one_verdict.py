"""One verdict: every face of an evaluation says the same, and what only a file states is said to be that."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.exporting.names import LANGUAGES
from gd_analyze.report.document import result_document
from gd_analyze.report.terminal import text_of
from gd_analyze.simplification.accuracy import STATED
from gd_analyze.studies.evaluation import evaluate
from gd_analyze.studies.evaluation_result import evaluation_result, junit_xml
from gd_analyze.types import Box
from recordings import swung

SLOW, FAST = swung(6.0, "slow"), swung(1.0, "fast")
# Within the margins of the slow motion, 1 degree and shares of its peaks; and beyond them in its second half.
NEAR = replace(SLOW, q=SLOW.q + 0.01, name="near")
PARTLY = replace(SLOW, q=SLOW.q + np.where(SLOW.time > 3.0, 0.5, 0.01)[:, None], name="partly")


@pytest.fixture(scope="module")
def models(two_link) -> dict[str, gd.types.SimplifiedModel]:
    """Models of which the error is proven near the slow motion, in a box around it, or only sampled there."""
    around = Box.around(*(np.concatenate([1.2 * x, -x]) for x in (SLOW.q, SLOW.qd, SLOW.qdd)))
    return {
        "near": gd.simplify(two_link, SLOW, "5%", certified=True),
        "box": gd.simplify(two_link, SLOW, "5%", region=around, certified=True),
        "sampled": gd.simplify(two_link, SLOW, "5%", at_set_points=True),
    }


def passed(verdict: str) -> bool | None:
    return {"passed": True, "failed": False, "not judged": None}[verdict]


# Model, motions, options, and the verdict on each motion.
CASES = {
    "on the motion": ("near", [SLOW], {}, ["passed"]),
    "near the motion, which is given": ("near", [SLOW, NEAR], {}, ["passed", "passed"]),
    "near the motion, which is unknown": ("near", [NEAR], {}, ["not judged"]),
    "partly near": ("near", [SLOW, PARTLY], {}, ["passed", "passed"]),
    "partly near, strict": ("near", [SLOW, PARTLY], {"strict": True}, ["passed", "failed"]),
    "far": ("near", [FAST], {}, ["not judged"]),
    "far, strict": ("near", [FAST], {"strict": True}, ["failed"]),
    "far, beside the motion": ("near", [SLOW, FAST], {}, ["passed", "not judged"]),
    "far, by the budget": ("near", [FAST], {"fail_over": "promise"}, ["failed"]),
    "far, by a budget": ("near", [SLOW, FAST], {"fail_over": "5%"}, ["passed", "failed"]),
    "far, by a large budget": ("near", [FAST], {"fail_over": "500%"}, ["passed"]),
    "without a verdict": ("near", [SLOW], {"fail_over": None}, ["not judged"]),
    "in the box": ("box", [SLOW, NEAR], {}, ["passed", "passed"]),
    "out of the box": ("box", [FAST], {}, ["not judged"]),
    "sampled": ("sampled", [SLOW], {}, ["passed"]),
    "sampled elsewhere": ("sampled", [NEAR], {}, ["not judged"]),
    "another arm": ("near", [SLOW], {"heavier": True}, ["failed"]),
    "another arm, far": ("near", [FAST], {"heavier": True}, ["not judged"]),
    "another arm, in the box": ("box", [NEAR], {"heavier": True}, ["failed"]),
}


@pytest.mark.parametrize("case", CASES)
def test_every_face_of_an_evaluation_has_the_one_verdict(models, two_link, case):
    name, motions, options, verdicts = CASES[case]
    options = dict(options)
    if options.pop("heavier", False):
        links = (*two_link.links[:-1], replace(two_link.links[-1], mass=2.0))
        options["arm"] = replace(two_link, links=links)
    found = evaluate(models[name], motions, **options)
    expected = "failed" if "failed" in verdicts else "passed" if "passed" in verdicts else "not judged"
    assert (found.verdict, found.passed) == (expected, passed(expected))
    assert [motion.verdict for motion in found.motions] == verdicts
    assert [motion.passed for motion in found.motions] == list(map(passed, verdicts))
    asked = options.get("fail_over", "stated") is not None
    # What prints, in a terminal and in a notebook.
    words = found.in_words.lower()
    assert words.startswith(expected) or not asked
    if len(motions) > 1 and found.verdict != "not judged":
        assert ("passed on" in words, "failed on" in words) == ("passed" in verdicts, "failed" in verdicts)
    assert (f", {expected}" in repr(found)) == asked
    assert all(verdict in repr(one) for one, verdict in zip(found.motions, verdicts, strict=True))
    cells = re.findall(r"<td[^>]*>(passed|failed|not judged)</td>", found._repr_html_())
    assert cells == [verdict for one in found.motions for verdict in one.verdicts]
    result = evaluation_result(found)
    assert result.headline == found.in_words
    assert "romise" not in text_of(result_document(result), 80).replace("promise)", "")
    # What machines read.
    document = result.values()
    assert document["passed"] == passed(expected)
    for said, one, verdict in zip(document["motions"], found.motions, verdicts, strict=True):
        assert said["passed"] == passed(verdict)
        assert [row["passed"] for row in said["joints"]] == list(map(passed, one.verdicts))
        # A joint's verdict is of its own error alone, where it has one.
        if verdict != "not judged" and "strict" not in options:
            errors, limits = one.counted, [row["fail_over"] for row in said["joints"]]
            assert list(map(passed, one.verdicts)) == [
                e <= most for e, most in zip(errors, limits, strict=True)
            ]
    root = ElementTree.fromstring(junit_xml(found).encode())
    for suite, one, verdict in zip(root, found.motions, verdicts, strict=True):
        properties = {entry.attrib["name"]: entry.attrib["value"] for entry in suite.iter("property")}
        assert properties["verdict"] == verdict
        tags = {"failure": "failed", "skipped": "not judged", "system-out": "passed"}
        assert [tags[case[0].tag] for case in suite.iter("testcase")] == list(one.verdicts)


@pytest.mark.parametrize(
    ("words", "verdict"),
    [
        ("two-link-swing", "passed"),
        ("fast.csv", "not judged"),
        ("fast.csv --strict", "failed"),
        ("two-link-swing fast.csv", "passed"),
        ("two-link-swing fast.csv --fail-over 0.01%", "failed"),
        ("two-link-swing fast.csv --fail-over none", "not judged"),
    ],
)
def test_the_exit_code_is_the_verdict(run, here, two_link, words, verdict):
    gd.save_model(gd.simplify(two_link, "two-link-swing", "60%"), here / "model.json")
    gd.write_trajectory(FAST, here / "fast.csv")
    told = run(f"evaluate model.json {words} --junit junit.xml --json")
    assert told.code == {"passed": 0, "failed": 1, "not judged": 0}[verdict]
    assert told.json["passed"] == passed(verdict)
    failures = int(ElementTree.parse(here / "junit.xml").getroot().attrib["failures"])
    assert (failures > 0) == (verdict == "failed")
    assert told.json.get("headline", verdict).lower().startswith(verdict)


def scaled(model: gd.types.SimplifiedModel, by: float) -> gd.types.SimplifiedModel:
    """The model with a smaller bound where only round-off errs: no state refutes it, no proof gives it."""
    stated = model.accuracy.certificate
    region = Box(stated.lower, stated.upper, stated.velocity, stated.acceleration, stated.where)
    if stated.trajectory_fingerprint:
        region = gd.types.Tube.along(
            model.arm, gd.read_trajectory("two-link-swing", model.arm), stated.margin
        )
    loose = gd.certify(model, region, effort=1).stated
    is_exact = model.accuracy.errors.largest == 0.0
    assert is_exact.any()
    forged = replace(loose, certified=np.where(is_exact, by, 1.0) * loose.certified)
    return model.stating(replace(model.accuracy, certificate=forged))


@pytest.fixture(scope="module", params=["near a motion", "in a box"])
def proven(request, two_link, swing) -> gd.types.SimplifiedModel:
    box = Box.around(*(np.concatenate([1.2 * x, -x]) for x in (swing.q, swing.qd, swing.qdd)))
    region = box if request.param == "in a box" else None
    return gd.simplify(two_link, swing, "30%", region=region, certified=True)


@pytest.mark.parametrize("by", [1.0, 0.5])
def test_what_a_file_claims_is_called_that_and_check_proves_it(run, here, proven, by):
    gd.save_model(scaled(proven, by), here / "model.json")
    told = run("evaluate model.json two-link-swing")
    assert (told.code, STATED in told.words.lower()) == (0, True)
    assert "--check" in told.words
    assert run("evaluate model.json two-link-swing --json").json["limits"] == STATED
    loaded = gd.load_model(here / "model.json")
    assert STATED in evaluate(loaded, "two-link-swing").in_words
    checked = run("certify model.json --check")
    assert checked.code == (by < 1.0)
    assert run("certify model.json --check --json").json["holds"] is (by == 1.0)


@pytest.mark.parametrize("language", LANGUAGES)
def test_headers_of_exports_call_it_proven_only_where_it_was(proven, tmp_path, language):
    gd.save_model(proven, tmp_path / "model.json")
    for model, is_proven in ((proven, True), (gd.load_model(tmp_path / "model.json"), False)):
        for text in gd.export(model, language).files.values():
            flat = " ".join(re.sub(r"[^\x20-\x7e]|^\W+", " ", text, flags=re.MULTILINE).split())
            if "Joints in order" not in flat:
                continue
            assert ("Proven: within" in flat) is is_proven
            assert (f"Bound {STATED}" in flat) is not is_proven


def test_a_model_made_here_is_proven_and_one_of_a_file_is_not(proven, tmp_path):
    gd.save_model(proven, tmp_path / "model.json")
    loaded = gd.load_model(tmp_path / "model.json")
    assert proven.accuracy.certificate.proven_here
    assert not loaded.accuracy.certificate.proven_here
    assert STATED not in evaluate(proven, "two-link-swing").in_words
    gd.save_model(loaded, tmp_path / "again.json")
    first, again = (json.loads((tmp_path / name).read_text()) for name in ("model.json", "again.json"))
    assert first == again
