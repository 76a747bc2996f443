"""`import gd_analyze as gd`: every name, every example, and nothing slow."""

from __future__ import annotations

import doctest
import importlib
import json
import pkgutil
import subprocess
import sys

import pytest

import gd_analyze as gd


@pytest.mark.parametrize("name", gd.__all__)
def test_every_public_name_is_there_and_documented(name):
    value = getattr(gd, name)
    assert name in dir(gd)
    if name != "__version__":
        assert value.__doc__


def test_an_unknown_name():
    with pytest.raises(AttributeError, match="no attribute 'colour'"):
        _ = gd.colour


def test_every_name_is_public_once():
    assert len(set(gd.__all__)) == len(gd.__all__)
    assert set(dir(gd)) >= set(gd.__all__)


def loaded_by(statement: str) -> set[str]:
    script = f"{statement}\nimport json, sys\nprint(json.dumps(list(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, text=True)
    return set(json.loads(done.stdout))


def test_importing_it_loads_nothing_slow():
    loaded = loaded_by("import gd_analyze")
    assert not loaded & {"numpy", "scipy", "pandas", "matplotlib", "pinocchio", "xarray", "h5py", "pydantic"}


def test_loading_an_arm_loads_no_plots_and_no_authority():
    loaded = loaded_by("import gd_analyze as gd; gd.load_arm('puma560')")
    assert not loaded & {"matplotlib", "pinocchio", "xarray", "plotly", "typst", "scipy"}


MODULES = sorted(
    module.name
    for module in pkgutil.walk_packages(gd.__path__, "gd_analyze.")
    if not module.name.startswith(("gd_analyze.report", "gd_analyze.cli", "gd_analyze.motions"))
)


@pytest.mark.parametrize("name", ["gd_analyze", *MODULES])
def test_examples_in_docstrings(name):
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def test_there_are_examples_to_test():
    finder = doctest.DocTestFinder()
    found = [test for name in MODULES for test in finder.find(importlib.import_module(name)) if test.examples]
    assert len(found) >= 4
