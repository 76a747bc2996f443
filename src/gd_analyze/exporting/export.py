"""Models and exact dynamics to take away, as the text of files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from gd_analyze.certification.certificate import Certificate
from gd_analyze.errors import UsageError
from gd_analyze.exporting.export_input import (
    ExportInput,
    subject_of_decomposition,
    subject_of_form,
    subject_of_model,
)
from gd_analyze.exporting.languages import LANGUAGES
from gd_analyze.files import replacing_together
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.text import html_of

SCALARS = ("double", "float")


@dataclass(frozen=True, eq=False)
class Exported:
    """What was printed.

    Parameters
    ----------
    subject
        What it is of.
    languages
        In which languages.
    files
        Texts by the names of their files.
    """

    subject: ExportInput
    languages: tuple[str, ...]
    files: Mapping[str, str]

    def __repr__(self) -> str:
        return f"Exported({self.subject.arm.name!r}, {', '.join(self.files)})"

    def _repr_html_(self) -> str:
        """The functions and what they take, for a notebook."""
        rows = [[each.name, each.meaning, str(each.count)] for each in self.subject.functions]
        return html_of(repr(self), ["function", "gives", "operations"], rows)

    def paths(self, folder: str | Path = ".") -> list[Path]:
        """Say which files `save` writes."""
        return [Path(folder) / name for name in self.files]

    def save(self, folder: str | Path = ".") -> list[Path]:
        """Write the files into a folder, all or none.

        Raises
        ------
        OutputError
            If they cannot be written there.
        """
        paths = self.paths(folder)
        with replacing_together(paths) as temporaries:
            for temporary, text in zip(temporaries, self.files.values(), strict=True):
                temporary.write_text(text, encoding="ascii", newline="\n")
        return paths


def export(
    given: SimplifiedModel | RobotArm | str | Path,
    languages: str | Sequence[str],
    *,
    name: str | None = None,
    scalar: str = "double",
    drives: bool | None = None,
    certificate: Certificate | None = None,
) -> Exported:
    """Print a simplified model, or an arm's exact dynamics, in other languages.

    Parameters
    ----------
    given
        The model; or an arm, or its name or file, for its exact dynamics.
    languages
        One or several of `LANGUAGES`.
    name
        Identifier with which everything begins that the text declares, and the files' names; by default made
        of the arm's name.
    scalar
        In C: double or float.
    drives
        Of an arm: whether its drives' inertia acts; by default where there is any.
    certificate
        What is proven of the model's error, from `certify`, for the text to state.

    Returns
    -------
    Exported
        The text, file by file.

    Raises
    ------
    UsageError
        If there is no such language or scalar, the name is no identifier, or the certificate does not fit.
    """
    if isinstance(given, SimplifiedModel):
        return printed(subject_of_model(given, name, certificate), languages, scalar)
    arm = arm_of(given)
    return printed(subject_of_form(ExactForm(arm, arm.counts_drives(drives)), name), languages, scalar)


def export_decomposition(
    arm: RobotArm | str | Path,
    languages: str | Sequence[str],
    *,
    name: str | None = None,
    scalar: str = "double",
) -> Exported:
    """Print D and h by effect, translation and rotation, and c, of the links alone, in other languages.

    Parameters and errors are those of `export`. [FGL87] Eqs. (3.4-25) to (3.4-28).
    """
    return printed(subject_of_decomposition(arm_of(arm), name), languages, scalar)


def printed(subject: ExportInput, languages: str | Sequence[str], scalar: str = "double") -> Exported:
    """Print a subject, see `export`."""
    chosen = (languages,) if isinstance(languages, str) else tuple(languages)
    files: dict[str, str] = {}
    for language in chosen:
        if language not in LANGUAGES:
            raise UsageError(
                f"nothing is printed in {language}",
                where="languages",
                expected=f"some of {', '.join(LANGUAGES)}",
                found=language,
            )
        if scalar not in SCALARS or (scalar == "float" and language != "c"):
            raise UsageError(
                "there is no such type of numbers",
                where="scalar",
                expected="double, or in C float",
                found=f"{scalar} in {language}",
            )
        printer = LANGUAGES[language]
        files |= zip(printer.names(subject.name), printer.texts(subject, scalar), strict=True)
    return Exported(subject, chosen, files)
