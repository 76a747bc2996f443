"""`gd-analyze batch`: the main job for every row of a table."""

from __future__ import annotations

from pathlib import Path

import click

import gd_analyze as gd
from gd_analyze.cli import options
from gd_analyze.cli.options import FILE, NameList, OutputPath
from gd_analyze.cli.output import Output, reporting, require_outputs
from gd_analyze.files import RESULT_FILES


@click.command(short_help="Run the main job for every row of a table.")
@click.argument(
    "table",
    type=FILE,
    help="CSV with a column per option; YAML or TOML with a value or a list per option, for all "
    "combinations, and `rows`; or a folder with a folder of logs per robot. A number of the arm, such as "
    "link3.mass or joint2.a_mm, is an option, too.",
)
@click.option("-o", "--out", type=OutputPath(), default="batch", help="Folder for table, record and files.")
@click.option(
    "--format",
    "formats",
    type=NameList(("none", *RESULT_FILES), "format"),
    default="json",
    metavar="LIST",
    help="Files to write for every row; json is the model.",
)
@click.option(
    "--to",
    type=NameList(("csv", "parquet", "svg", "pdf", "png"), "file"),
    default="csv",
    metavar="LIST",
    help="Table to write: csv, parquet (needs pyarrow); figure: svg, pdf, png.",
)
@options.number("--jobs", 1, "Number of processes on this machine.", 1)
@click.option(
    "--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers compute the rows: tcp://host:8786."
)
@reporting
def batch(
    table: Path,
    out: Path,
    formats: tuple[str, ...],
    to: tuple[str, ...],
    jobs: int,
    scheduler: str | None,
    output: Output,
) -> None:
    r"""Run the main job for every row of a table of arms, motions, options and numbers of the arm.

    After an interruption the same command continues, and repeats failed rows. The table states why a row
    failed, and the exit code is 1.

    \b
    Examples:
      gd-analyze batch rows.csv --jobs 2
      gd-analyze batch study.yaml --out study --format none --to csv,svg
      gd-analyze batch logs/ --scheduler tcp://10.0.0.1:8786
    """
    with output.working() as progress:
        from gd_analyze.studies.batch import RECORD
        from gd_analyze.studies.batch_table import batch_result

        files = [out / f"batch.{kind}" for kind in to]
        require_outputs(*files, out / RECORD)
        chosen = [name for name in formats if name != "none"]
        rows = gd.batch(
            table,
            out,
            formats=chosen,
            to=to,
            jobs=jobs,
            scheduler=scheduler,
            progress=progress,
        )
    output.give(batch_result(rows), *files)
    if (rows.state == "failed").any():
        click.get_current_context().exit(1)
