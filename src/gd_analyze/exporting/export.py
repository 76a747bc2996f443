"""Models and exact dynamics as source files in other languages."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import NoneType
from typing import Any

from gd_analyze.arguments import several, strict, words_of
from gd_analyze.certification.certificate import Certificate
from gd_analyze.errors import UsageError, require_type
from gd_analyze.exporting.c import C, Cpp
from gd_analyze.exporting.export_input import FURTHER, ExportInput
from gd_analyze.exporting.language import Casadi, Jax, Language, Matlab, Python, Sympy
from gd_analyze.exporting.latex import Latex
from gd_analyze.exporting.names import LANGUAGES, SPELLINGS
from gd_analyze.exporting.vectors import tests_of
from gd_analyze.files import path_of, write_together
from gd_analyze.result import Fact, Result, Shown, Value, attributes_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_with_masses
from gd_analyze.schema import declared_table
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.text import html_of, in_python

CLASSES: dict[str, type[Language]] = dict(
    zip(LANGUAGES, (C, Casadi, Cpp, Jax, Latex, Matlab, Python, Sympy), strict=True)
)


@dataclass(frozen=True, eq=False)
class Exported:
    """Exported texts by file name, and their input."""

    subject: ExportInput
    files: Mapping[str, str]

    def __repr__(self) -> str:
        return f"Exported({self.subject.arm.name!r}, {', '.join(self.files)})"

    def _repr_html_(self) -> str:
        """The functions and their operations, for a notebook."""
        rows = [[function.name, function.meaning, str(function.count)] for function in self.subject.functions]
        return html_of(repr(self), ["function", "gives", "operations"], rows)

    def result(self) -> Result:
        """The functions written and their operations."""
        subject, joints = self.subject, self.subject.arm.joints
        content = "exact dynamics" if subject.model is None else f"model of level {subject.model.level}"
        names = zip((joint.name for joint in joints), subject.joints, strict=True)
        renamed = [f"{name} is {word}" for name, word in names if name != word]
        values = attributes_of(
            [function.count for function in subject.functions],
            "multiplications",
            "additions",
            "sines_cosines",
        )
        values = {"function": [function.name for function in subject.functions], **values}
        facts = (
            Value("arm", subject.arm.name),
            Value("of", content),
            Fact("name", "Prefix of all names", subject.name),
            *((Shown("Renamed joints", ", ".join(renamed)),) if renamed else ()),
            Value("stated", {key: constant.values for key, constant in subject.constants.items()}),
            Shown("Constants", ", ".join(subject.constants) or "none"),
        )
        identifiers = zip(joints, subject.joints, strict=True)
        parts = (
            declared_table("functions", "functions", "Functions", values, [*values]),
            Value("joints", [{"name": joint.name, "identifier": word} for joint, word in identifiers]),
        )
        return Result(subject.arm.title or subject.arm.name, content, facts=facts, parts=parts)

    def function(self, name: str = "torque") -> Callable[..., Any]:
        """Load the exported text and return one of its functions, to be called at once.

        Of JAX, CasADi, Python and SymPy, the language that was exported first is taken: a function of
        `jax.numpy` arrays, a `casadi.Function`, a function of NumPy arrays, or a function of SymPy's symbols
        or numbers.

        Parameters
        ----------
        name
            Name of the function: torque, inertia, coriolis_centrifugal, gravity_loading, or another one.

        Returns
        -------
        callable
            The function, of joint positions, velocities and accelerations, shape (..., n), of SymPy's (n,),
            in rad (m) and s; torque in N m (N).

        Raises
        ------
        UsageError
            If nothing was exported to these languages, one is not installed, or there is no such function.

        Examples
        --------
        >>> import gd_analyze as gd
        >>> gravity = gd.export("two_link", "python").function("gravity_loading")
        >>> gravity([0.0, 0.0]).round(2)
        array([24.52,  4.9 ])
        """
        names = [function.name for function in self.subject.functions]
        if name not in names:
            raise UsageError(
                "there is no such function", where="name", expected=", ".join(names), found=in_python(name)
            )
        text = next((text for file, text in self.files.items() if file in self._modules), None)
        if text is None:
            expected, found = "an export to jax, casadi, python or sympy", ", ".join(self.files)
            raise UsageError("nothing exported can be called", expected=expected, found=found)
        module: dict[str, Any] = {"__name__": self.subject.name}
        try:
            exec(compile(text, f"<{self.subject.name}>", "exec"), module)  # our own text, names escaped
        except ModuleNotFoundError as error:
            step = f"pip install {error.name}"
            raise UsageError(f"this needs {error.name}, which is not installed", next_step=step) from None
        return module[name]

    @property
    def _modules(self) -> set[str]:
        """Names that files with Python modules of functions have."""
        return {
            f"{self.subject.name}{suffix}" for kind in (Jax, Casadi, Python, Sympy) for suffix in kind.files
        }

    def paths(self, folder: str | Path = ".") -> list[Path]:
        """Files that `save` writes."""
        return [Path(folder) / name for name in self.files]

    def save(self, folder: str | Path = ".") -> list[Path]:
        """Write the files into a folder, all or none.

        Raises
        ------
        OutputError
            If they cannot be written.
        """
        paths = self.paths(path_of(folder))
        contents = [text.encode("ascii") for text in self.files.values()]
        write_together(dict(zip(paths, contents, strict=True)))
        return paths


@strict
def export(
    source: SimplifiedModel | RobotArm | str | Path,
    languages: str | Sequence[str],
    folder: str | Path | None = None,
    *,
    name: str | None = None,
    scalar: str = "double",
    drives: bool | None = None,
    certificate: Certificate | None = None,
    what: str | Sequence[str] = (),
    tests: bool = False,
) -> Exported:
    """Write a simplified model, or an arm's exact dynamics, in other languages.

    Parameters
    ----------
    source
        The model; or an arm, its name or its file, for its exact dynamics.
    languages
        One or several of "c", "casadi", "cpp" (or "c++"), "jax", "latex", "matlab", "python" and "sympy".
    folder
        Folder to write the files to; without it nothing is written.
    name
        Prefix of all declared names and of the files' names; by default from the arm's name.
    scalar
        In C: double or float.
    drives
        For an arm: include its drives' inertia; by default if it describes drives.
    certificate
        Proven bound on the model's error, from `certify`, to be stated in the text.
    what
        Functions beside the torque, D, h and c: "derivatives" of the torque, the "coriolis_matrix", "forward"
        dynamics, the torque of a "payload", "friction", the torque's "regressor" to the base
        parameters, and the torque with these "parameters" as an argument; of a model, with its terms alone.
    tests
        Also write programs that compare the exported code with values computed here: in C and C++ with
        CMakeLists.txt, in Python for pytest, in MATLAB.

    Returns
    -------
    Exported
        Texts by file name.

    Raises
    ------
    UsageError
        If a language, scalar or function is unknown, or name or certificate do not fit.
    OutputError
        If the files cannot be written.
    """
    functions = words_of(what, ("torque", *FURTHER), "what")
    require_type(certificate, (Certificate, NoneType), "certificate", "a Certificate of `certify`, or None")
    if isinstance(source, SimplifiedModel):
        export_input = ExportInput.of_model(source, name, certificate)
    else:
        arm = arm_with_masses(source)
        export_input = ExportInput.of_exact(ExactForm(arm, arm.counts_drives(drives)), name)
    exported = written(export_input.with_functions(functions), languages, scalar, tests=tests)
    if folder is not None:
        exported.save(folder)
    return exported


def export_decomposition(
    arm: RobotArm | str | Path,
    languages: str | Sequence[str],
    *,
    name: str | None = None,
    scalar: str = "double",
) -> Exported:
    """Write D and h by effect (translation and rotation), and c, of the links alone, in other languages.

    Parameters, result and errors are as for `export`. [FGL87] Eqs. (3.4-25) to (3.4-28).
    """
    return written(ExportInput.of_decomposition(arm_with_masses(arm), name), languages, scalar)


def written(
    subject: ExportInput, languages: str | Sequence[str], scalar: str = "double", *, tests: bool = False
) -> Exported:
    """Write the functions in languages, see `export`."""
    chosen = languages_named(languages, scalar)
    files = {
        f"{subject.name}{suffix}": text
        for language in chosen.values()
        for suffix, text in language.texts(subject).items()
    }
    return Exported(subject, files | (tests_of(subject, chosen) if tests else {}))


def languages_named(languages: str | Sequence[str], scalar: str = "double") -> dict[str, Language]:
    """Languages by their names, all with the same type of numbers; a UsageError for those without it."""
    require_type(languages, (str, list, tuple), "languages", f"one or several of {', '.join(LANGUAGES)}")
    chosen: dict[str, Language] = {}
    for word in several(languages):
        name = SPELLINGS.get(word, word)
        if name not in LANGUAGES:
            expected = f"some of {', '.join(LANGUAGES)}"
            raise UsageError("no such language", where="languages", expected=expected, found=str(word))
        language = CLASSES[name]
        if scalar not in language.scalars:
            message, expected = f"no such type of numbers in {name}", " or ".join(language.scalars)
            raise UsageError(message, where="scalar", expected=expected, found=str(scalar))
        chosen[name] = language(scalar)
    return chosen
