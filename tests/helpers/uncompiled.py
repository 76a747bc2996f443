"""The search's kernels as plain Python, a minute sooner than compiled, on arrays that refuse negative places.

A compiled kernel and NumPy take place -1, which is what is left of the reference of a number 0, as the last.
"""

from __future__ import annotations

import importlib.util
import sys
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import gd_analyze.program_search as package
from gd_analyze.program_search import layout
from gd_analyze.program_search.layout import Layout


def _decorator(*_: Any, **__: Any) -> Any:
    return lambda function: function


def _loaded(name: str, **instead: Any) -> ModuleType:
    """A second copy of a module of the package, which finds other modules in place of some."""
    spec = importlib.util.spec_from_file_location(f"uncompiled_{name}", f"{package.__path__[0]}/{name}.py")
    module = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "numba", SimpleNamespace(njit=_decorator))
        patch.setitem(sys.modules, spec.name, module)
        for key, value in instead.items():
            patch.setitem(sys.modules, f"{package.__name__}.{key}", value)
            patch.setattr(package, key, value, raising=False)
        spec.loader.exec_module(module)
    return module


class Guarded(np.ndarray):
    """An array without negative places; whole numbers are Python's, as 32 bits are too few for a hash."""

    def __getitem__(self, place: Any) -> Any:
        _refuse_negative(place)
        value = super().__getitem__(place)
        return int(value) if isinstance(value, (np.int8, np.int32, np.int64)) else value

    def __setitem__(self, place: Any, value: Any) -> None:
        _refuse_negative(place)
        super().__setitem__(place, value)


def _refuse_negative(place: Any) -> None:
    for each in place if isinstance(place, tuple) else (place,):
        if isinstance(each, (int, np.integer)) and each < 0:
            raise IndexError(f"place {each} is before the first")


def guarded(value: Any) -> Any:
    """Arrays, or tuples of them at any depth, that share their memory and are guarded."""
    if isinstance(value, np.ndarray):
        return value.view(Guarded)
    if isinstance(value, tuple) and hasattr(value, "_make"):
        return type(value)._make(map(guarded, value))
    return value


def guarded_layout(made: Layout) -> Layout:
    return Layout(made.trace, made.leaves, guarded(made.about), guarded(made.exact))


kernels: Any = _loaded("kernels")
search: Any = _loaded("search", kernels=kernels)


def nodes_of_size(room: int, outputs: int) -> layout.Nodes:
    return guarded(layout.nodes_of_size(room, outputs))


def canonical(nodes: layout.Nodes, leaves: layout.Leaves) -> tuple[layout.Nodes, Any] | None:
    """Canonical form and degrees of its nodes, or None where there is none."""
    room = nodes.kind.size
    new = nodes_of_size(room, nodes.outputs.size)
    canon = guarded(canon_of(room, kernels))
    return (new, canon.degree) if kernels.canonical(nodes, new, canon, leaves) else None


def canon_of(room: int, module: Any) -> Any:
    whole = [np.zeros(room, dtype=kind) for kind in (np.int32, np.int8, np.int8)]
    table = np.zeros(1 << (4 * room).bit_length(), dtype=np.int32)
    return module.Canon(table, whole[0], whole[1], np.zeros(4 * room, dtype=np.int32), whole[2])


def cost(nodes: layout.Nodes, leaves: layout.Leaves) -> float:
    return float(kernels.cost(nodes, leaves, guarded(np.zeros(nodes.kind.size, dtype=np.int8))))


def values_of(nodes: layout.Nodes, leaf_values: np.ndarray) -> np.ndarray:
    """Values of all nodes, shape (nodes, N), from those of the leaves."""
    values = guarded(np.zeros((int(nodes.length[0]), leaf_values.shape[1])))
    values[: len(leaf_values)] = leaf_values
    kernels.evaluate_nodes(nodes, values, len(leaf_values), 0, leaf_values.shape[1])
    return values
