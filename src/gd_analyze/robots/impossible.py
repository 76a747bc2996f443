"""Inertias that no body has but that dynamics can be computed with: by how much, and what to look at."""

from __future__ import annotations

from gd_analyze.robots.parts import MEASUREMENT_TOLERANCE, Link, moments_told
from gd_analyze.text import percent

_REMEDY = "units (cm against m) and the point the inertia is about (com or origin)"


def impossibility(link: Link) -> str | None:
    """Say how far a link's inertia is from that of any body; None where a body has it.

    Nor is anything said of a measurement kept as published (`Link.as_measured`) that is off by no more than
    such measurements are.
    """
    moments = moments_told(link.principal_moments)
    if link.deficit:
        return (
            f"the inertia of link {link.name} is of no body: its smallest principal moment is negative, by "
            f"{percent(link.deficit)} of the largest ({moments}); check the signs of the products of "
            f"inertia, {_REMEDY}"
        )
    if not link.excess or (link.as_measured and link.excess <= MEASUREMENT_TOLERANCE):
        return None
    broken = (
        f"the inertia of link {link.name} breaks the triangle inequality by {percent(link.excess)} of its "
        f"largest principal moment ({moments})"
    )
    if link.excess <= MEASUREMENT_TOLERANCE:
        return f"{broken}; measurements are off by as much, which as_measured = true says in a TOML file"
    return f"{broken}: no body has it; check {_REMEDY}"
