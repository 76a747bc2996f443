"""C++: a header of templates on the scalar, so that types that differentiate themselves work; Eigen, too."""

from __future__ import annotations

from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.exporting.statements import Notation, body
from gd_analyze.exporting.templating import filled
from gd_analyze.exporting.told import told


def cpp_texts(subject: ExportInput, scalar: str) -> tuple[str, ...]:
    """Print a header."""
    notation = Notation(number=lambda value: f"T({value!r})")
    text = filled(
        "model.hpp.jinja",
        subject=subject,
        name=subject.name,
        lines=told(subject),
        functions=[(each, body(each, notation)) for each in subject.functions],
        listed=lambda values: ", ".join(map(repr, values)),
    )
    return (text,)
