"""What stands on top of everything that is taken away: lines of plain ASCII, the same in every language."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence

from gd_analyze.certification.certificate import Certificate
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.exporting.foreign import comment
from gd_analyze.exporting.stated import up
from gd_analyze.robots.description import fingerprint
from gd_analyze.simplification.model_file import model_text
from gd_analyze.text import number
from gd_analyze.version import __version__


def told(subject: ExportInput, more: Sequence[str] = ()) -> list[str]:
    """Say what it is, of which arm, in which units, how exact, and what foreign names became."""
    return [line.rstrip() for line in (*_what(subject), "", *_joints(subject), "", *_errors(subject), *more)]


def _what(subject: ExportInput) -> Iterator[str]:
    arm, model = subject.arm, subject.model
    kind = "Exact dynamics" if model is None else "Simplified torque model"
    yield f"{kind} of {comment(arm.title or arm.name)}, by gd-analyze {__version__}."
    yield ""
    if model is not None:
        kept = model.level.told(model.terms)
        yield f"Level {model.level.name}: {kept}; budget {comment(model.accuracy.budget)}."
    for function in subject.functions:
        yield f"{function.name}: {function.meaning};"
        yield f"  {function.count}."
    if model is not None:
        yield f"The exact torque takes {model.operations_full}."
    if subject.torque is not None:
        yield f"Inertia of the drives: {'included' if subject.drives else 'left out'}."
    yield "Units: rad and m, s, N m and N. Friction is no part of it."
    yield f"Arm {comment(arm.name)}, SHA-256 of what acts on its torque:"
    yield f"  {fingerprint(arm, subject.drives)}"
    if model is not None:
        yield "SHA-256 of the model's file:"
        yield f"  {hashlib.sha256(model_text(model).encode()).hexdigest()}"


def _joints(subject: ExportInput) -> Iterator[str]:
    yield "Joints in their order, and what their names became:"
    for i, (joint, word) in enumerate(zip(subject.arm.joints, subject.joints, strict=True), start=1):
        kind = "turns" if joint.kind == "revolute" else "slides"
        unit, effort = ("rad", "N m") if joint.kind == "revolute" else ("m", "N")
        named = "" if word == joint.name else f" (named {comment(joint.name)})"
        yield f"  {i}: {word}{named} {kind}: q in {unit}, tau in {effort}"
    links = [link.name for link in subject.arm.links]
    yield f"Links: {', '.join(map(comment, links))}"


def _errors(subject: ExportInput) -> Iterator[str]:
    if subject.model is None:
        yield "Exact: no error but rounding."
        return
    accuracy, certificate = subject.model.accuracy, subject.certificate
    fitted_on = ", ".join(f"{key} {comment(str(value))}" for key, value in accuracy.fitted_on.items())
    yield "Errors of the torque, sampled where the model was made:"
    yield f"  {fitted_on}"
    columns = [accuracy.errors.peak_torque, accuracy.allowed, accuracy.errors.largest, accuracy.errors.rms]
    yield from _table(
        ["joint", "peak torque", "allowed", "largest", "RMS"],
        [[number(float(x)) for x in row] for row in zip(*columns, strict=True)],
    )
    if certificate is None:
        yield "Nothing is proven of states in between: no certificate was asked for."
        return
    where = comment(certificate.box.where)
    yield f"Proven: no state of the following box ({where}) has an error above the bound."
    yield from _table(
        ["joint", "q from", "q to", "|qd| up to", "|qdd| up to", "bound"],
        [[f"{x:.6g}" for x in row] for row in proven_rows(certificate)],
    )


def proven_rows(certificate: Certificate) -> list[list[float]]:
    """Box and bound, joint by joint, to six digits: no box larger than proven, no bound smaller."""
    box = certificate.box
    columns = (box.lower, -box.upper, -box.velocity, -box.acceleration, certificate.certified)
    rows = [[up(float(x)) for x in row] for row in zip(*columns, strict=True)]
    return [[lower, *(-x for x in most), bound] for lower, *most, bound in rows]


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    lines = [list(headings), *([str(i), *row] for i, row in enumerate(rows, start=1))]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        yield "  " + "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True))
