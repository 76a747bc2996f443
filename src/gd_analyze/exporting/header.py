"""The header of exported files: lines of plain ASCII, the same in every language."""

from __future__ import annotations

import hashlib
import math
import textwrap
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from gd_analyze import __version__
from gd_analyze.certification.certificate import Certificate
from gd_analyze.exporting.export_input import ExportInput, up
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import fingerprint
from gd_analyze.simplification.accuracy import STATED, gamma_words
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.model_file import model_text
from gd_analyze.text import named_joints, number, percent


def header(subject: ExportInput, foreign: Callable[[str], str]) -> list[str]:
    """State content, arm, units, errors, and identifiers made from foreign names.

    `foreign` escapes a text from outside for a comment.
    """
    lines = (
        *_contents(subject, foreign),
        "",
        *_joints(subject, foreign),
        "",
        *_errors(subject, foreign),
        *_against_log(subject, foreign),
    )
    return [line.rstrip() for line in lines]


def _contents(subject: ExportInput, foreign: Callable[[str], str]) -> Iterator[str]:
    arm, model = subject.arm, subject.model
    kind = "Exact dynamics" if model is None else "Simplified torque model"
    yield f"{kind} of {foreign(arm.title or arm.name)}, by gd-analyze {__version__}."
    log = None if model is None else model.accuracy.log
    if log is not None and log.contradicted:
        joints = named_joints(log.contradicted, arm.n_joints)
        yield f"CONTRADICTED BY THE LOG at {joints}: {foreign(log.name)}."
        yield "Mend the file first:"
        command = textwrap.wrap(log.remedy or "gd-analyze diagnose ROBOT LOG", 100, break_long_words=False)
        yield from (f"  {foreign(line)}" for line in command)
    yield ""
    if model is not None:
        size_text = f"{model.size[0]} of {model.size[1]} {model.level.keeps}"
        yield f"Level {model.level.name}: {size_text}; budget {foreign(model.accuracy.budget)}."
    for function in subject.functions:
        yield f"{function.name}: {function.meaning};"
        yield f"  {function.count}."
    if model is not None:
        yield f"The exact torque takes {model.operations_full},"
        exact, apart = model.functions_full, model.functions_full.operations
        totals = " + ".join(str(program.count.total) for program in exact)
        yield f"  exact D, h and c, each a function of its own, {totals} operations,"
        yield f"  {apart.sines_cosines} sin and cos."
        if model.accuracy.gamma is not None:
            yield f"Mass matrix {gamma_words(model.accuracy.gamma)}."
            yield "  (The largest |eigenvalue of D^-1 Ds - I|, Ds this D; safe below 100 %.)"
    if subject.torque is not None:
        yield f"Inertia of the drives: {_drives(arm, subject.drives)}."
    has_friction = any(function.name == "friction" for function in subject.functions)
    friction = "a separate function" if has_friction else "not included"
    yield f"Units: rad and m, s, N m and N. Friction is {friction}."
    yield f"Arm {foreign(arm.name)}, SHA-256 of all that affects its torque:"
    yield f"  {fingerprint(arm, subject.drives)}"
    if model is not None:
        yield "SHA-256 of the model file:"
        yield f"  {hashlib.sha256(model_text(model).encode()).hexdigest()}"


def _drives(arm: RobotArm, is_included: bool) -> str:
    """Whether their inertia is part of the torque, or why not."""
    if is_included:
        return "included"
    if arm.counts_drives():
        return "left out"
    return "unknown, so not included" if arm.drives else "none in the arm's file"


def _joints(subject: ExportInput, foreign: Callable[[str], str]) -> Iterator[str]:
    yield "Joints in order, with their original names if these differ:"
    for i, (joint, word) in enumerate(zip(subject.arm.joints, subject.joints, strict=True), start=1):
        named = "" if word == joint.name else f" (named {foreign(joint.name)})"
        yield f"  {i}: {word}{named}, {joint.kind}: q in {joint.unit}, tau in {joint.effort_unit}"
    if subject.base is not None:
        yield "Base parameters in order; `gd-analyze equations ROBOT --parameters` prints what each combines:"
        for i, parameter in enumerate(subject.base, start=1):
            yield f"  {i}: {parameter.symbol}, {parameter.unit}"
    yield f"Links: {', '.join(foreign(link.name) for link in subject.arm.links)}"


def _errors(subject: ExportInput, foreign: Callable[[str], str]) -> Iterator[str]:
    if subject.model is None:
        yield "Exact: no error but rounding."
        return
    known = "sampled" if subject.model.accuracy.measured else f"{STATED},"
    yield f"Torque errors, {known} where the model was fitted:"
    fitted_on = subject.model.accuracy.fitted_on
    yield f"  {', '.join(f'{key} {foreign(str(value))}' for key, value in fitted_on.items())}"
    yield from _table(["joint", "peak torque", "allowed", "largest", "RMS"], sampled_rows(subject.model))
    stated = subject.model.accuracy.certificate
    if stated is not None:
        word = "Proven" if stated.proven_here else f"Bound {STATED} and not proven again here"
        yield f"{word}: within {foreign(stated.where.replace('°', ' deg'))}"
        if stated.trajectory_fingerprint:
            yield f"  (SHA-256 of the motion: {stated.trajectory_fingerprint})"
        yield from _table(["joint", "bound"], [[f"{up(float(bound)):.6g}"] for bound in stated.certified])
    if subject.certificate is None:
        scope = " for other states"
        if stated is not None:
            scope = " for further states" if stated.proven_here else " here"
        yield f"Nothing is proven{scope}: {subject.unproven}."
        return
    # Joint by joint: one text for many joints would be cut.
    where = ", ".join(map(foreign, subject.certificate.box.where.split(", ")))
    yield f"Proven: no state of the following box ({where}) has an error above the bound."
    headings = ["joint", "q from", "q to", "|qd| up to", "|qdd| up to", "bound"]
    yield from _table(headings, proven_rows(subject.certificate))


def _against_log(subject: ExportInput, foreign: Callable[[str], str]) -> Iterator[str]:
    """What a log says of the model: what is left of its torques, beside what the exact model leaves."""
    if subject.model is None or subject.model.accuracy.log is None:
        return
    log = subject.model.accuracy.log
    yield f"Against the log {foreign(log.name)}, {log.readings} readings,"
    yield f"  SHA-256 {log.fingerprint}:"
    if log.read_with:
        yield f"read with {foreign(log.read_with)}: q and tau are those after it."
    yield "Measured torque, filtered like the motion, less that of the model and of fitted friction, N m (N):"
    if log.growth is not None and np.isfinite(log.growth).any() and not subject.model.is_exact:
        largest = max(float(np.nanmax(log.growth)), 0.0)
        yield f"On held-out readings this is at most {percent(largest)} larger than for the exact model."
    headings = ["joint", "RMS", "95 % below", "RMS of the exact model", "Coulomb", "viscous", "offset"]
    columns = (log.rms, log.below_95, log.rms_exact, log.coulomb, log.viscous, log.offset)
    rows = [["-" if math.isnan(x) else number(x) for x in row] for row in np.transpose(columns).tolist()]
    yield from _table(headings, rows)


def sampled_rows(model: SimplifiedModel) -> list[list[str]]:
    """Peak torque, allowed, largest and RMS error, joint by joint."""
    errors, allowed = model.accuracy.errors, model.accuracy.allowed
    columns = (errors.peak_torque, allowed, errors.largest, errors.rms)
    return [[number(float(x)) for x in row] for row in zip(*columns, strict=True)]


def proven_rows(certificate: Certificate) -> list[list[str]]:
    """Box and bound, joint by joint, to six digits, with no box larger and no bound smaller than proven."""
    box = certificate.box
    columns = (box.lower, -box.upper, -box.velocity, -box.acceleration, certificate.certified)
    signs = (1.0, -1.0, -1.0, -1.0, 1.0)
    rows = zip(*columns, strict=True)
    return [[f"{sign * up(float(x)):.6g}" for sign, x in zip(signs, row, strict=True)] for row in rows]


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    lines = [list(headings), *([str(i), *row] for i, row in enumerate(rows, start=1))]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        yield "  " + "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True))
