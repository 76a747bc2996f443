"""Models and exact dynamics as source text in other languages."""

from gd_analyze.exporting.export import SCALARS, Exported, export, export_decomposition, printed
from gd_analyze.exporting.languages import LANGUAGES
from gd_analyze.exporting.subject import Subject

__all__ = ["LANGUAGES", "SCALARS", "Exported", "Subject", "export", "export_decomposition", "printed"]
