"""What a run found: labelled tables, what is said of them, and their file."""

from gd_analyze.results.findings import Findings
from gd_analyze.results.frames import frame_of, rows_of
from gd_analyze.results.store import load_findings, load_results, save_results

__all__ = ["Findings", "frame_of", "load_findings", "load_results", "rows_of", "save_results"]
