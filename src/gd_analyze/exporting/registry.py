"""The languages: one per file of `exporting/languages`, loaded when it is asked for."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING

from gd_analyze.exporting import languages

if TYPE_CHECKING:
    from gd_analyze.exporting.language import Language

LANGUAGES: tuple[str, ...] = tuple(sorted(module.name for module in iter_modules(languages.__path__)))


def language_class(name: str) -> type[Language]:
    """Load a language of `LANGUAGES`."""
    found: type[Language] = import_module(f"{languages.__name__}.{name}").LANGUAGE
    return found
