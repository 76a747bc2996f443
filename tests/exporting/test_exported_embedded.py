"""C on a bare machine: no library but sines, no memory, 32 bits."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest
from compiled import STRICT, called, needs_gcc
from exported_cases import subject

from gd_analyze.exporting.export import printed

CASES = ("two_link energy", "puma560", "stanford decomposition")
SCALARS = ("double", "float")
# What the generated code calls, and what a compiler may put in for a loop that copies or a sum of both.
LIBM = {"sin", "cos", "fabs", "sincos"}
COPIES = {"memcpy", "memset", "memmove"}


def sources(tmp_path, scalar):
    for case in CASES:
        what = subject(case)
        printed(what, "c", scalar).save(tmp_path)
        yield tmp_path / f"{what.name}.c"


def wanted_by(object_file) -> set[str]:
    """Symbols that an object file does not hold itself."""
    return {line.split()[-1] for line in called("nm", "-u", object_file).decode().splitlines()}


@needs_gcc
@pytest.mark.skipif(shutil.which("nm") is None, reason="nm is not installed")
@pytest.mark.parametrize("scalar", SCALARS)
@pytest.mark.parametrize("level", ["-O0", "-O2"])
def test_it_needs_sines_and_nothing_else(scalar, level, tmp_path):
    suffix = "f" if scalar == "float" else ""
    for source in sources(tmp_path, scalar):
        out = source.with_suffix(".o")
        called("gcc", "-std=c99", *STRICT, level, "-ffreestanding", "-c", source, "-o", out)
        assert wanted_by(out) <= {f"{name}{suffix}" for name in LIBM} | COPIES
        # Nothing is written to but what the caller gives: constants alone, no data of its own.
        kinds = set(re.findall(r"^\w* +(\w) ", called("nm", out).decode(), re.MULTILINE))
        assert kinds <= {"T", "t", "R", "r", "U"}


@needs_gcc
@pytest.mark.parametrize("scalar", SCALARS)
def test_it_includes_two_headers_of_the_standard(scalar, tmp_path):
    for source in sources(tmp_path, scalar):
        texts = source.read_text() + source.with_suffix(".h").read_text()
        assert set(re.findall(r"#include <(.*)>", texts)) <= {"math.h", "stddef.h"}
        assert not re.search(r"\b(malloc|free|static [a-z]+ \w+ ?=|goto|printf)\b", texts)


@needs_gcc
@pytest.mark.parametrize("scalar", SCALARS)
def test_it_compiles_for_32_bits(scalar, tmp_path):
    probe = subprocess.run(
        ["gcc", "-m32", "-std=c99", "-x", "c", "-c", "-", "-o", "/dev/null"],
        input=b"#include <math.h>\n#include <stddef.h>\nint x;\n",
        capture_output=True,
        check=False,
    )
    if probe.returncode:
        pytest.skip("the 32-bit headers of the C library are not installed")
    for source in sources(tmp_path, scalar):
        called("gcc", "-m32", "-std=c99", *STRICT, "-c", source, "-o", source.with_suffix(".o"))


@pytest.mark.skipif(shutil.which("arm-none-eabi-gcc") is None, reason="arm-none-eabi-gcc is not installed")
@pytest.mark.parametrize("scalar", SCALARS)
def test_it_compiles_for_a_microcontroller(scalar, tmp_path):
    for source in sources(tmp_path, scalar):
        words = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-ffreestanding")
        called("arm-none-eabi-gcc", "-std=c99", *STRICT, *words, "-c", source, "-o", source.with_suffix(".o"))


@needs_gcc
def test_single_precision_computes_in_single_precision(tmp_path):
    """Not a number, a sine or a sum in between is a double: `-Wdouble-promotion` would say so."""
    for source in sources(tmp_path, "float"):
        words = ("-Wdouble-promotion", "-Wunsuffixed-float-constants", "-Wfloat-conversion")
        called("gcc", "-std=c99", *STRICT, *words, "-c", source, "-o", source.with_suffix(".o"))
