"""`import gd_analyze as gd`: every name, every example, and nothing slow."""

from __future__ import annotations

import doctest
import importlib
import json
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest

import gd_analyze as gd


def test_every_public_name_is_there_and_documented():
    assert (Path(gd.__file__).parent / "py.typed").is_file()
    assert {"analyze", "load_arm", "types", "tables", "__version__"} <= set(gd.__all__) == set(dir(gd))
    for name in gd.__all__:
        assert getattr(gd, name).__doc__
    for group in (gd.types, gd.tables):
        assert len(group.__all__) == len(set(group.__all__) - set(gd.__all__))
        for name in group.__all__:
            assert getattr(group, name).__doc__
            with pytest.raises(AttributeError, match=rf"^gd_analyze has no {name}; it is gd\.\w+\.{name}$"):
                getattr(gd, name)
    with pytest.raises(AttributeError, match=r"^gd_analyze has no colour$"):
        _ = gd.colour
    with pytest.raises(AttributeError, match=r"gd\.simplify does its work"):
        _ = gd.simplify_held
    with pytest.raises(ImportError):
        exec("from gd_analyze import Box")


@pytest.mark.parametrize(
    ("statement", "slow"),
    [
        ("import gd_analyze", {"numpy", "pandas", "pydantic", "scipy"}),
        ("import gd_analyze.cli.app", {"numpy", "pandas", "pydantic", "scipy"}),
        ("import gd_analyze as gd; gd.load_arm('puma560')", {"matplotlib", "pinocchio", "xarray", "scipy"}),
        ("import gd_analyze as gd; gd.analyze", {"pandas", "pydantic_core", "xarray", "scipy", "jinja2"}),
    ],
)
def test_nothing_slow_is_loaded_early(statement, slow):
    script = f"{statement}\nimport json, sys\nprint(json.dumps(list(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, text=True)
    assert not set(json.loads(done.stdout)) & slow


# A whole main job.
LONG_EXAMPLE = "gd_analyze.studies.main_job"


def test_examples_in_docstrings():
    ran = 0
    for module in pkgutil.walk_packages(gd.__path__, "gd_analyze."):
        if not module.name.startswith(("gd_analyze.report", "gd_analyze.cli", LONG_EXAMPLE)):
            result = doctest.testmod(importlib.import_module(module.name))
            assert result.failed == 0, module.name
            ran += result.attempted
    assert ran >= 20


@pytest.mark.slow
def test_the_example_of_the_main_job():
    result = doctest.testmod(importlib.import_module(LONG_EXAMPLE))
    assert (result.failed, result.attempted > 0) == (0, True)
