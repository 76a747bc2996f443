"""One public name, one notion: no two modules define the same, but for what is the same on purpose."""

from __future__ import annotations

import ast
from collections import defaultdict
from pathlib import Path

import gd_analyze as gd

SOURCE = Path(gd.__file__).parent
# The torque by one formulation each, which a table calls by that name.
SAME_ON_PURPOSE = {"torque"}
# The command line calls a library's job by its own name, and its options by their subjects.
FACES = SOURCE / "cli"


def public_names(path: Path) -> set[str]:
    """Classes, functions and values that a module defines for others."""
    names = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            names.add(node.target.id)
        elif isinstance(node, ast.Assign):
            names |= {target.id for target in node.targets if isinstance(target, ast.Name)}
    return {name for name in names if not name.startswith("_")}


def test_no_two_modules_define_one_name():
    modules = defaultdict(list)
    for path in SOURCE.rglob("*.py"):
        if FACES not in path.parents:
            for name in public_names(path):
                modules[name].append(path.relative_to(SOURCE).as_posix())
    shared = {name: sorted(paths) for name, paths in modules.items() if len(paths) > 1}
    assert {name: paths for name, paths in shared.items() if name not in SAME_ON_PURPOSE} == {}
    assert shared.keys() == SAME_ON_PURPOSE
