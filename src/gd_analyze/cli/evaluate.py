"""`gd-analyze evaluate`: a simplified model elsewhere than it was fitted on."""

from __future__ import annotations

from pathlib import Path

import click

import gd_analyze as gd
from gd_analyze.cli.log_options import log_options, read_motion
from gd_analyze.cli.options import (
    DRAWN,
    model_argument,
    out_option,
    payload_option,
    states_options,
    trajectory_argument,
)
from gd_analyze.cli.output import Output, reporting, require_outputs


@click.command(short_help="Evaluate a simplified model on another motion.")
@model_argument()
@trajectory_argument(DRAWN)
@log_options
@payload_option
@states_options
@out_option("CSV file for exact and simplified torque over time.")
@reporting
def evaluate(
    model: Path,
    trajectory: str | None,
    payload: str | None,
    states: int,
    seed: int,
    out: Path | None,
    output: Output,
) -> None:
    r"""Evaluate a simplified model at states other than those it was fitted on, and report its torque error.

    The error that a model states is for the states it was fitted on; at others it may be larger. This command
    is for one motion or for drawn states, and for torques over time; `gd-analyze validate` gives a verdict on
    files. With --payload the exact torque is that of the arm with its load; the model is unchanged.

    \b
    Examples:
      gd-analyze evaluate reports/puma560-pick-and-place/model.json large-slew
      gd-analyze evaluate model.json
      gd-analyze evaluate model.json large-slew --payload 1.5,0,0,0.1
    """
    if out is not None and trajectory is None:
        raise click.UsageError("-o writes torque over time, and needs a trajectory")
    require_outputs(out)
    with output.working() as stage:
        stage("reading")
        from gd_analyze.files import write_text
        from gd_analyze.robots.payload import parse_payload
        from gd_analyze.simplification.evaluation import torque_csv
        from gd_analyze.studies.trial import trial_of, trial_result

        body = None if payload is None else parse_payload(payload)
        loaded = gd.load_model(model)
        motion = None if trajectory is None else read_motion(trajectory, loaded.arm)
        given = gd.states_in_box(loaded.arm, states, seed) if motion is None else motion
        stage("evaluating")
        trial = trial_of(loaded, given, body)
        if out is not None and motion is not None:
            stage(f"writing {out.name}")
            write_text(out, torque_csv(motion, trial.evaluation))
    output.give(trial_result(trial), out)
