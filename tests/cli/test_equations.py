"""`gd-analyze equations`: what it prints, in every form, and what it refuses."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.formulas.languages import Plain
from gd_analyze.formulas.printer import number
from gd_analyze.formulas.writing import element_formula
from gd_analyze.robots.arm_toml import toml_of
from gd_analyze.studies.comparison_costs import generic_chain


def body(text: str) -> str:
    """What follows the header."""
    return text.partition("\n\n")[2]


@pytest.mark.parametrize("name", ["puma560", "stanford", "two_link"])
def test_all_elements_on_80_columns(run, name):
    result = run("equations", name)
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    found = gd.equations(gd.load_arm(name))
    assert body(result.out) == "".join(
        f"{Plain().wrapped(element_formula(equation), 80)}\n" for equation in found
    )
    header = result.out.partition("\n\n")[0]
    assert gd.load_arm(name).title in header
    assert f"{sum(len(equation.terms) for equation in found)} terms" in header
    assert "elements not shown are zero" in " ".join(header.split())


def test_elements_shares_and_digits(run):
    words = ("equations", "puma560", "--element", "D12", "--element", "c3", "--min-share", "1%")
    assert body(run(*words).out) == "D12 = 0.687 S2 - 0.133 C23 + 0.0237 C2\nc3 = -8.45 S23 + 0.25 C23\n"
    assert run(*words, "--quiet").out == body(run(*words).out)
    assert run(*words[:-1], "0.01", "--quiet").out == run(*words, "--quiet").out
    assert (
        run(*words, "--digits", 1, "--quiet").out
        == "D12 = 0.7 S2 - 0.1 C23 + 0.02 C2\nc3 = -8 S23 + 0.3 C23\n"
    )
    assert "at least 1 %" in run(*words).out
    assert run("equations", "puma560", "--element", "D45", "--quiet").out == "D45 = 0\n"


def test_tables_of_terms(run):
    result = run("equations", "puma560", "--element", "D11", "--terms")
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    (equation,) = gd.equations(gd.load_arm("puma560"), ["D11"])
    rows = result.out.rstrip().splitlines()[-len(equation.terms) :]
    assert rows[0].split() == ["1", "1.84", "both", "1-6", "100", "%"]
    assert all(f" {term.effect} " in row for row, term in zip(rows, equation.terms, strict=True))


def test_json_holds_every_digit(run):
    result = run("equations", "puma560", "--element", "D11", "--json")
    assert (result.code, result.err) == (0, "")
    (told,) = result.json["equations"]
    (equation,) = gd.equations(gd.load_arm("puma560"), ["D11"])
    assert told["symbol"] == "D11"
    assert [t["coefficient"] for t in told["terms"]] == [t.coefficient for t in equation.terms]
    assert told["terms"][1]["factors"] == [{"kind": "cos", "multiples": [0, 1, 0, 0, 0, 0], "exponent": 2}]
    assert told["terms"][0]["links"] == [1, 2, 3, 4, 5, 6]
    assert result.json["written"].startswith("D11 = 1.84 + ")
    assert result.json["files"] == []
    assert result.out.isascii()


def test_latex_mathml_and_their_comments(run):
    lines = run("equations", "two_link", "--format", "latex").out.splitlines()
    assert next(line for line in lines if line and not line.startswith("% ")) == "D_{11} = 2 + C_{2}"
    out = run("equations", "puma560", "--format", "mathml").out
    tree = ET.fromstring(f"<page>{out}</page>")
    assert len(tree) == len(gd.equations(gd.load_arm("puma560")))


def test_a_title_cannot_end_a_comment(run, here):
    text = run("arms", "two_link", "--to", "toml").out
    (here / "own.toml").write_text(re.sub(r'title = ".*"', 'title = "two --> <b>"', text), encoding="utf-8")
    ET.fromstring(f"<page>{run('equations', 'own.toml', '--format', 'mathml').out}</page>")


@pytest.mark.parametrize("name", ["two_link", "stanford"])
def test_the_sympy_form_is_a_script(run, name):
    sympy = pytest.importorskip("sympy", reason="needs SymPy: pip install 'gd-analyze[symbolic]'")
    scope: dict[str, object] = {}
    exec(run("equations", name, "--format", "sympy").out, scope)
    arm = gd.load_arm(name)
    q = np.linspace(0.1, 0.6, arm.n_joints)
    values = {sympy.Symbol(f"q{j + 1}", real=True): q[j] for j in range(arm.n_joints)}
    exact = gd.decompose_states(arm, gd.States(q, q, q))
    whole = float(sympy.sympify(scope["D11"]).subs(values))
    # Some ten terms of at most the arm's largest inertia, each rounded.
    assert whole == pytest.approx(exact["inertia"][:, 0, 0].sum(), rel=1e-12)


def test_a_file_holds_what_the_terminal_would_show(run, here, listing):
    result = run("equations", "two_link", "-o", "out/two.txt")
    assert (result.code, result.err) == (0, "")
    assert result.out.endswith("wrote out/two.txt\n")
    assert body((here / "out/two.txt").read_text(encoding="utf-8")) == body(run("equations", "two_link").out)
    assert run("equations", "two_link", "-o", "quiet.txt", "--quiet").out == ""
    told = run("equations", "two_link", "-o", "told.tex", "--format", "latex", "--json")
    assert told.json["files"] == ["told.tex"]
    assert (here / "told.tex").read_text(encoding="utf-8").endswith(told.json["written"])
    assert listing() == {"out", "out/two.txt", "quiet.txt", "told.tex"}


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("nowhere",), "there is no arm 'nowhere'"),
        (("two_link", "--element", "D13"), "there is no element 'D13'"),
        (("two_link", "--min-share", "2"), "'2' is not a share of 0 to 1"),
        (("two_link", "--digits", "0"), "0 is not in the range 1<=x<=17"),
        (("two_link", "--format", "html"), "'html' is not one of"),
        (("two_link", "--terms", "--format", "latex"), "--terms is a table for the terminal"),
        (("two_link", "-o", "."), "cannot write there"),
        (("two_link", "--parameters", "--terms"), "--parameters are of the whole arm"),
        (("two_link", "--parameters", "--format", "sympy"), "as text or latex, not as sympy"),
        ((), "missing argument"),
    ],
)
def test_what_is_refused(run, listing, words, says):
    result = run("equations", *words)
    assert (result.code, result.out) == (2, "")
    assert says in result.err.replace("‘", "'")
    assert "Traceback" not in result.err
    assert listing() == set()


def test_json_of_an_arm_without_round_off(run, here):
    """A gap may be infinite, which JSON does not know."""
    text = run("arms", "two_link", "--to", "toml").out
    (here / "own.toml").write_text(re.sub(r"gravity = .*", "gravity = [0, 0, 0]", text), encoding="utf-8")
    told = run("equations", "own.toml", "--json").json
    assert told["gap"] is None or told["gap"] > 1e3
    assert json.loads(json.dumps(told)) == told
    assert not [equation for equation in told["equations"] if equation["symbol"].startswith("c")]


def test_outer_elements_of_an_arm_of_many_joints(run, here):
    """All of this arm's equations would take 19 GB."""
    (here / "long.toml").write_text(toml_of(generic_chain(11)), encoding="utf-8")
    out = run("equations", "long.toml", "--element", "D10,11", "--quiet").out
    assert out.startswith("D10,11 = ")
    refused = run("equations", "long.toml", "--element", "D1,2")
    assert (refused.code, refused.out) == (2, "")
    assert "next: elements from D22 on, and c, are found;" in refused.err


@pytest.mark.parametrize("name", ["puma560", "stanford", "two_link"])
def test_base_parameters_on_80_columns(run, name):
    result = run("equations", name, "--parameters")
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    base = gd.base_parameters(name)
    assert f"{len(base)} (of {len(base.original)} parameters)" in result.out
    for one in base:
        assert re.search(rf"^{one.symbol} +{re.escape(number(one.number, 3))} ", result.out, re.MULTILINE)


def test_what_base_parameters_combine(run):
    out = run("equations", "puma560", "--parameters").out
    row, combination = (line for line in out.splitlines() if line.startswith("MX2"))
    assert row.split() == ["MX2", "3.8", "3.8", "0", "0", "kg", "m"]
    assert combination == "MX2 = mx2 + 0.432 m3..6"
    assert re.search(r"^1 +Pxx Pyy J +all but Pxx Pyy J$", out, re.MULTILINE)
    assert re.search(r"^2 +-0.432 0 0 +1 0 0 +0 0 1$", out, re.MULTILINE)


def test_base_parameters_as_equations(run, here):
    latex = run("equations", "two_link", "--parameters", "--format", "latex").out.splitlines()
    assert latex[0] == r"MX_{1} = mx_{1} + m_{2} = 2 \; \mathrm{kg~m}"
    plain = run("equations", "two_link", "--parameters", "--quiet").out
    assert plain.splitlines()[2] == "PXX1 = Pxx1 + Pyy1 + m2 = 1.67 kg m^2"
    assert run("equations", "two_link", "--parameters", "-o", "base.txt").out.endswith("wrote base.txt\n")
    assert (here / "base.txt").read_text(encoding="utf-8") == plain


def test_base_parameters_as_json(run):
    told = run("equations", "puma560", "--parameters", "--json").json
    base = gd.base_parameters("puma560")
    assert [one["number"] for one in told["parameters"]] == [one.number for one in base]
    assert told["parameters"][1]["combination"][1] == {"coefficient": 0.4318, "kind": "m", "link": 3}
    assert told["never_acting"][0] == {"kind": "m", "link": 1}
    assert len(told["frames"]) == 6
    assert told["written"].startswith("PXX1 = Pxx1 + Pyy1 + J1 ")
    assert (told["drives"], told["files"], told["warnings"]) == (True, [], [])
