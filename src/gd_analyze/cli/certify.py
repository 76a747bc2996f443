"""`gd-analyze certify`: a bound on a model's torque error that no state of the arm's limits exceeds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from gd_analyze.cli.options import reporting
from gd_analyze.errors import UsageError

if TYPE_CHECKING:
    from gd_analyze.models import HarmonicModel
    from gd_analyze.simplification import Certificate


@click.command(short_help="Bound a model's torque error over all states of the arm's limits.")
@click.argument("model", type=click.Path(path_type=Path), help="A model.json that `simplify` wrote.")
@click.option(
    "--seconds",
    type=click.FloatRange(min=0.0),
    default=1.0,
    show_default=True,
    help="Time per joint that the bound may take to tighten; it is proven after any time.",
)
@reporting
def certify(model: Path, seconds: float, as_json: bool, quiet: bool, debug: bool) -> None:
    r"""Bound the torque error of a simplified model over a whole box of states.

    The box is the arm's ranges, rate limits and acceleration limits. No state in it has a larger error than
    the certified one; the largest error that a search found stands beside it, and the truth lies between.

    \b
    Example:
      gd-analyze certify model.json --seconds 2
    """
    from gd_analyze.cli.terminal import print_json, stages, warnings_told

    with warnings_told(quiet), stages(quiet) as stage:
        stage("reading")
        from gd_analyze.models import HarmonicModel, load_model
        from gd_analyze.simplification import certify as run

        loaded = load_model(model)
        if not isinstance(loaded, HarmonicModel):
            raise UsageError(
                "an element-level model has no harmonic terms to bound",
                where=str(model),
                expected="a model of level term or energy",
                found=f"level {loaded.level}",
                next_step="make one with `gd-analyze simplify`",
            )
        stage("certifying")
        certificate = run(loaded, seconds=seconds)
    if as_json:
        print_json(_document(loaded, certificate))
    elif not quiet:
        _show(loaded, certificate)


def _document(model: HarmonicModel, certificate: Certificate) -> dict[str, object]:
    return {
        "arm": model.arm.name,
        "level": model.level,
        "box": {
            "lower": certificate.box.lower.tolist(),
            "upper": certificate.box.upper.tolist(),
            "rate": certificate.box.rate.tolist(),
            "acceleration": certificate.box.acceleration.tolist(),
        },
        "joints": [
            {
                "joint": i + 1,
                "name": joint.name,
                "unit": joint.effort_unit,
                "sampled": float(model.promise.largest[i]),
                "worst_found": float(certificate.worst_found[i]),
                "certified": float(certificate.certified[i]),
                "ratio": float(certificate.ratio[i]),
            }
            for i, joint in enumerate(model.arm.joints)
        ],
    }


def _show(model: HarmonicModel, certificate: Certificate) -> None:
    from gd_analyze.cli.terminal import line, sentence, table
    from gd_analyze.report.context import number, percent

    arm, peak = model.arm, model.promise.peak_torque
    shares = [float(c / p) if p > 0.0 else 0.0 for c, p in zip(certificate.certified, peak, strict=True)]
    worst = max(range(len(shares)), key=shares.__getitem__)
    sentence(
        f"No state within the limits of {arm.title or arm.name} has a torque error above "
        f"{percent(shares[worst])} of peak torque (joint {worst + 1}).",
        bold=True,
    )
    units = {joint.effort_unit for joint in arm.joints}
    rows = [
        [
            f"{i + 1} {joint.name}" if joint.name != str(i + 1) else joint.name,
            number(float(model.promise.largest[i])),
            number(float(certificate.worst_found[i])),
            number(float(certificate.certified[i])),
            percent(shares[i]),
            f"{float(certificate.ratio[i]):.2f}",
            *([joint.effort_unit] if len(units) > 1 else []),
        ]
        for i, joint in enumerate(arm.joints)
    ]
    headings = [("joint", "left"), ("sampled", "right"), ("worst found", "right"), ("certified", "right")]
    headings += [("of peak", "right"), ("ratio", "right")] + ([("unit", "left")] if len(units) > 1 else [])
    table(f"Torque error, {' or '.join(sorted(units, reverse=True))}", headings, rows)
    line()
    sentence(
        "Sampled: over the states the model was made for. Worst found: by a search over the whole box. "
        "Certified: no state of the box exceeds it. Ratio: certified over worst found; more --seconds "
        "bring it closer to 1."
    )
