"""Standard uncertainties of all links at once, and parameters without one."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from gd_analyze.errors import UsageError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Link, LinkUncertainty
from gd_analyze.text import UNSIGNED, in_python, named_joints

_FACTORS = {
    "mass": {"%": 0.01, "kg": 1.0},
    "com": {"mm": 1e-3, "m": 1.0},
    "inertia": {"%": 0.01, "kgm^2": 1.0},
}


def with_uncertainty(arm: RobotArm, text: str) -> RobotArm:
    """Give every link only the standard uncertainties of "mass=5%,com=2mm,inertia=10%", or some of these.

    Shares are of the link's values, for inertia entry by entry; kg m^2 apply to the moments. Raises
    UsageError if the text cannot be read.
    """
    stated: dict[str, tuple[float, bool]] = {}
    for entry in text.split(","):
        match = re.fullmatch(rf"(mass|com|inertia)=({UNSIGNED})(%|[a-z]+(?:\^2)?)", re.sub(r"\s+", "", entry))
        factor = _FACTORS[match[1]].get(match[3]) if match else None
        if match is None or factor is None or match[1] in stated:
            raise UsageError(
                "these are not uncertainties",
                where="uncertainty",
                expected="mass=5% (or kg), com=2mm (or m), inertia=10% (or kg m^2), each once",
                found=in_python(text),
            )
        stated[match[1]] = factor * float(match[2]), match[3] == "%"
    return replace(arm, links=tuple(_stating(link, stated) for link in arm.links), spread=None)


def _stating(link: Link, stated: dict[str, tuple[float, bool]]) -> Link:
    body, new = link.bare or link, LinkUncertainty()
    for quantity, (value, is_share) in stated.items():
        if quantity == "mass":
            new = replace(new, mass=value * (body.mass if is_share else 1.0))
        elif quantity == "com":
            new = replace(new, com=np.full(3, value))
        else:
            new = replace(new, inertia=value * (np.abs(body.inertia_com) if is_share else np.eye(3)))
    if link.bare:
        new = replace(new, body_mass=body.mass, body_com=body.com)
    return replace(link, uncertainty=new)


def exactly_known(arm: RobotArm) -> str:
    """Parameters without a stated uncertainty: "mass of links 1 and 2; com of every link"; "" if none."""
    if arm.spread is not None:
        return ""
    sentences = []
    for quantity in _FACTORS:
        links = [
            k for k, link in enumerate(arm.links, 1) if getattr(link.uncertainty, quantity, None) is None
        ]
        if links:
            sentences.append(f"{quantity} of {named_joints(links, arm.n_joints).replace('joint', 'link')}")
    return "; ".join(sentences)
