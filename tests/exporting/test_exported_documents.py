"""MATLAB and LaTeX: run and typeset where Octave and pdflatex are; LaTeX is closed as it was opened."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from exported_cases import CASES, HOSTILE, TORQUES, hostile, states, subject
from gd_analyze.exporting.export import written
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.formulas.languages import LatexPrinter
from gd_analyze.formulas.steps import NamedSteps
from gd_analyze.text import number
from long_cases import long
from rounded_programs import PAYLOAD, assert_same, parameters_given
from running import called, needs, size_of

OCTAVE = ("octave", "--no-gui", "--no-init-file", "--quiet")
PLACES = [(case, first) for case, first in HOSTILE if case in TORQUES]


def statements(case: str) -> str:
    """Lines that read a case's states, call it, and write what it gives, of all states and of the first."""
    what = subject(case)
    n, place = what.n, case.replace(" ", "_")
    # By function: the torque and that of parameters are both called tau.
    shapes = {f"{function.name}_{x.name}": x.shape for function in what.functions for x in function.outputs}
    main, further = what.functions[:4], what.functions[4:]
    listed = [f"{function.name}_{x.name}" for function in main for x in function.outputs]
    listed += ["stated"] * bool(what.torque) + ["further"] * bool(further)
    calls = [f"[{', '.join(listed)}] = {what.name}({'q, qd, qdd' if what.torque else 'q, qd'});"]
    for function in further:
        names = ", ".join(f"{function.name}_{x.name}" for x in function.outputs)
        given = ", ".join("qdd" if word == "tau" else word for word in function.arguments)
        calls.append(f"[{names}] = further.{function.name}({given});")
    # Rows of matrices follow each other, as in every other language.
    flat = (
        f"reshape(permute({x}, [2 1 3]), {shapes[x][0] * shapes[x][1]}, [])" if shapes[x][1:] else x
        for x in shapes
    )
    first = (f"reshape({x}(:, :, 1)', [], 1)" if shapes[x][1:] else f"{x}(:, 1)" for x in shapes)
    called_all = "\n".join(calls)
    return f"""
addpath('{place}');
file = fopen('{place}/states.bin'); all = fread(file, [{3 * n}, Inf], 'double'); fclose(file);
q = all(1:{n}, :); qd = all({n + 1}:{2 * n}, :); qdd = all({2 * n + 1}:{3 * n}, :);
payload = [{"; ".join(map(str, PAYLOAD))}];
parameters = [{"; ".join(map(str, parameters_given(len(what.base or ()))))}];
{called_all}
file = fopen('{place}/results.bin', 'w'); fwrite(file, [{"; ".join(flat)}], 'double');
q = q(:, 1); qd = qd(:, 1); qdd = qdd(:, 1);
{called_all}
fwrite(file, [{"; ".join(first)}], 'double');
fclose(file);
{f"if stated.joints ~= {n}; error('stated'); end" if what.torque else ""}
rmpath('{place}'); clear('{what.name}');
"""


def test_a_box_of_many_joints_is_named_in_full():
    names = [f"joint_with_a_long_name_{k}" for k in range(1, 8)]
    what = subject("two_link energy")
    box = replace(what.certificate.box, where=f"a range is assumed of joint {', '.join(names)}")
    what = replace(what, certificate=replace(what.certificate, region=box))
    (text,) = (text for name, text in written(what, "c").files.items() if name.endswith(".h"))
    assert all(name in text for name in names)


# Two cases of models, with all functions of one of them; writing and reading those of six joints takes long.
FEW = ("two_link term", "two_link energy", "two_link further", "two_link decomposition")


@needs("octave")
@pytest.mark.parametrize("cases", [FEW, long(CASES)], ids=["few", "all"])
def test_octave_gives_what_the_model_gives(cases, tmp_path):
    """All cases in one process, which takes long to start."""
    lines = []
    for case in cases:
        place = tmp_path / case.replace(" ", "_")
        written(subject(case), "matlab").save(place)
        np.hstack(states(case).arrays).tofile(place / "states.bin")
        lines.append(statements(case))
    lines.append("addpath('two_link_energy'); [~, ~, ~, ~, stated] = two_link([0; 0], [0; 0], [0; 0]);")
    lines.append("printf('%.17g %.17g\\n', [stated.error_bound; stated.lower]);")
    (tmp_path / "every_case.m").write_text("\n".join(lines), encoding="ascii")
    said = called(*OCTAVE, "every_case.m", folder=tmp_path).decode()
    for case in cases:
        what, drawn = subject(case), states(case)
        found = np.fromfile(tmp_path / case.replace(" ", "_") / "results.bin").reshape(len(drawn) + 1, -1)
        sizes = [size_of(function) for function in what.functions]
        assert found.shape[1] == sum(sizes)
        parts = np.split(found[:-1], np.cumsum(sizes)[:-1], axis=1)
        for function, part in zip(what.functions, parts, strict=True):
            assert_same(part.T, function.program, drawn)
        # One state by itself: the library may take its sine in another way, by a rounding.
        np.testing.assert_allclose(found[-1], found[0], rtol=0, atol=1e-12 * np.abs(found).max())
    bounds, lower = np.array(said.split(), dtype=float).reshape(2, -1)
    certificate = subject("two_link energy").certificate
    assert (bounds >= certificate.certified).all()
    np.testing.assert_array_equal(lower, certificate.box.lower)


@needs("octave")
def test_octave_takes_any_names(tmp_path):
    lines = []
    for what in (hostile(*place) for place in HOSTILE):
        written(what, "matlab").save(tmp_path)
        zeros = ", ".join([f"zeros({what.n}, 1)"] * (3 if what.torque else 2))
        lines.append(f"{what.name}({zeros});")
    (tmp_path / "every_name.m").write_text("\n".join([*lines, "printf('done');"]))
    before = sorted(tmp_path.iterdir())
    assert called(*OCTAVE, "every_name.m", folder=tmp_path).endswith(b"done")
    assert sorted(tmp_path.iterdir()) == before


def latex_of(place) -> tuple[ExportInput, str]:
    """A case by its name, or with hostile names, and its text."""
    what = subject(place) if isinstance(place, str) else hostile(*place)
    (text,) = written(what, "latex").files.values()
    return what, text


@pytest.mark.parametrize("place", [*TORQUES, *map(long, PLACES[::2])], ids=str)
def test_what_is_opened_is_closed(place):
    text = re.sub(r"^%.*$", "", latex_of(place)[1], flags=re.MULTILINE)
    plain = re.sub(r"\\[{}\\%#&$_]", "", text)
    opened = []
    for kind, name in re.findall(r"\\(begin|end)\{(\w+\*?)\}", plain):
        if kind == "begin":
            opened.append(name)
        else:
            assert opened.pop() == name
    assert not opened
    depths = np.cumsum([(sign == "{") - (sign == "}") for sign in plain])
    assert (depths.min(), depths[-1]) == (0, 0)
    assert plain.count("$") % 2 == 0
    # A comment is none of ours, nor is a command that reads or writes.
    assert "%" not in plain
    assert not re.search(r"\\(input|include|write|openout|read|catcode|def|immediate)\b", text)


@pytest.mark.parametrize("case", TORQUES)
def test_latex_tells_errors_and_bounds(case):
    what, text = latex_of(case)
    for j in range(what.n):
        assert rf"\tau_{{{j + 1}}} &=" in text
    if what.certificate is None:
        assert "Proven" not in text
        return
    stated = re.findall(r"& ([\d.e-]+) \\\\$", text.rpartition("Proven: ")[2], re.MULTILINE)
    for bound, certified in zip(stated, what.certificate.certified, strict=True):
        assert float(bound) >= certified
    for error in what.model.accuracy.errors.peak_torque:
        assert number(float(error)) in text


def test_latex_has_a_line_for_every_named_step():
    what, text = latex_of("puma560")
    program, printer = what.torque.program, LatexPrinter(6)
    formulas = NamedSteps(program).formulas
    assert len(formulas) > 2 * what.n
    places = [text.index(f"{printer.symbol(formula.left)} &=") for formula in formulas]
    assert places == sorted(places)
    assert f"{program.count.total} " in text


@needs("pdflatex")
@pytest.mark.parametrize("place", ["two_link energy", "puma560", "stanford", *PLACES[::5]], ids=str)
def test_latex_is_typeset(place, tmp_path):
    _, text = latex_of(place)
    (tmp_path / "out.tex").write_text(text, encoding="ascii")
    words = ("pdflatex", "-no-shell-escape", "-interaction=nonstopmode", "-halt-on-error", "out.tex")
    log = called(*words, folder=tmp_path).decode(errors="replace")
    assert (tmp_path / "out.pdf").stat().st_size > 10_000
    assert "undefined" not in log
    assert {path.suffix for path in tmp_path.iterdir()} == {".tex", ".pdf", ".log", ".aux"}
