"""What is exported, before it is written: functions that are the model's, the exact dynamics', the parts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio
import pytest

import gd_analyze as gd
from exported_cases import LINKS, MODELS, states, subject
from gd_analyze.dynamics.base_parameters import parameters_of
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.drivetrain import coulomb_friction, viscous_coefficients
from gd_analyze.dynamics.pinocchio_check import pinocchio_model
from gd_analyze.errors import ModelError, UsageError
from gd_analyze.exporting.c import in_strides
from gd_analyze.exporting.export import CLASSES
from gd_analyze.exporting.export_input import FURTHER, ExportInput, Function, Output
from gd_analyze.exporting.names import LANGUAGES
from gd_analyze.harmonics.lagrangian import torques_of_energies
from gd_analyze.harmonics.parameter_terms import energy_terms_of_parameters
from gd_analyze.operations.program import Program, program_inputs
from gd_analyze.operations.trace import Trace
from gd_analyze.simplification.harmonic import ENERGY, HARMONIC_LEVELS
from gd_analyze.simplification.model import exactly
from gd_analyze.simplification.torque_of_parameters import torque_of_parameters
from gd_analyze.simplification.torque_program import ROUGH
from gd_analyze.tables import states_of, with_payload
from gd_analyze.types import ExactDynamics, ExactForm, Placement
from long_cases import long, long_but
from made_models import ROUND_OFF
from recordings import friction_of, recorded, swinging, with_torques
from rounded_programs import PAYLOAD, given_of, slope
from strategies import random_inertia

# Functions beside the torque of six joints take seconds to derive: an arm of two revolute joints and one with
# a slide show the same.
ARM_NAMES = (*LINKS, "scara")
ARMS = long_but(("two_link", "scara"), ARM_NAMES)
TWO_LINK_MODELS = [case for case in MODELS if case.startswith("two_link")]


def values(what, drawn):
    """Outputs of all functions by name, (states, ...)."""
    found = {}
    for function in what.functions:
        rows = function.program.run(given_of(drawn)).T
        ends = np.cumsum([output.size for output in function.outputs])
        for output, part in zip(function.outputs, np.split(rows, ends[:-1], axis=1), strict=True):
            found[output.name] = part.reshape(-1, *output.shape)
    return found


def assert_close(found, wanted):
    assert found.shape == wanted.shape
    assert np.abs(found - wanted).max() <= ROUND_OFF * max(1.0, np.abs(wanted).max())


@pytest.mark.parametrize("case", MODELS)
def test_functions_of_a_model_are_the_models(case):
    what, drawn = subject(case), states(case)
    model, found = what.model, values(what, drawn)
    np.testing.assert_array_equal(found["tau"], model.torque(*drawn.arrays))
    np.testing.assert_array_equal(found["D"], model.inertia(drawn.q))
    np.testing.assert_array_equal(found["h"], model.coriolis_centrifugal(drawn.q, drawn.qd))
    np.testing.assert_array_equal(found["c"], model.gravity_loading(drawn.q))


@pytest.mark.parametrize("name", LINKS)
def test_functions_of_an_arm_are_its_exact_dynamics_and_parts_sum_to_the_whole(name):
    what, drawn = subject(name), states(name)
    numeric = gd.tables.decompose_states(what.arm, drawn, christoffel=False, drives=what.drives)
    drives = np.diag(what.arm.drive_inertia) if what.drives else 0.0
    found = values(what, drawn)
    assert_close(found["tau"], torque_of(what.arm, drawn, drives=what.drives))
    assert_close(found["D"], numeric["inertia"].sum(axis=1) + drives)
    assert_close(found["h"], numeric["coriolis_centrifugal"].sum(axis=1))
    assert_close(found["c"], numeric["gravity_loading"])
    numeric = gd.tables.decompose_states(what.arm, drawn, christoffel=False, drives=False)
    parts = values(subject(f"{name} decomposition"), drawn)
    for k, effect in enumerate(("tran", "rot")):
        assert_close(parts[f"D_{effect}"], numeric["inertia"][:, k])
        assert_close(parts[f"h_{effect}"], numeric["coriolis_centrifugal"][:, k])
    assert_close(parts["c"], numeric["gravity_loading"])


@pytest.mark.parametrize("name", ARMS)
def test_derivatives_are_pinocchios_and_forward_dynamics_undo_the_torque(name):
    """Of the exact dynamics, drives left out: Pinocchio's derivatives, Coriolis matrix and aba."""
    arm = gd.load_arm(name)
    what = ExportInput.of_exact(ExactForm(arm, False)).with_functions(FURTHER[:3])
    drawn, n = gd.tables.states_in_box(arm, 50, seed=3), arm.n_joints
    found, model = values(what, drawn), pinocchio_model(arm)
    data = model.createData()
    for k, (q, qd, qdd) in enumerate(zip(*drawn.arrays, strict=True)):
        by_q, by_qd, _ = pinocchio.computeRNEADerivatives(model, data, q, qd, qdd)
        assert_close(found["dtau_dq"][k], by_q)
        assert_close(found["dtau_dqd"][k], by_qd)
        assert_close(found["C"][k], pinocchio.computeCoriolisMatrix(model, data, q, qd))
        # Twice half the condition number of D is lost on the way to the accelerations and back.
        lost = ROUND_OFF * np.linalg.cond(found["D"][k]) * max(1.0, np.abs(qdd).max())
        assert np.abs(found["qdd"][k] - pinocchio.aba(model, data, q, qd, drawn.qdd[k])).max() <= lost
    there = what.functions[-1].program.run(
        program_inputs(drawn) | {f"tau{i + 1}": found["tau"][:, i] for i in range(n)}
    )
    back = np.abs(there.T - drawn.qdd).max(axis=1)
    assert (back <= ROUND_OFF * np.linalg.cond(found["D"]) * np.abs(drawn.qdd).max()).all()


@pytest.mark.parametrize("case", long_but(TWO_LINK_MODELS, MODELS))
def test_further_functions_of_a_model_are_of_its_own_torque(case):
    plain = subject(case)
    what, drawn = plain.with_functions(FURTHER[:3]), states(case, 60)
    found, torque, n = values(what, drawn), plain.torque.program, plain.n
    for name, output in (("q", "dtau_dq"), ("qd", "dtau_dqd"), ("qdd", "D")):
        for j in range(n):
            wanted = slope(torque, drawn, f"{name}{j + 1}").T
            if name == "qdd":
                wanted = plain.model.inertia(drawn.q)[:, :, j]
            assert_close(found[output][:, :, j], wanted)
    assert_close(np.einsum("nij,nj->ni", found["C"], drawn.qd), found["h"])
    # The rigid torque that the accelerations found need is the torque given: the qdd of the states.
    needed = np.einsum("nij,nj->ni", found["D"], found["qdd"]) + found["h"] + found["c"]
    size = np.linalg.cond(found["D"]) * np.maximum(np.abs(needed).max(axis=1), 1.0)
    assert (np.abs(needed - drawn.qdd).max(axis=1) <= ROUND_OFF * size).all()
    if plain.model.level is ENERGY:
        step = 1e-6
        moved = [gd.types.States(drawn.q + sign * step * drawn.qd, drawn.qd, drawn.qdd) for sign in (1, -1)]
        later, before = (values(plain, each)["D"] for each in moved)
        skew = (later - before) / (2.0 * step) - 2.0 * found["C"]
        # Central differences err by the third derivative times the step squared, and by eps over the step.
        assert np.abs(skew + skew.swapaxes(1, 2)).max() <= 1e-7 * max(1.0, np.abs(later).max())


@pytest.mark.parametrize("name", long_but(("two_link",), ARM_NAMES))
def test_a_payload_adds_what_an_arm_that_carries_it_needs_more(name):
    """In the frame of the tip, where the arm has one, else in that of the last link."""
    plain = gd.load_arm(name)
    turn = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    for arm in (plain, replace(plain, tip="hand", tip_frame=Placement(turn, np.array([0.1, 0.02, -0.3])))):
        drawn, (mass, *rest) = gd.tables.states_in_box(arm, 50, seed=4), PAYLOAD
        carrying = with_payload(arm, mass, rest[:3], rest[3:])
        more = torque_of(carrying, drawn, drives=False) - torque_of(arm, drawn, drives=False)
        what = replace(subject(name), arm=arm).with_functions(["payload"])
        assert_close(values(what, drawn)["tau_payload"], more)


@pytest.mark.parametrize("name", ARMS)
def test_the_regressor_is_pinocchios_mapped_to_base_parameters(name):
    """For links of any mass distribution: a regressor of the wrong map would agree for some of them only."""
    arm, rng = gd.load_arm(name), np.random.default_rng(3)
    what = ExportInput.of_exact(ExactForm(arm)).with_functions(["regressor", "parameters"])
    drawn, n = gd.tables.states_in_box(arm, 20, seed=4), arm.n_joints
    per_base = values(what, drawn)["Y"]
    assert per_base.shape == (20, n, len(what.base))
    torque = next(each for each in what.functions if each.name == "torque_of_parameters")
    for _ in range(len(what.base)):
        links = tuple(
            replace(link, mass=mass, com=com, inertia_com=random_inertia(rng))
            for link, mass, com in zip(
                arm.links, rng.uniform(1.0, 5.0, n), rng.uniform(-0.3, 0.3, (n, 3)), strict=True
            )
        )
        other = replace(arm, links=links)
        model = pinocchio_model(other)
        data, theirs = (
            model.createData(),
            np.concatenate([x.toDynamicParameters() for x in model.inertias[1:]]),
        )
        wanted = np.array(
            [
                pinocchio.computeJointTorqueRegressor(model, data, *state) @ theirs
                for state in zip(*drawn.arrays, strict=True)
            ]
        )
        numbers = np.einsum("ksp,sp->k", what.base.matrix, parameters_of(other))
        assert_close(per_base @ numbers, wanted)
        given = given_of(drawn) | {f"parameters{k + 1}": np.full(20, x) for k, x in enumerate(numbers)}
        assert_close(torque.program.run(given).T, wanted)


@pytest.mark.parametrize("name", LINKS)
def test_the_stated_base_parameters_give_the_torque_with_drives(name):
    arm = gd.load_arm(name)
    what = ExportInput.of_exact(ExactForm(arm, arm.counts_drives(None))).with_functions(["regressor"])
    found = values(what, gd.tables.states_in_box(arm, 50, seed=4))
    assert_close(found["Y"] @ np.array(what.constants["base_parameters"].values), found["tau"])


def heavier(arm, rng):
    """The same geometry with other links."""
    n = arm.n_joints
    changed = zip(arm.links, rng.uniform(1.0, 5.0, n), rng.uniform(-0.3, 0.3, (n, 3)), strict=True)
    links = tuple(
        replace(link, mass=mass, com=com, inertia_com=random_inertia(rng)) for link, mass, com in changed
    )
    return replace(arm, links=links)


def of_parameters(what, drawn, numbers):
    """Torque of given base parameters."""
    torque = next(each for each in what.functions if each.name == "torque_of_parameters")
    return torque.program.run(inputs_with(drawn, numbers)).T


def inputs_with(drawn, numbers):
    """Inputs of a program at states, with base parameters."""
    return given_of(drawn) | {f"parameters{k + 1}": np.full(len(drawn), x) for k, x in enumerate(numbers)}


@pytest.mark.parametrize("level", HARMONIC_LEVELS)
@pytest.mark.parametrize("name", ["two_link", long("scara")])
def test_all_terms_of_a_model_with_other_parameters_are_another_arm(name, level):
    """Pinocchio knows nothing of terms; an arm of random bodies has all that the geometry allows."""
    rng = np.random.default_rng(5)
    arm, other = (heavier(gd.load_arm(name), rng) for _ in range(2))
    drawn = gd.tables.states_in_box(arm, 20, seed=4)
    exact = ExactDynamics.of(arm, drawn)
    model = exactly(exact, HARMONIC_LEVELS[level], exact.allowed("1%"), "1%")
    what = ExportInput.of_model(model).with_functions(["regressor", "parameters"])
    numbers = np.einsum("ksp,sp->k", what.base.matrix, parameters_of(other))
    theirs = pinocchio_model(other)
    data = theirs.createData()
    wanted = np.array([pinocchio.rnea(theirs, data, *state) for state in zip(*drawn.arrays, strict=True)])
    assert_close(of_parameters(what, drawn, numbers), wanted)
    assert_close(values(what, drawn)["Y"] @ numbers, wanted)


@pytest.mark.parametrize(
    "case", long_but(TWO_LINK_MODELS, [case for case in MODELS if case.endswith(("term", "energy"))])
)
def test_a_model_of_parameters_keeps_its_terms(case):
    """At its arm's parameters it is the model; at another's it and the dropped terms add up to that arm."""
    model, drawn, rng = subject(case).model, states(case), np.random.default_rng(6)
    what = subject(case).with_functions(["regressor", "parameters"])
    own = np.array(what.constants["base_parameters"].values)
    # Numbers of the case's own program are rounded.
    program = model.level.write(model.form, model.terms, ROUGH)
    assert_close(of_parameters(what, drawn, own), program.run(program_inputs(drawn)).T)
    other = heavier(model.arm, rng)
    numbers = np.einsum("ksp,sp->k", what.base.matrix, parameters_of(other))
    numbers += [parameter.drive for parameter in what.base]
    # All that the geometry allows: many are zero with the shipped arm's numbers, and in no model of it.
    energies = energy_terms_of_parameters(model.form.harmonics, what.base)
    every = {term: float(of_parameter @ own) for term, of_parameter in energies.items()}
    if model.level.name == "term":
        drawn_numbers = {term: of_parameter @ rng.random(len(own)) for term, of_parameter in energies.items()}
        terms = torques_of_energies(drawn_numbers, model.form.velocities)
        every = {term: model.form.torques.get(term, 0.0) for term in terms if term.is_upper}
    dropped = replace(model, terms={term: w for term, w in every.items() if term not in model.terms})
    rest = torque_of_parameters(dropped, what.base).run(inputs_with(drawn, numbers)).T
    assert_close(of_parameters(what, drawn, numbers) + rest, torque_of(other, drawn, drives=model.drives))
    assert_close(values(what, drawn)["Y"] @ numbers, of_parameters(what, drawn, numbers))


def test_coefficients_that_are_no_sums_of_parameters_are_refused():
    arm = gd.load_arm("two_link")
    motion = gd.read_trajectory("two-link-swing", arm)
    model = gd.simplify(arm, motion)
    term = next(term for term in model.terms if term.monomial)
    foreign = replace(
        model, terms={**model.terms, term._replace(monomial=term.monomial + term.monomial): 1.0}
    )
    edited = replace(model, terms={**model.terms, term: 1.01 * model.terms[term]})
    for model in (foreign, edited, gd.simplify(arm, motion, level="element")):
        with pytest.raises(UsageError) as caught:
            ExportInput.of_model(model).with_functions(["parameters"])
        assert caught.value.details["where"] == "functions"


@pytest.mark.parametrize("language", ["jax", "casadi", "python", "sympy"])
def test_what_is_exported_can_be_called_at_once(language, two_link):
    if language != "python":
        pytest.importorskip(language)
    exported = gd.export(two_link, ["c", language])
    state = np.array([[0.3, -0.4], [1.0, 2.0], [0.5, -0.5]])
    wanted = ExactForm(two_link).program.run(
        {
            f"{k}{j + 1}": x[j : j + 1]
            for k, x in zip(("q", "qd", "qdd"), state, strict=True)
            for j in range(2)
        }
    )
    found = np.asarray(exported.function()(*state), dtype=float).ravel()
    # JAX computes in single precision unless told otherwise.
    np.testing.assert_allclose(found, wanted[:, 0], rtol=1e-5 if language == "jax" else 1e-13)
    with pytest.raises(UsageError, match="no such function"):
        exported.function("friction")
    with pytest.raises(UsageError, match="can be called"):
        gd.export(two_link, "c").function()


@pytest.mark.parametrize("case", ["two_link", "two_link energy", "puma560 term"])
def test_sympys_functions_take_symbols(case):
    """The expressions are the program; the torque's derivatives by the accelerations are D."""
    sympy = pytest.importorskip("sympy")
    plain, drawn = subject(case), states(case, 20)
    exported, n = gd.export(plain.model or plain.arm, "sympy"), plain.n
    symbols = [sympy.symbols(f"{name}1:{n + 1}") for name in ("q", "qd", "qdd")]
    torque = exported.function()(*symbols)
    given = [array.T for array in drawn.arrays]
    found = sympy.lambdify(symbols, torque, "numpy", cse=True)(*given)[:, 0]
    wanted = plain.torque.program.run(program_inputs(drawn))
    # SymPy puts sums in an order of its own.
    np.testing.assert_allclose(found, wanted, rtol=0, atol=ROUND_OFF * np.abs(wanted).max())
    slopes = sympy.lambdify(symbols[0], torque.jacobian(symbols[2]), "numpy", cse=True)
    inertia = sympy.lambdify(symbols[0], exported.function("inertia")(symbols[0]), "numpy", cse=True)
    for q in drawn.q:
        expected = inertia(*q)
        np.testing.assert_allclose(slopes(*q), expected, rtol=0, atol=ROUND_OFF * np.abs(expected).max())


def test_sympys_functions_refuse_what_is_no_state(two_link):
    pytest.importorskip("sympy")
    gravity = gd.export(two_link, "sympy").function("gravity_loading")
    with pytest.raises(ValueError, match="q has 2 entries, not 3"):
        gravity([0.0, 0.0, 0.0])


def test_friction_is_that_of_the_drives(puma):
    what = ExportInput.of_exact(ExactForm(puma)).with_functions(["friction"])
    drawn = gd.tables.states_in_box(puma, 100)
    still = gd.types.States(drawn.q, np.where(drawn.q > 0.0, drawn.qd, 0.0), drawn.qdd)
    wanted = viscous_coefficients(puma) * still.qd + coulomb_friction(puma, still.qd)
    assert_close(values(what, still)["tau_friction"], wanted)


# The larger offset is told.
@pytest.mark.filterwarnings("ignore:.*A constant 2 N m at joint 2:gd_analyze.GdAnalyzeWarning")
@pytest.mark.parametrize(
    ("friction", "levels"), [((3.0, 1.5, 0.5), (3.5, -2.5)), ((1.0, 0.5, 2.0), (3.0, 0.0))]
)
def test_fitted_friction_is_exported(two_link, tmp_path, friction, levels):
    """From the model, and from what is read of its file again; an offset that would drive is the sensor's."""
    findings = gd.analyze(
        two_link, recorded(two_link, friction=friction), fit_friction=True, at_set_points=True
    )
    gd.save_model(findings.model, tmp_path / "model.json")
    qd = np.random.default_rng(0).uniform(-2.0, 2.0, (50, 2))
    drawn = gd.types.States(np.zeros_like(qd), qd, np.zeros_like(qd))
    wanted = np.where(qd > 0.0, *levels) + friction[1] * qd
    for model in (findings.model, gd.load_model(tmp_path / "model.json")):
        torque = values(ExportInput.of_model(model).with_functions(["friction"]), drawn)["tau_friction"]
        # The log has no noise: least squares of 500 readings, with a condition of some tens.
        np.testing.assert_allclose(torque, wanted, rtol=0, atol=1e-9)


def test_friction_that_a_log_does_not_determine_stays_the_files(two_link):
    """A joint that moves one way only: its offset is its Coulomb friction, which must not be added twice."""
    own = (gd.types.Drive(coulomb=(5.0, -5.0), viscous=1.0), gd.types.Drive(coulomb=(4.0, -4.0), viscous=1.0))
    arm = replace(two_link, drives=own)
    both = swinging(arm)
    q, qd, qdd = (array.copy() for array in (both.q, both.qd, both.qdd))
    q[:, 0], qd[:, 0], qdd[:, 0] = 0.1 * both.time, 0.1, 0.0
    motion = replace(both, q=q, qd=qd, qdd=qdd)
    torque = torque_of(arm, states_of(motion)) + friction_of(motion, 3.0, 1.5, 0.0)
    log = with_torques(motion, torque)
    with pytest.warns(gd.GdAnalyzeWarning, match="friction of joint 1"):
        model = gd.analyze(arm, log, fit_friction=True, at_set_points=True).model
    assert model.arm.drives[0] == own[0]
    assert model.arm.drives[1] != own[1]


@pytest.mark.parametrize("drives", [(), (gd.types.Drive(inertia=0.1),) * 2])
def test_friction_that_nobody_states_is_refused(two_link, drives):
    with pytest.raises(UsageError) as caught:
        gd.export(replace(two_link, drives=drives), "c", what=["friction"])
    assert caught.value.details["where"] == "what friction"
    assert "--fit-friction" in caught.value.details["next"]


@pytest.mark.parametrize("seen", ["gamma", "eigenvalue"])
def test_forward_dynamics_need_a_d_that_can_be_divided_by(two_link, seen):
    """A model that keeps nothing of D but a coupling; and one that states a gamma of 1 or more."""
    exact = ExactDynamics.of(two_link, gd.tables.states_in_box(two_link, 50))
    model = exactly(exact, HARMONIC_LEVELS["term"], exact.peak_torque, "100%")
    if seen == "gamma":
        model = model.stating(replace(model.accuracy, gamma=1.24))
    else:
        coupling = {
            t: w for t, w in model.terms.items() if t.quantity == "inertia" and t.row == 0 and t.monomial
        }
        model = replace(model, terms=coupling)
    with pytest.raises(ModelError) as caught:
        ExportInput.of_model(model).with_functions(["forward"])
    assert seen in caught.value.details["found"]
    ExportInput.of_model(model).with_functions(["derivatives"])


def test_functions_beside_the_torque_are_asked_for_by_name(two_link):
    text = gd.export(two_link, "c", what=["forward"]).files["two_link.h"]
    assert "two_link_forward_dynamics" in text
    assert "coriolis_matrix" not in text
    with pytest.raises(UsageError) as caught:
        gd.export(two_link, "c", what=["inverse"])
    assert caught.value.details["where"] == "what"


def test_an_arm_is_named_or_given(two_link):
    for arm in ("two_link", two_link):
        assert list(gd.export(arm, ["c", "python"]).files) == ["two_link.h", "two_link.c", "two_link.py"]
    assert list(gd.export_decomposition("two_link", "c", name="parts").files) == ["parts.h", "parts.c"]
    assert "gravity_loading" in gd.export("two_link", "c")._repr_html_()


@pytest.mark.parametrize("case", ["two_link term", "two_link energy"])
def test_a_model_from_its_file_is_written_the_same(case, tmp_path):
    model = subject(case).model
    gd.save_model(model, tmp_path / "model.json")
    again = gd.load_model(tmp_path / "model.json")
    # Errors at states that only its maker has are stated in the file, and said to be.
    assert gd.export(again, LANGUAGES).files != gd.export(model, LANGUAGES).files
    again = again.stating(replace(again.accuracy, measured=True))
    assert gd.export(again, LANGUAGES).files == gd.export(model, LANGUAGES).files


@pytest.mark.parametrize(
    ("words", "where", "found"),
    [
        ({"languages": ["c", "rust"]}, "languages", "rust"),
        ({"languages": "c", "scalar": "half"}, "scalar", "half"),
        ({"languages": "python", "scalar": "float"}, "scalar", "float"),
        *(({"languages": "c", "name": name}, "name", name) for name in ("a b", "x" * 41, "a__b", "json")),
    ],
)
def test_what_cannot_be_written_is_refused(words, where, found):
    for call in (gd.export, gd.export_decomposition):
        with pytest.raises(UsageError) as caught:
            call("two_link", **words)
        assert (caught.value.details["where"], caught.value.details["found"]) == (where, found)


def test_a_name_that_is_advised_is_taken():
    for name in ("a b", "double", "", "7", "x" * 60, "a__b", "double" * 9, "Ω"):
        with pytest.raises(UsageError) as caught:
            gd.export("two_link", "c", name=name)
        advised = caught.value.details["next"].removesuffix(" would do")
        assert gd.export("two_link", "c", name=advised).subject.name == advised


def test_what_does_not_fit_is_refused(two_link, swing):
    model = subject("two_link energy").model
    tube = gd.certify(model, gd.types.Tube.along(two_link, swing))
    for other in (subject("stanford energy").certificate, tube):
        with pytest.raises(UsageError, match="certificate"):
            ExportInput.of_model(model, None, other)
    with pytest.raises(UsageError, match=r"next: .*gd-analyze equations"):
        gd.export_decomposition("two_link", "latex")


def test_numbers_of_single_precision():
    single = CLASSES["c"]("float")
    assert float(np.float32(single.number(1 / 3)[:-1])) == float(np.float32(1 / 3))
    with pytest.raises(UsageError, match=r"found: 1e\+39"):
        single.number(1e39)


def test_sines_of_sines_are_taken_one_after_another():
    trace = Trace()
    q = trace.record("input", "q1")
    program = Program.of(trace, [(q.sin() + q).cos(), (q + 1.0).sin()])
    groups, rest = in_strides(Function("torque", "", ("q",), (Output("tau", (2,)),), program))
    assert [[x.name for x in each.inputs] for each in groups] == [["q1"], ["q1", "sin1"]]
    assert [x.name for x in rest.inputs] == ["sin3", "cos2"]
