"""Base parameters in symbols are those of every arm with these zeros, whatever its numbers."""

from __future__ import annotations

import math
import re
import warnings

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.dynamics.base_parameters import base_parameters
from gd_analyze.errors import ArmError
from gd_analyze.formulas.base_symbols import BaseSymbols, base_symbols
from gd_analyze.formulas.languages import Plain
from gd_analyze.robots.arm_numbers import with_numbers
from parallel_axes import arm_of
from robot_files import joint, link, urdf

# Names in arm files of the symbols: x2 is a coordinate of a centre, I2xx an entry of an inertia.
NAMES = {
    r"([ad])(\d)": "joint{1}.{0}",
    r"l(\d)": "joint{0}.d",
    r"p(\d)([xyz])": "joint{0}.xyz.{1}",
    r"m(\d)": "link{0}.mass",
    r"([xyz])(\d)": "link{1}.com.{0}",
    r"I(\d)([xyz]{{2}})": "link{0}.inertia.{1}",
    r"J(\d)": "drive{0}.inertia",
}


def file_name(symbol: str) -> str:
    for pattern, name in NAMES.items():
        if match := re.fullmatch(pattern.replace("{{", "{").replace("}}", "}"), symbol):
            return name.format(*match.groups())
    raise LookupError(symbol)


def value(polynomial, values) -> float:
    return sum(weight * math.prod(values[name] for name in names) for names, weight in polynomial.items())


def numbers_of(symbols: BaseSymbols, values) -> list[float]:
    """The base parameters by their symbols' values."""
    links = {key: value(polynomial, values) for key, polynomial in symbols.links.items()}
    links |= {("m", k): values.get(f"m{k}", 0.0) for k in range(1, 10)}
    links |= {("J", k): values.get(f"J{k}", 0.0) for k in range(1, 10)}
    return [
        sum(value(polynomial, values) * links[key] for key, polynomial in shares.items())
        for shares in symbols.combinations
    ]


def assert_true_of_other_numbers(arm, seed: int = 1) -> BaseSymbols:
    symbols = base_symbols(base_parameters(arm))
    rng = np.random.default_rng(seed)
    # An inertia as a whole, so that it stays possible.
    scaled = {name: name[:2] if name[0] == "I" else name for name in symbols.values}
    scales = {name: rng.uniform(0.8, 1.2) for name in scaled.values()}
    values = {name: number * scales[scaled[name]] for name, number in symbols.values.items()}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        other = with_numbers(arm, {file_name(name): number for name, number in values.items()})
    for numbers, of_arm in ((symbols.values, arm), (values, other)):
        expected = [parameter.number for parameter in base_parameters(of_arm)]
        size = max(map(abs, expected))
        # Polynomials of some ten terms, fitted to some dozens of arms.
        np.testing.assert_allclose(numbers_of(symbols, numbers), expected, rtol=0, atol=1e-10 * size)
    return symbols


@pytest.mark.parametrize("name", gd.builtin_arms())
def test_built_in_arms(name):
    assert_true_of_other_numbers(gd.load_arm(name))


def test_what_is_written(puma):
    symbols = base_symbols(base_parameters(puma))
    lines = {line.split(" = ")[0]: line for line in map(Plain(3).line, symbols.formulas())}
    assert lines["MX2"] == "MX2 = mx2 + a2 m3..6"
    assert lines["PXY3"] == "PXY3 = Pxy3 - a3 mz4 - a3 d4 m4..6"
    assert lines["PXX2"] == "PXX2 = Pxx2 + 0.5 J2 + a2² m3..6"
    definitions = list(map(Plain(3).line, symbols.definitions()))
    assert "mx2 = m2 x2 + m2 a2" in definitions
    assert "Pyy3 = 0.5 I3xx + 0.5 I3yy - 0.5 I3zz + m3 z3²" in definitions


def test_a_robot_file(tmp_path):
    path = tmp_path / "arm.urdf"
    right = "1.5707963267948966"
    path.write_text(
        urdf(
            link("base"),
            link("upper", rpy="0 0 0"),
            link("lower", 1.0, rpy="0 0 0"),
            link("hand", 0.5, rpy="0 0 0"),
            joint("a", "base", "upper", rpy="0 0 0", xyz="0 0 0.3"),
            joint("b", "upper", "lower", rpy=f"{right} 0 0", xyz="0.1 0 0.2"),
            joint("c", "lower", "hand", "prismatic", rpy="0 0 0", xyz="0.4 0 0", axis="1 0 0"),
        )
    )
    symbols = assert_true_of_other_numbers(gd.load_arm(path))
    assert {"p2x", "m3"} <= {*symbols.values}


def test_what_no_polynomial_tells_is_refused(rng):
    with pytest.raises(ArmError, match="cannot be written in symbols") as refused:
        base_symbols(base_parameters(arm_of(["askew"] * 4, rng)))
    assert "without --symbolic" in refused.value.with_options()
