"""`gd-analyze report`: the reports of a stored analysis, made again."""

from __future__ import annotations

from pathlib import Path

import click

import gd_analyze as gd
from gd_analyze.cli.options import FILE, formats_option, out_option, overwrite_option, top_option
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.outputs import require_outputs

# What can be made from the file; the file itself is there.
FORMATS = ("json", "csv", "html", "pdf")


@click.command(short_help="Make the reports of a stored analysis again.")
@click.argument("analysis", type=FILE, help="The analysis.h5 of a folder that the main job wrote.")
@out_option("Folder for the reports.  [default: the file's own]")
@overwrite_option
@formats_option(FORMATS)
@top_option
@reporting
def report(
    analysis: Path, out: Path | None, overwrite: bool, formats: tuple[str, ...], top: int, output: Output
) -> None:
    r"""Write what the main job wrote beside its analysis.h5 once more, without computing anything anew.

    What is beside the file is replaced; another folder must not hold another run. What is printed is what the
    main job printed.

    \b
    Examples:
      gd-analyze report reports/puma560-pick-and-place/analysis.h5
      gd-analyze report analysis.h5 --format html --out elsewhere
    """
    from gd_analyze.cli.findings import print_findings

    with output.working() as stage:
        stage("reading")
        from gd_analyze.studies.main_job_files import FILES, require_folder, write_findings

        folder = analysis.parent if out is None else out
        findings = gd.load_findings(analysis)
        require_outputs(*(folder / FILES[name] for name in formats))
        strangers: tuple[Path, ...] = ()
        if (folder / FILES["h5"]).resolve() != analysis.resolve():
            mark = findings.provenance.get("run", "")
            strangers = require_folder(folder, formats, mark, overwrite=overwrite)
        stage(f"writing {', '.join(formats)}")
        write_findings(findings, folder, formats, strangers)
    print_findings(findings, folder, formats, output, top)
