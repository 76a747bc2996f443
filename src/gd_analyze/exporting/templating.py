"""Templates of source text: nothing is escaped there, so what they are given is safe already."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from gd_analyze.exporting.inputs import inputs, joint_of, kind_of, unused

if TYPE_CHECKING:
    from jinja2 import Environment


@cache
def _environment() -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("gd_analyze.exporting"),
        undefined=StrictUndefined,
        autoescape=False,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.globals |= {"inputs": inputs, "unused": unused, "kind_of": kind_of, "joint_of": joint_of}
    return environment


def filled(template: str, **values: Any) -> str:
    """Fill a template in."""
    return _environment().get_template(template).render(**values)
