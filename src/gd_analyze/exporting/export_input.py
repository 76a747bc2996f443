"""What is taken away: functions of an arm, and what is to be said of them in every language."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gd_analyze.certification.certificate import Certificate
from gd_analyze.errors import UsageError
from gd_analyze.exporting.functions import Function, decomposition_function, torque_functions
from gd_analyze.exporting.identifiers import LONGEST, identifier, identifiers
from gd_analyze.exporting.stated import Stated, stated
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.model import SimplifiedModel


@dataclass(frozen=True, eq=False)
class ExportInput:
    """What is taken away.

    Parameters
    ----------
    name
        Identifier that all others begin with, and the files.
    arm, drives
        The arm, and whether its drives' inertia acts.
    functions
        Torque, D, h and c, or the decomposition.
    model
        The simplified model; None of exact dynamics.
    certificate
        What is proven of its error, if anything.
    """

    name: str
    arm: RobotArm
    drives: bool
    functions: tuple[Function, ...]
    model: SimplifiedModel | None = None
    certificate: Certificate | None = None

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.arm.n_joints

    @property
    def joints(self) -> tuple[str, ...]:
        """Identifiers of the joints, in their order."""
        return identifiers([joint.name for joint in self.arm.joints])

    @property
    def torque(self) -> Function | None:
        """The function of the torque, if it is among them."""
        return next((each for each in self.functions if each.name == "torque"), None)

    @property
    def constants(self) -> Mapping[str, Stated]:
        """What a controller can hold a state against, by name."""
        return stated(self.model, self.certificate)


def subject_of_model(
    model: SimplifiedModel, name: str | None = None, certificate: Certificate | None = None
) -> ExportInput:
    """Take a simplified model away.

    Raises
    ------
    UsageError
        If the certificate is of another number of joints, or of a tube: no box is proven then.
    """
    if certificate is not None and (
        len(certificate.certified) != model.arm.n_joints or certificate.along is not None
    ):
        raise UsageError(
            "the certificate does not fit the model",
            where="certificate",
            expected=f"bounds of {model.arm.n_joints} joints over a box",
            found=f"bounds of {len(certificate.certified)} joints over {certificate.where}",
            next_step="make one with gd.certify(model)",
        )
    functions = torque_functions(model.program, model.arm.n_joints, model.level.is_mechanical)
    return ExportInput(_named(name, model.arm), model.arm, model.drives, functions, model, certificate)


def subject_of_form(form: ExactForm, name: str | None = None) -> ExportInput:
    """Take exact dynamics away."""
    functions = torque_functions(form.program, form.arm.n_joints, symmetric=True)
    return ExportInput(_named(name, form.arm), form.arm, form.drives, functions)


def subject_of_decomposition(arm: RobotArm, name: str | None = None) -> ExportInput:
    """Take D and h by effect, and c, away: of the links alone."""
    behind = "_decomposition"
    word = f"{identifier(arm.name)[: LONGEST - len(behind)].rstrip('_')}{behind}"
    return ExportInput(
        _named(word if name is None else name, arm), arm, False, (decomposition_function(arm),)
    )


def _named(name: str | None, arm: RobotArm) -> str:
    if name is not None and identifier(name) != name:
        raise UsageError(
            "the name is no identifier in every language",
            where="name",
            expected=f"at most {LONGEST} ASCII letters, digits and single underscores, a letter first, and "
            "no word that a language or its library keeps for itself",
            found=name,
            next_step=f"{identifier(name)} would do",
        )
    return name or identifier(arm.name)
