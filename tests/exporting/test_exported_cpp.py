"""C++: a header of templates; with double it gives what the model gives, with dual numbers its slopes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from compiled import STRICT, called, compiled, needs_gpp
from exported_cases import FEW, states, subject
from rounded_programs import assert_same, evaluated, slope

from gd_analyze.exporting.export import written
from made_models import ROUND_OFF

pytestmark = needs_gpp

READING = """
#include <cstdio>
#include <cstdlib>
#include <vector>

template <class T> struct Reader {
    size_t count, joints;
    std::vector<double> all;
    Reader(const char *word, size_t n) : count(size_t(std::atol(word))), joints(n), all(3 * n * count)
    {
        if (std::fread(all.data(), sizeof(double), all.size(), stdin) != all.size())
            std::exit(1);
    }
    T at(size_t kind, size_t joint, size_t s) const { return T(all[(kind * joints + joint) * count + s]); }
};
"""

DUAL = """
// Forward differentiation, as a stranger would write it: nothing but a value and a slope.
struct Dual {
    double v, d;
    Dual() : v(0), d(0) {}
    explicit Dual(double value, double slope = 0) : v(value), d(slope) {}
};
inline Dual operator+(Dual a, Dual b) { return Dual(a.v + b.v, a.d + b.d); }
inline Dual operator-(Dual a, Dual b) { return Dual(a.v - b.v, a.d - b.d); }
inline Dual operator-(Dual a) { return Dual(-a.v, -a.d); }
inline Dual operator*(Dual a, Dual b) { return Dual(a.v * b.v, a.d * b.v + a.v * b.d); }
inline Dual sin(Dual a);
inline Dual cos(Dual a);
"""


def run(what, body, folder: Path, drawn, *flags):
    """Compile a program around `body`, which writes what it finds of the state s, and give it the states."""
    written(what, "cpp").save(folder)
    text = f"{READING}\n{body}"
    (folder / "main.cpp").write_text(text, encoding="ascii")
    program = compiled("g++", [folder / "main.cpp"], folder / "run", f"-I{folder}", *flags)
    rows = np.concatenate([x.T for x in drawn.arrays])
    return np.frombuffer(called(program, str(len(drawn.q)), given=rows.tobytes()))


@pytest.mark.parametrize("case", [*FEW, "puma560 term"])
def test_it_gives_what_the_model_gives(case, tmp_path):
    what, drawn = subject(case), states(case.split()[0])
    calls, sizes = [], []
    for function in what.functions:
        size = sum(result.size for result in function.outputs)
        begins = np.cumsum([0, *(result.size for result in function.outputs)])
        results = ", ".join(f"out + {begin}" for begin in begins[:-1])
        calls.append(
            f"{{ double out[{size}]; {what.name}::{function.name}"
            f"({', '.join(function.arguments)}, {results}); std::fwrite(out, 8, {size}, stdout); }}"
        )
        sizes.append(size)
    body = f"""
#include "{what.name}.hpp"
int main(int some, char **words)
{{
    Reader<double> given(words[some - 1], {what.name}::joints);
    for (size_t s = 0; s < given.count; s++) {{
        double q[{what.n}], qd[{what.n}], qdd[{what.n}];
        for (size_t j = 0; j < {what.n}; j++) {{
            q[j] = given.at(0, j, s);
            qd[j] = given.at(1, j, s);
            qdd[j] = given.at(2, j, s);
        }}
        {" ".join(calls)}
        (void)qdd;
    }}
}}
"""
    found = run(what, body, tmp_path, drawn).reshape(len(drawn.q), -1).T
    begin = 0
    for function, size in zip(what.functions, sizes, strict=True):
        assert_same(found[begin : begin + size], function.program, drawn)
        begin += size


def test_types_that_differentiate_themselves_work(tmp_path):
    """Values and slopes of the torque by q2, by dual numbers whose sin and cos are their own."""
    what, drawn = subject("stanford"), states("stanford").at(slice(100))
    body = f"""
{DUAL}
#include "{what.name}.hpp"
inline Dual sin(Dual a) {{ return Dual(std::sin(a.v), a.d * std::cos(a.v)); }}
inline Dual cos(Dual a) {{ return Dual(std::cos(a.v), -a.d * std::sin(a.v)); }}
int main(int some, char **words)
{{
    Reader<double> given(words[some - 1], {what.name}::joints);
    for (size_t s = 0; s < given.count; s++) {{
        Dual q[6], qd[6], qdd[6], tau[6];
        for (size_t j = 0; j < 6; j++) {{
            q[j] = Dual(given.at(0, j, s), j == 1);
            qd[j] = Dual(given.at(1, j, s));
            qdd[j] = Dual(given.at(2, j, s));
        }}
        {what.name}::torque(q, qd, qdd, tau);
        for (size_t j = 0; j < 6; j++)
            std::fwrite(&tau[j].v, 8, 1, stdout), std::fwrite(&tau[j].d, 8, 1, stdout);
    }}
}}
"""
    found = run(what, body, tmp_path, drawn).reshape(len(drawn.q), 6, 2)
    assert_same(found[..., 0].T, what.torque.program, drawn)
    exact = slope(what.torque.program, drawn, "q2")
    # Some hundred products of sizes up to the largest slope's.
    assert np.abs(found[..., 1].T - exact).max() <= ROUND_OFF * np.abs(exact).max()


def test_single_precision_too(tmp_path):
    what, drawn = subject("two_link recursive"), states("two_link").at(slice(100))
    body = f"""
#include "{what.name}.hpp"
int main(int some, char **words)
{{
    Reader<float> given(words[some - 1], 2);
    for (size_t s = 0; s < given.count; s++) {{
        float q[2] = {{given.at(0, 0, s), given.at(0, 1, s)}};
        float qd[2] = {{given.at(1, 0, s), given.at(1, 1, s)}};
        float qdd[2] = {{given.at(2, 0, s), given.at(2, 1, s)}}, tau[2];
        {what.name}::torque(q, qd, qdd, tau);
        for (int j = 0; j < 2; j++) {{
            double x = tau[j];
            std::fwrite(&x, 8, 1, stdout);
        }}
    }}
}}
"""
    found = run(what, body, tmp_path, drawn).reshape(-1, 2).T
    values, bound = evaluated(what.torque.program, drawn, float(np.finfo(np.float32).eps))
    # Inputs are rounded, too: a slope of some hundred times eps of an input of at most ten.
    assert (np.abs(found - values) <= bound + 1e4 * np.finfo(np.float32).eps).all()


def test_a_state_is_within_up_to_the_edges(tmp_path):
    what = subject("two_link energy")
    body = """
#include "two_link.hpp"
#include <limits>
int main(int, char **)
{
    using namespace two_link;
    const double nothing[2] = {0, 0}, none = std::numeric_limits<double>::quiet_NaN();
    double back[2] = {-velocity[0], -velocity[1]}, q[2] = {upper[0] * (1 + 1e-15), 0}, odd[2] = {0, none};
    double found[] = {
        double(is_within(lower, velocity, acceleration)), double(is_within(upper, back, nothing)),
        double(is_within(q, nothing, nothing)), double(is_within(odd, nothing, nothing)),
        double(is_within(nothing, odd, nothing)), double(is_within(nothing, nothing, odd)),
        error_bound[0], error_bound[1], double(joint_shoulder), double(joint_elbow),
    };
    std::fwrite(found, 8, 10, stdout);
}
"""
    found = run(what, body, tmp_path, states("two_link").at(slice(0)))
    assert found[:6].tolist() == [1, 1, 0, 0, 0, 0]
    assert (found[6:8] >= what.certificate.certified).all()
    assert found[8:].tolist() == [0, 1]


@pytest.mark.skipif(not Path("/usr/include/eigen3").exists(), reason="Eigen's headers are not installed")
def test_vectors_of_eigen(tmp_path):
    what, drawn = subject("two_link energy"), states("two_link").at(slice(20))
    body = """
#include <Eigen/Core>
#include "two_link.hpp"
int main(int some, char **words)
{
    typedef Eigen::Matrix<double, 2, 1> Vector;
    Reader<double> given(words[some - 1], 2);
    for (size_t s = 0; s < given.count; s++) {
        const Vector q(given.at(0, 0, s), given.at(0, 1, s)), qd(given.at(1, 0, s), given.at(1, 1, s));
        const Vector qdd(given.at(2, 0, s), given.at(2, 1, s));
        const Vector apart = two_link::inertia(q) * qdd + two_link::coriolis_centrifugal(q, qd)
            + two_link::gravity_loading(q) - two_link::torque(q, qd, qdd);
        std::fwrite(apart.data(), 8, 2, stdout);
    }
}
"""
    # Eigen's own headers have warnings that are not ours.
    apart = run(what, body, tmp_path, drawn, "-isystem", "/usr/include/eigen3", "-Wno-unused-parameter")
    largest = np.abs(evaluated(what.torque.program, drawn)[0]).max()
    # A dozen roundings of sums of the torque's size.
    assert apart.size == 40
    assert np.abs(apart).max() <= 64 * np.finfo(float).eps * largest


@pytest.mark.parametrize("standard", ["c++11", "c++14", "c++17", "c++20"])
def test_every_standard_takes_it(standard, tmp_path):
    written(subject("two_link energy"), "cpp").save(tmp_path)
    (tmp_path / "main.cpp").write_text('#include "two_link.hpp"\n#include "two_link.hpp"\nint main() {}\n')
    called("g++", f"-std={standard}", *STRICT, "-fsyntax-only", tmp_path / "main.cpp")
