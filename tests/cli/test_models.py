"""Verbs that make and try models: options reach the library; text, JSON and files are its answer."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.exporting.names import LANGUAGES
from gd_analyze.motions.trajectory import trajectory_csv
from gd_analyze.simplification.harmonic import ENERGY
from gd_analyze.tables import with_payload
from gd_analyze.types import ExactForm
from long_cases import long
from made_models import by_elements, model_of
from recordings import recorded, swung

TWO = "simplify two_link two-link-swing"
PUMA = "simplify puma560 pick-and-place"


def of(rows, name: str) -> list:
    return [row[name] for row in rows]


@pytest.mark.parametrize("level", ["element", "term", "energy"])
def test_a_model_written_is_a_model_evaluated(run, here, level):
    words = f"{TWO} --budget 10% --level {level}"
    made, found = run(f"{words} -o m.json"), run(f"{words} --json").json
    assert made.out.endswith("wrote m.json\n")
    model = gd.load_model("m.json")
    assert (found["level"], model.level.name) == (level, level)
    assert model.provenance["command"] == f"gd-analyze {words} -o m.json"
    left, full = found["operations"], found["operations_full"]
    assert left["total"] == left["multiplications"] + left["additions"]
    assert level == "element" or left["total"] <= full["total"]
    shown = ("kept",) if level == "element" else ("equations", "legend")
    assert all(text in made.words for name in shown for text in found[name])
    again = run("evaluate m.json two-link-swing --json").json
    # The same program on the same states, so the same bits.
    assert of(again["motions"][0]["joints"], "largest_error") == of(found["joints"], "largest_error")
    within = [row["largest_error"] <= row["allowed_error"] for row in found["joints"]]
    assert level == "element" or all(within)


def test_a_model_replaces_a_model_and_nothing_else(run, here):
    words = f"{TWO} --level element -o m.json"
    (here / "m.json").touch()
    assert run(words).out.endswith("wrote m.json\n")
    assert re.search(r"wrote m\.json,.* replaces .*\n$", run(words).out)
    (here / "m.json").write_text("my notes")
    refused = run(words)
    assert refused.code == 2
    assert "error: m.json" in refused.err
    assert (here / "m.json").read_text() == "my notes"


def test_the_exact_equations_of_two_rods(run):
    words = f"{TWO} --budget 0% --level energy --json"
    found = run(words).json
    assert found["equations"] == [
        "tau1 = tau2 + 1.67 pdd1 + 0.5 C2 pdd2 - 0.5 S2 pd2² + 19.6 C1",
        "tau2 = 0.5 C2 pdd1 + 0.333 pdd2 + 0.5 S2 pd1² + 4.9 C12",
    ]
    assert found["legend"][:2] == ["pd2 = qd1 + qd2", "pdd2 = qdd1 + qdd2"]
    assert found["operations"]["total"] <= 22
    assert "0.33 pdd2" in run(f"{words} --digits 2 --quiet").json["equations"][1]


def test_states_and_drives(run):
    words = "simplify puma560 --drives --level energy --states 30 --seed 3 --at-set-points --budget 10%"
    result, found = run(words), run(f"{words} --json").json
    assert "30 states" in result.words
    assert (found["fitted_on"]["seed"], found["drives"]) == (3, True)
    for row in found["joints"]:
        assert row["certified"] is None
        assert 0 <= row["rms_error"] <= row["largest_error"] <= row["allowed_error"]
        assert row["allowed_error"] == pytest.approx(0.1 * row["peak_torque"], rel=1e-14)


@pytest.mark.slow
def test_a_payload_and_links_alone(run):
    assert run(f"{TWO} --payload 1,0,0,0 --json").json["arm"] == "two_link+1kg"
    words = "simplify puma560 --no-drives --budget 10% --level term --states 30 --at-set-points --json"
    assert run(words).json["drives"] is False


@pytest.mark.slow
def test_budgets_beside_friction_and_in_torque(run):
    quick = "simplify puma560 --states 30 --at-set-points --level term"
    words = (*quick.split(), "--budget", "1% or 10% friction")
    found = run(*words, "--json").json
    assert (found["budget"], found["notices"]) == ("1% or 10% friction", [])
    assert all(row["allowed_error"] > 0.01 * row["peak_torque"] for row in found["joints"])
    assert re.search(r"of the budget \(joint \d", run(*words).words)
    (notice,) = run(f"{quick} --json").json["notices"]
    assert '--budget "1% or 10% friction"' in notice
    assert re.search(r"\d N m \(joint \d", run(f"{quick} --budget 1").words)


@pytest.mark.parametrize(
    ("words", "region"),
    [
        ("two_link --states 100", ""),
        ("two_link two-link-swing --level energy", "--along two-link-swing"),
    ],
)
def test_a_certified_budget_holds_in_the_whole_region(run, words, region):
    words = f"simplify {words} --certified --budget 5%"
    assert run(f"{words} -o m.json").code == 0
    told = run(f"{words} --json").json
    assert told["certified_within"].endswith("two-link-swing" if region else "the arm's limits")
    found = told["joints"]
    for row in found:
        assert row["largest_error"] <= row["certified"] <= row["allowed_error"]
    assert of(run(f"certify m.json {region} --json").json["joints"], "certified") == of(found, "certified")


def test_the_ranking(run, here):
    words = "rank-terms puma560 pick-and-place"
    shown, told = run(f"{words} --top 8").out, run(f"{words} --json").json
    assert [term["term"] for term in told["terms"] if term["term"] in shown][:8] == of(
        told["terms"][:8], "term"
    )
    assert told["terms"][8]["term"] not in shown
    assert 0 < told["needed_for_0.01"] < told["needed_for_0.001"]
    assert len(told["torque_uncertainty"]) == 6
    told = run("rank-terms two_link two-link-swing --level energy --json").json
    assert set(of(told["terms"], "label")) == {"D'11", "D'12", "D'22", "U"}
    assert (told["torque_uncertainty"], told["states"]["trajectory"]) == (None, "two-link-swing")


@pytest.mark.parametrize(
    ("words", "of", "whole"),
    [
        long("two_link two-link-swing --budget 10%", "peak torque", 1.0),
        ("two_link two-link-swing --quick --budget 10%", "peak torque", 1.0),
        ("two_link two-link-swing --quick --budget 0.5", "the budget", 0.5),
        long("puma560 pick-and-place --quick --budget 0.5", "the budget", 0.5),
    ],
)
def test_the_curve(run, words, of, whole):
    told = run(f"trade-off {words} --json").json
    assert (told["shares_of"], told["saves"]) == (of, True)
    for point in told["points"]:
        budget = point["budget"].removesuffix(" N m")
        allowed = float(budget.removesuffix("%")) / (100 if budget.endswith("%") else 1)
        assert point["largest_share"] <= allowed / whole * (1 + 1e-9)


def test_the_curve_shows_the_operations_of_its_points(run):
    words = "trade-off two_link two-link-swing --quick"
    shown = run(words).out
    for point in run(f"{words} --json").json["points"]:
        count = point["operations"]
        assert f"{count['total']}/{count['sines_cosines']}" in shown


def test_a_curve_without_savings(run):
    assert run("trade-off two_link --states 50 --quick --budget 1e-6% --json").json["saves"] is False


def test_evaluated_at_drawn_states(run, model):
    told = run("evaluate model.json --states 300 --seed 7 --json").json
    (one,) = told["motions"]
    expected = gd.evaluate(model, gd.tables.states_in_box(model.arm, 300, 7)).errors
    # The same programs at the same states, so the same bits.
    assert of(one["joints"], "largest_error") == expected.largest.tolist()
    assert of(one["joints"], "peak_torque") == expected.peak_torque.tolist()
    effect = gd.tables.payload_effect(model, gd.tables.states_in_box(model.arm, 300, 7))
    assert one["mass_within_budget"] == effect.largest_mass
    assert of(one["joints"], "torque_per_kg") == effect.torque_per_kg.tolist()
    assert (one["states"], one["seed"], one["trajectory"], one["set_points"]) == (300, 7, None, None)
    assert (told["passed"], one["passed"], one["judged"]) == (None, None, 0)
    assert told["held_against"] == {"arm": "two_link", "drives": False, "payload": None}
    again = run("evaluate model.json --states 300 --seed 8 --json").json["motions"]
    assert again[0]["joints"] != one["joints"]
    assert "300 states" in run("evaluate model.json --states 300").words


def test_evaluated_with_a_payload(run, model, swing, here):
    words = "evaluate model.json two-link-swing --payload 0.5,0.01,0,0,0.001,0.001,0.001"
    told = run(f"{words} -o torque.csv --json").json
    loaded = with_payload(model.arm, 0.5, [0.01, 0.0, 0.0], [0.001] * 3)
    (one,), (held,) = told["motions"], gd.evaluate(model, swing, loaded).motions
    without = gd.evaluate(model, swing).errors
    assert of(one["joints"], "largest_error") == held.errors.largest.tolist()
    assert of(one["joints"], "largest_error_without_payload") == without.largest.tolist()
    assert told["held_against"] == {
        "arm": "two_link+0.5kg,0.01,0,0,0.001,0.001,0.001",
        "drives": False,
        "payload": {"mass": 0.5, "position": [0.01, 0.0, 0.0], "inertia": (0.001 * np.eye(3)).tolist()},
    }
    assert (told["arm"], one["largest_losses"]) == ("two_link", [])
    rows = np.loadtxt(here / "torque.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(rows[:, 1:], np.hstack([held.dynamics.torque, held.torque]))
    shown = run(words).words
    assert "0.5 kg" in shown
    assert "unloaded" in shown
    # What the model states is for its arm without a load: a verdict has to be asked for.
    assert (told["fail_over"], run(words).code, run(f"{words} --fail-over 1%").code) == (None, 0, 1)
    assert "--strict" in run(f"{words} --strict").err
    refused = run("evaluate model.json two-link-swing two-link-swing -o x.csv")
    assert all(fact in refused.err for fact in ("-o ", "not 2"))


def test_errors_stand_beside_what_is_allowed_and_no_share_of_another_peak(run, here, swing, motion):
    """Fitted to a gentle motion, so that velocity terms may go, which are large elsewhere."""
    arm = gd.load_arm("two_link")
    made = by_elements(arm, gd.read_trajectory(motion, arm))
    gd.save_model(made, here / "model.json")
    (told,) = run("evaluate model.json two-link-swing --json").json["motions"]
    exact = gd.evaluate(made, swing).errors
    for row, allowed, error, peak in zip(
        told["joints"], made.accuracy.allowed, exact.largest, exact.peak_torque, strict=True
    ):
        assert (row["largest_of_allowed"] <= 1.0) == (error <= allowed)
        assert row["largest_share_of_peak_here"] == error / peak
        assert (row["largest_share_of_peak_fitted_on"] <= 0.02) == (error <= allowed)
    assert max(of(told["joints"], "largest_of_allowed")) > 1.0
    shown = run("evaluate model.json two-link-swing").words
    assert all(f"{row['largest_of_allowed']:.3g} times" in shown for row in told["joints"])
    assert "Omissions" in shown
    assert "Point mass" not in shown


@pytest.fixture
def motions(two_link, here):
    """A model of the slow motion; beside it that one, a fast one, and a brisk one in a folder."""
    made = gd.simplify(two_link, swung(6.0, "slow"), "5%")
    gd.save_model(made, here / "model.json")
    (here / "logs").mkdir()
    for path, seconds in (("slow.csv", 6.0), ("fast.csv", 1.0), ("logs/brisk.csv", 2.0)):
        (here / path).write_text(trajectory_csv(swung(seconds, "x")), encoding="utf-8")
    return made


def test_a_verdict_is_an_exit_code_and_a_junit_file(run, motions, here):
    # The motion is known by its numbers: as a file it is another than the one that the model was fitted on.
    told = run("evaluate model.json slow.csv fast.csv --junit out/junit.xml")
    assert (told.code, "Passed" in told.out, "Not judged" in told.out) == (0, False, True)
    assert ElementTree.parse(here / "out/junit.xml").getroot().attrib["skipped"] == "4"
    assert run("evaluate model.json slow.csv fast.csv --strict").code == 1
    passes = run("evaluate model.json slow.csv --fail-over 5%")
    assert (passes.code, "Passed (--fail-over 5%" in passes.out) == (0, True)
    words = "evaluate model.json slow.csv fast.csv --fail-over 5% --junit out/junit.xml"
    fails = run(words)
    assert fails.code == 1
    assert re.search(r"Failed .* 1 of 2 .*passed .* 1 \(--fail-over 5%", fails.out)
    assert "error:" not in fails.err
    assert fails.out.endswith("wrote out/junit.xml\n")
    told = run(f"{words} --json").json
    assert (told["passed"], told["files"]) == (False, ["out/junit.xml"])
    root = ElementTree.parse(here / "out/junit.xml").getroot()
    failed = sum(not row["passed"] for one in told["motions"] for row in one["joints"])
    assert (root.attrib["tests"], root.attrib["failures"]) == ("4", str(failed))
    quiet = run("evaluate model.json fast.csv --fail-over 5% --quiet")
    assert (quiet.code, quiet.out, quiet.err) == (1, "", "")
    assert run("evaluate model.json fast.csv --fail-over promise").code == 1
    told = run("evaluate model.json logs slow.csv --json").json
    assert of(told["motions"], "trajectory") == ["brisk", "slow"]


def test_a_motion_of_the_fit_passes_and_another_is_not_judged(run, here):
    model = gd.simplify("two_link", "two-link-swing", "5%")
    gd.save_model(model, here / "model.json")
    (here / "fast.csv").write_text(trajectory_csv(swung(1.0, "x")), encoding="utf-8")
    words = "evaluate model.json two-link-swing fast.csv"
    told = run(words)
    assert told.code == 0
    assert re.search("Passed .* 1 of 2 .* 1 not judged", told.out)
    assert run(f"{words} --strict").code == 1
    assert run("evaluate model.json two-link-swing --strict").code == 0
    assert of(run(f"{words} --json").json["motions"], "passed") == [True, None]
    refused = run("evaluate model.json two-link-swing --arm scara")
    assert (refused.code, "scara" in refused.err) == (2, True)


def test_json_of_a_verdict_is_the_library_s(run, motions):
    told = run("evaluate model.json slow.csv fast.csv --fail-over 5% --json").json
    found = gd.evaluate(motions, [swung(6.0, "slow"), swung(1.0, "fast")], fail_over="5%")
    for said, one in zip(told["motions"], found.motions, strict=True):
        # The file holds the same numbers to 17 digits, and so the same bits.
        assert of(said["joints"], "largest_error") == one.errors.largest.tolist()
        assert of(said["joints"], "passed") == (~one.fails).tolist()
        assert of(said["joints"], "largest_error_at") == one.at.tolist()
        assert said["outside_box"] == int(one.outside.sum())
        assert of(said["box_exits"], "first") == [each.first for each in one.exits]
    assert told["motions"][1]["box_exits"]


def test_measured_torques_beside_exact_and_simplified(run, model, two_link, here):
    motion = recorded(two_link, friction=(2.0, 0.7, 0.3))
    rows = np.column_stack([motion.time, motion.q, motion.recording.torque])
    np.savetxt(here / "log.csv", rows, delimiter=",", header="time,q1,q2,tau1,tau2", comments="")
    words = "evaluate model.json log.csv --measured"
    (told,) = run(f"{words} --fit-friction --json").json["motions"]
    for row in told["measured_torque"]["exact"]:
        # Numerical derivatives of the readings' positions, smoothed: a few per cent of friction.
        assert row["coulomb"] == pytest.approx(2.0, rel=0.05)
    (without,) = run(f"{words} --json").json["motions"]
    assert "coulomb" not in without["measured_torque"]["exact"][0]
    assert "rms_difference" in without["measured_torque"]["simplified"][0]


def test_a_model_of_several_motions_is_proven_again(run):
    assert run("plan two_link --from 0,0 --to 0.3,0.2 --duration 2 -o gentle.csv").code == 0
    assert run("simplify two_link two-link-swing gentle.csv --budget 60% -o model.json").code == 0
    refused = run("certify model.json --check --along two-link-swing")
    assert "the certificate is for another motion" in refused.err
    told = run("certify model.json --check --along two-link-swing --along gentle.csv --json").json
    assert told["holds"]


def test_along_a_motion_the_box_of_its_extremes_is_told(run):
    """No box holds the bound near the motion, whose states fill only some of one."""
    assert run(f"{TWO} --budget 60% -o model.json").code == 0
    told = run("certify model.json --along two-link-swing --effort 1000 --json").json
    swing = gd.read_trajectory("two-link-swing", gd.load_arm("two_link"))
    assert told["box"] is None
    assert told["extremes"]["lower"] == swing.q.min(axis=0).tolist()
    assert told["extremes"]["velocity"] == np.abs(swing.qd).max(axis=0).tolist()


def test_certified_over_the_arms_limits(run, model):
    assert run(f"{TWO} --level energy -o model.json").code == 0
    words = "certify model.json --effort 1000"
    shown, told = run(words).words, run(f"{words} --json").json
    assert (told["arm"], told["effort"], told["tube"], told["extremes"]) == ("two_link", 1000, None, None)
    assert told["allowed_and_largest_error"] == "measured"
    for joint in told["joints"]:
        assert max(joint["largest_error"], joint["worst_found"]) <= joint["certified"]
        assert joint["within_allowed"] == (joint["certified"] <= joint["allowed_error"])
        assert joint["certified_of_allowed"] == pytest.approx(joint["certified"] / joint["allowed_error"])
    assert f"{sum(of(told['joints'], 'within_allowed'))} of 2" in shown
    assert told["headline"] in shown
    definite = told["positive_definite"]
    assert definite["smallest_eigenvalue_at_least"] <= definite["smallest_eigenvalue_found"]
    assert run(f"{words} --json").json == told
    assert run("certify model.json --effort 1 --quiet").out == ""


@pytest.mark.parametrize(
    ("kept", "verdict"),
    [
        (lambda t: 1 not in (t.i, t.j), "singular"),
        (lambda t: (t.i, t.j) != (0, 0) or t.monomial, "not positive definite"),
    ],
)
def test_models_without_positive_energy_are_named(run, two_link, kept, verdict):
    form = ExactForm(two_link)
    energies = {t: c for t, c in form.energies.items() if kept(t)}
    gd.save_model(model_of(form, ENERGY, energies), "model.json")
    assert verdict in run("certify model.json").words
    found = run("certify model.json --json").json["positive_definite"]
    assert (found["singular"], found["proven"]) == (verdict == "singular", False)


@pytest.mark.slow
def test_certified_along_a_trajectory_and_between_its_extremes(run):
    assert run(f"{PUMA} --level term -o m.json").code == 0
    along = "--along pick-and-place"
    told, whole, large = (
        run(f"certify m.json {words} --json").json for words in (along, "", f"{along} --margin 5deg,qd=10%")
    )
    assert re.findall(r"\d+ ?[°%]", told["from"]) == ["1°", "2 %", "5 %"]
    assert told["from"].endswith("pick-and-place")
    for inner, outer, wide in zip(told["joints"], whole["joints"], large["joints"], strict=True):
        assert 0.0 < inner["largest_error"] <= inner["certified"] < wide["certified"]
        assert inner["certified"] < inner["certified_between_extremes"] < outer["certified"]
        assert inner["certified_between_extremes"] == wide["certified_between_extremes"]
        assert 1.0 <= inner["ratio"] <= 1.1
    pieces = told["tube"]["pieces"]
    assert (pieces[0]["begin"], pieces[-1]["end"]) == (0.0, 2.4)
    assert np.max(of(pieces, "certified"), axis=0).tolist() == of(told["joints"], "certified")
    assert large["tube"]["margins"]["q"] == pytest.approx([np.radians(5.0)] * 6)
    assert "2 of 30" in run(f"certify m.json {along}").words


def test_compared_formulations(run, motion):
    result, told = (
        run("formulations two_link gentle.csv"),
        run("formulations two_link gentle.csv --json").json,
    )
    for row in told["methods"]:
        assert f"{row['executed']['multiplications']} + {row['executed']['additions']}" in result.out
    assert told["agrees"]
    told = run("formulations two_link --payload 2,0,0,0 --json").json
    assert "500 " in told["compared_at"]
    assert "2 kg" in told["provenance"]["payload"]


@pytest.mark.slow
def test_compared_in_symbols(run, listing):
    told = run("formulations two_link --symbolic --json").json
    assert told["text"]["D22"] == "l**2*m2/3"
    assert all(forms["is_the_text's"] for forms in told["methods"].values())
    assert listing() == set()


def test_exported_files_are_the_library_s(run, here):
    result = run(f"export two_link --to {','.join(LANGUAGES)} --out made")
    files = gd.export("two_link", LANGUAGES).files
    assert {path.name: path.read_text() for path in (here / "made").iterdir()} == dict(files)
    assert result.words.count("wrote ") == len(files)
    assert re.search(r"torque +12 +10 +4", result.out)
    assert run("export two_link --to c --what decomposition --float --out parts").code == 0
    for name, text in gd.export_decomposition("two_link", "c", scalar="float").files.items():
        assert (here / "parts" / name).read_text() == text
    told = run("export puma560 --to c --no-drives --out x --json").json
    assert told["joints"][3] == {"name": "wrist roll", "identifier": "wrist_roll"}
    assert (told["files"], told["stated"]) == (["x/puma560.h", "x/puma560.c"], {})
    with_drives = gd.export("puma560", "c", drives=True).files
    assert (here / "x/puma560.c").read_text() != with_drives["puma560.c"]


def test_an_exported_model_states_its_bound(run, model, here):
    assert run("export model.json --to c,latex --name mine").words.count("wrote ") == 3
    assert "mine_error_bound" in (here / "mine.h").read_text()
    certified = of(run("certify model.json --json").json["joints"], "certified")
    stated = run("export model.json --to c --json").json["stated"]["error_bound"]
    for bound, proven in zip(stated, certified, strict=True):
        assert proven <= bound <= proven * (1 + 1e-5)
    refused = run("export model.json --to c,python --no-bound")
    assert (refused.code, refused.err.startswith("error: two_link.h, two_link.c")) == (2, True)
    assert not (here / "two_link.py").exists()
    assert run("export model.json --to c --no-bound --overwrite").err == ""
    assert "error_bound" not in (here / "two_link.h").read_text()


def test_what_cannot_be_bounded_is_exported_with_a_warning(run, model, here, monkeypatch):
    from gd_analyze.errors import ModelError

    def refuse(*_, **__):
        raise ModelError("no bound of this model")

    monkeypatch.setattr(gd, "certify", refuse, raising=False)
    result = run("export model.json --to c")
    assert result.code == 0
    assert result.err.startswith("warning: ")
    assert all(text in " ".join(result.err.split()) for text in ("no bound of this model", "--no-bound"))
    assert "error_bound" not in (here / "two_link.h").read_text()
