"""The languages: one per file of `exporting/languages`, loaded when it is asked for."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gd_analyze.exporting.language import Language

_PACKAGE = Path(__file__).with_name("languages")
LANGUAGES: tuple[str, ...] = tuple(sorted(module.name for module in iter_modules([str(_PACKAGE)])))


def language_class(name: str) -> type[Language]:
    """Load a language of `LANGUAGES`."""
    found: type[Language] = import_module(f"gd_analyze.exporting.languages.{name}").LANGUAGE
    return found
