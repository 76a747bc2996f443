"""MATLAB: GNU Octave runs every file in one process, with many states and with one."""

from __future__ import annotations

import shutil
import subprocess

import numpy as np
import pytest
from exported_cases import CASES, states, subject
from rounded_programs import assert_same

from gd_analyze.exporting.export import written

pytestmark = pytest.mark.skipif(
    shutil.which("octave") is None, reason="octave, which is too large to be installed for this, is not there"
)


def statements(case: str) -> str:
    """Lines that read a case's states, call it, and write what it gives."""
    what = subject(case)
    n, place = what.n, case.replace(" ", "_")
    results = ["tau", "D", "h", "c"] if what.torque else [x.name for x in what.functions[0].results]
    listed = [*results, *(["stated"] if what.torque else [])]
    arguments = "q, qd, qdd" if what.torque else "q, qd"
    shapes = {x.name: x.shape for function in what.functions for x in function.outputs}
    # Rows of matrices follow each other, as in every other language.
    flat = [f"reshape(permute({x}, [2 1 3]), {n * n}, [])" if len(shapes[x]) == 2 else x for x in results]
    first = [f"reshape({x}(:, :, 1)', [], 1)" if len(shapes[x]) == 2 else f"{x}(:, 1)" for x in results]
    return f"""
addpath('{place}');
file = fopen('{place}/states.bin'); all = fread(file, [{3 * n}, Inf], 'double'); fclose(file);
q = all(1:{n}, :); qd = all({n + 1}:{2 * n}, :); qdd = all({2 * n + 1}:{3 * n}, :);
[{", ".join(listed)}] = {what.name}({arguments});
file = fopen('{place}/results.bin', 'w'); fwrite(file, [{"; ".join(flat)}], 'double');
q = q(:, 1); qd = qd(:, 1); qdd = qdd(:, 1);
[{", ".join(listed)}] = {what.name}({arguments});
fwrite(file, [{"; ".join(first)}], 'double');
fclose(file);
{f"if stated.joints ~= {n}; error('stated'); end" if what.torque else ""}
rmpath('{place}'); clear('{what.name}');
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Everything that Octave makes of them."""
    folder = tmp_path_factory.mktemp("octave")
    lines = []
    for case in CASES:
        what, place = subject(case), folder / case.replace(" ", "_")
        written(what, "matlab").save(place)
        drawn = states(what.arm.name)
        np.hstack(drawn.arrays).tofile(place / "states.bin")
        lines.append(statements(case))
    lines.append("addpath('two_link_energy'); [~, ~, ~, ~, stated] = two_link([0; 0], [0; 0], [0; 0]);")
    lines.append("printf('%.17g %.17g\\n', [stated.error_bound; stated.lower]);")
    (folder / "every_case.m").write_text("\n".join(lines), encoding="ascii")
    done = subprocess.run(
        ["octave", "--no-gui", "--no-init-file", "--quiet", "every_case.m"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert "warning: " not in done.stderr
    (folder / "said.txt").write_text(done.stdout)
    return folder


@pytest.mark.parametrize("case", CASES)
def test_octave_gives_what_the_model_gives(case, folder):
    what, drawn = subject(case), states(case.split()[0])
    found = np.fromfile(folder / case.replace(" ", "_") / "results.bin").reshape(len(drawn.q) + 1, -1)
    many, one = found[:-1].T, found[-1]
    begin = 0
    for function in what.functions:
        size = sum(result.size for result in function.outputs)
        assert_same(many[begin : begin + size], function.program, drawn)
        begin += size
    assert begin == many.shape[0]
    # One state by itself: the library may take its sine in another way, by a rounding.
    np.testing.assert_allclose(one, many[:, 0], rtol=0, atol=1e-12 * np.abs(many).max())


def test_the_numbers_stated_are_the_certificates(folder):
    what = subject("two_link energy")
    bounds, lower = np.loadtxt(folder / "said.txt")
    assert (bounds >= what.certificate.certified).all()
    np.testing.assert_array_equal(lower, what.certificate.box.lower)
