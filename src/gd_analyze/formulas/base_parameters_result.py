"""Base (minimal) inertial parameters as equations and as a result."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict

from gd_analyze.dynamics.base_parameters import BaseParameters
from gd_analyze.formulas.formula import Product
from gd_analyze.formulas.languages import Latex, Plain, equations
from gd_analyze.formulas.printer import number
from gd_analyze.formulas.writing import base_formula
from gd_analyze.result import Column, Fact, Result, Table


def base_equations(base: BaseParameters, form: str, digits: int) -> Iterable[str]:
    """MX2 = mx2 + 0.432 m3..6 = 3.8 kg m, a line each."""
    printer = Latex(digits) if form == "latex" else Plain(digits)
    for one in base:
        unit = rf" \; \mathrm{{{one.unit.replace(' ', '~')}}}" if form == "latex" else f" {one.unit}"
        yield f"{printer.line(base_formula(one))} = {printer.sum((Product(one.number),))}{unit}"


def base_parameters_result(base: BaseParameters, form: str, text: str, digits: int) -> Result:
    """The parameters, the combinations they are, what acts of every link, and the frames."""
    effects = ("number", "translation", "rotation", *(("drive",) if base.drives else ()))
    of_effects = {name: [number(getattr(one, name), digits) for one in base] for name in effects}
    links = range(1, base.arm.n_joints + 1)
    acting = zip(*(_acting(base, link) for link in links), strict=True)
    axes = {"origin": lambda frame: frame.translation} | {
        name: lambda frame, k=k: frame.rotation[:, k] for name, k in (("x", 0), ("z", 2))
    }
    of_axes = {
        name: [" ".join(number(x, digits) for x in of(frame)) for frame in base.frames]
        for name, of in axes.items()
    }
    parameters = [asdict(one) | {"combination": [s._asdict() for s in one.combination]} for one in base]
    return Result(
        title=f"{base.arm.title or base.arm.name}: base (minimal) inertial parameters",
        subtitle="Translation: masses at their centres. Rotation: inertias about these. Pxx, Pxy, ... are "
        "second moments, Ixx = Pyy + Pzz, Ixy = -Pxy; m3..6 = m3 + m4 + m5 + m6.",
        facts=(
            Fact("arm", "", base.arm.name),
            Fact("drives", "Drives included", base.drives),
            Fact("", "Base parameters", len(base), shown="count", note=f"of {len(base.original)} parameters"),
            Fact("", "Base parameters that are zero", sum(one.number == 0.0 for one in base), shown="count"),
            Fact("parameters", "", parameters),
            Fact("acting_alone", "", [{"kind": kind, "link": link} for kind, link in base.acting_alone]),
            Fact("never_acting", "", [{"kind": kind, "link": link} for kind, link in base.never_acting]),
            Fact("frames", "", [asdict(frame) for frame in base.frames]),
            Fact("format", "", form),
            Fact("written", "", text),
        ),
        parts=(
            _texts(
                "Base parameters",
                symbol=[one.symbol for one in base],
                **of_effects,
                unit=[one.unit for one in base],
            ),
            equations("", "Combinations", map(base_formula, base), digits=digits),
            _texts(
                "Parameters of the links that act",
                link=[*map(str, links)],
                **dict(zip(("alone", "combined", "never"), acting, strict=True)),
            ),
            _texts(
                "Frames of the parameters: origin (m) and axes in the link's own frame",
                link=[*map(str, links)],
                **of_axes,
            ),
        ),
    )


def _texts(title: str, **columns: Sequence[str]) -> Table:
    return Table("", title, tuple(Column("", name, cells, shown="text") for name, cells in columns.items()))


def _acting(base: BaseParameters, link: int) -> tuple[str, str, str]:
    """Parameters of a link that act alone, in combination only, and never."""
    of_link = [kind for kind, one in base.original if one == link]
    alone = [kind for kind in of_link if (kind, link) in base.acting_alone]
    never = [kind for kind in of_link if (kind, link) in base.never_acting]
    combined = [kind for kind in of_link if kind not in (*alone, *never)]
    return _named(alone, of_link), _named(combined, of_link), _named(never, of_link)


def _named(kinds: Sequence[str], of_link: Sequence[str]) -> str:
    """Some of a link's parameters, or the fewer others."""
    others = [kind for kind in of_link if kind not in kinds]
    if len(others) < len(kinds) - 1:
        return f"all but {' '.join(others)}" if others else "all"
    return " ".join(kinds)
