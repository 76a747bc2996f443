"""Standard uncertainties of all links at once, and parameters without one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from gd_analyze.errors import UsageError, require_type
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Link, LinkUncertainty
from gd_analyze.text import in_python, named_joints
from gd_analyze.units import Quantity

# Kinds of quantity in which each uncertainty may be stated.
_KINDS = {"mass": ("share", "mass"), "com": ("length",), "inertia": ("share", "inertia")}


@dataclass(frozen=True)
class StatedUncertainty:
    """Standard uncertainties of all links: shares of each link's values, or values in SI."""

    text: str  # as given
    quantities: tuple[tuple[str, Quantity], ...]  # by "mass", "com" or "inertia"

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read "mass=5%,com=2mm,inertia=10%", or some of these; UsageError for any other text."""
        stated: dict[str, Quantity] = {}
        for entry in text.split(","):
            name, _, amount = (part.strip() for part in entry.partition("="))
            quantity = Quantity.parse(amount)
            readable = quantity is not None and quantity.kind in _KINDS.get(name, ()) and not quantity.of
            if quantity is None or not readable or not quantity.si >= 0.0 or name in stated:
                raise UsageError(
                    "these are not uncertainties",
                    where="uncertainty",
                    expected="mass=5% (or kg), com=2mm (or m), inertia=10% (or kg m^2), each once",
                    found=in_python(text),
                )
            stated[name] = quantity
        return cls(text, tuple(stated.items()))

    def __str__(self) -> str:
        return self.text


def with_uncertainty(arm: RobotArm, uncertainty: StatedUncertainty | str) -> RobotArm:
    """Give every link only the standard uncertainties stated, or those of a text.

    Shares are of the link's values, for inertia entry by entry; kg m^2 apply to the moments. Raises
    UsageError if the text cannot be read.
    """
    if isinstance(uncertainty, str):
        uncertainty = StatedUncertainty.parse(uncertainty)
    require_type(uncertainty, StatedUncertainty, "uncertainty", "a StatedUncertainty or its text")
    stated = dict(uncertainty.quantities)
    return replace(arm, links=tuple(_stating(link, stated) for link in arm.links), spread=None)


def _stating(link: Link, stated: dict[str, Quantity]) -> Link:
    body, new = link.bare or link, LinkUncertainty()
    for name, quantity in stated.items():
        value, is_share = quantity.si, quantity.kind == "share"
        if name == "mass":
            new = replace(new, mass=value * (body.mass if is_share else 1.0))
        elif name == "com":
            new = replace(new, com=np.full(3, value))
        else:
            new = replace(new, inertia=value * (np.abs(body.inertia_com) if is_share else np.eye(3)))
    return replace(link, uncertainty=new)


def exactly_known(arm: RobotArm) -> str:
    """Parameters without a stated uncertainty: "mass of links 1 and 2; com of every link"; "" if none."""
    if arm.spread is not None:
        return ""
    sentences = []
    for quantity in _KINDS:
        links = [
            k for k, link in enumerate(arm.links, 1) if getattr(link.uncertainty, quantity, None) is None
        ]
        if links:
            sentences.append(f"{quantity} of {named_joints(links, arm.n_joints).replace('joint', 'link')}")
    return "; ".join(sentences)
