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
    if name.startswith("_"):
        raise AttributeError(f"{__name__} has no {name}")
    if name in _REPLACED:
        raise AttributeError(f"{__name__} has no {name}; gd.{_REPLACED[name]} does its work")
    from gd_analyze.guesses import PACKAGE, missing

    homes = {other: f"gd.{other}" for other in __all__}
    for home in ("types", "tables"):
        members = importlib.import_module(f"{__name__}.{home}").__all__
        if name in members:
            raise AttributeError(f"{__name__} has no {name}; it is gd.{home}.{name}")
        homes |= {other: f"gd.{home}.{other}" for other in members}
    raise missing(__name__, name, PACKAGE, homes)


def __dir__() -> list[str]:
    return sorted(__all__)
