"""Split a robot arm's dynamics by effect, rank the parts, drop what the torque budget allows.

The jobs are functions of the package; `types` has the classes of values, `tables` the steps between the jobs.

>>> import gd_analyze as gd
>>> arm = gd.load_arm("puma560")
>>> trajectory = gd.read_trajectory("pick-and-place", arm)
>>> dataset = gd.decompose(arm, trajectory)
>>> ranking = gd.rank(dataset)
>>> model = gd.simplify(arm, trajectory, "1%")
"""

from __future__ import annotations

import importlib

import lazy_loader

__version__ = "0.3.0"

# The stub lists what is public, with the module of each name, which is imported when the name is first used:
# no command loads what it does not need.
_public, _, _names = lazy_loader.attach_stub(__name__, __file__)
__all__ = ["__version__", *_names]

# Names of earlier versions, and what does their work.
_REPLACED = {
    "find": "analyze",
    "simplify_certified": "simplify(..., certified=True)",
    "simplify_held": "simplify",
    "Schedule": "plan",
}


def __getattr__(name: str) -> object:
    """Import a public name; of any other, say where it is."""
    if name in __all__:
        return _public(name)
    message = f"{__name__} has no {name}"
    if name in _REPLACED:
        raise AttributeError(f"{message}; gd.{_REPLACED[name]} does its work")
    for home in ("types", "tables"):
        if not name.startswith("_") and name in importlib.import_module(f"{__name__}.{home}").__all__:
            raise AttributeError(f"{message}; it is gd.{home}.{name}")
    raise AttributeError(message)


def __dir__() -> list[str]:
    return sorted(__all__)
