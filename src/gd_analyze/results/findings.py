"""All results of one run of the main job, and their origin; every report is a view of them."""

from __future__ import annotations

import datetime
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version as installed_version
from typing import Any

from gd_analyze import __version__
from gd_analyze.figures.axes import Plots
from gd_analyze.figures.run import Run
from gd_analyze.files import mark_of
from gd_analyze.harmonics.terms import Torques
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.torque_program import READABLE


@dataclass(frozen=True, eq=False, kw_only=True)
class Findings(Run):
    """Results of the main job for one arm along one trajectory.

    Parameters
    ----------
    arm, trajectory
        The inputs.
    tables
        All results as labelled Datasets, by the groups of `gd_analyze.schema.GROUPS`.
    model
        The simplified model.
    element_model
        The model by [FGL87]'s own method, keeping or dropping effects of elements; the same as
        `model` if that has this level.
    ranked_terms
        The exact torque terms and their weights, in the order of the table "terms"; empty for an arm whose
        equations are too long to write out.
    warnings
        Warnings about the input.
    provenance
        Versions, time, command.
    """

    model: SimplifiedModel
    element_model: SimplifiedModel
    ranked_terms: Torques
    warnings: tuple[str, ...]
    provenance: Mapping[str, str]

    def __repr__(self) -> str:
        budget = self.model.accuracy.budget
        return f"Findings({self.arm.name!r} along {self.trajectory.name!r}, budget {budget})"

    def __str__(self) -> str:
        """What a terminal shows."""
        from gd_analyze.report.notebook import printed_findings  # of a floor above

        return printed_findings(self)

    def _repr_html_(self) -> str:
        """The same, with the matrix of elements, for a notebook."""
        from gd_analyze.report.notebook import notebook_view

        return notebook_view(self)

    @property
    def is_unreadable(self) -> bool:
        """Whether the exact torque stands for a model, as none that keeps the budget has few enough terms."""
        stops = self.tables.get("stops")
        return stops is not None and self.tables["budgets"].attrs["asked"] not in stops.position

    @property
    def is_contradicted(self) -> bool:
        """Whether no model was searched, as the log contradicts the file."""
        stops = self.tables.get("stops")
        return stops is not None and bool((stops.unsearched == "log").any())

    @property
    def substitute_reason(self) -> str:
        """Why the exact torque stands for a model, and what to do, in a sentence."""
        budget = self.model.accuracy.budget
        if self.is_contradicted:
            return (
                "No simplified model, as the log contradicts the file "
                f"(`--budget {budget}` searches one all the same)."
            )
        own, asked = self.tables["stops"].isel(stop=0), self.model.accuracy.asked
        if "log" in asked.wholes:
            count = f"{own.terms_beyond:d}" if own.terms_beyond > READABLE else "too many"
            return f"Within what this log can tell, {count} terms matter: take the exact torque."
        if own.unsearched == "terms" and own.terms_beyond <= READABLE:
            return f"Too many terms matter within {budget} to search a model."
        return f"No model with at most {READABLE} terms was found within {budget}."

    def with_next(self, command: str) -> Findings:
        """The same, with the command to type next; it is what mends a file that the log contradicts."""
        if not command:
            return self
        model, log = self.model, self.model.accuracy.log
        if log is not None and log.contradicted:
            model = model.stating(replace(model.accuracy, log=replace(log, remedy=command)))
        return replace(self, model=model, provenance={**self.provenance, "next": command})

    @property
    def plot(self) -> Plots:
        """The report's figures as lists of matplotlib axes: `plot.torque()`, `plot.errors()`, and more."""
        return Plots(self)


def provenance(command: str) -> dict[str, str]:
    """Flat description of a result's origin, stored with it and shown in every report."""
    return {
        "gd_analyze": __version__,
        "created": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "command": command,
        "python": platform.python_version(),
        "numpy": installed_version("numpy"),
        "pinocchio": installed_version("pin"),
    }


def provenance_of_run(
    command: str, settings: Sequence[Any], everything: Any, *, repeats: bool
) -> dict[str, str]:
    """`provenance`, with the mark of the run as "run".

    The mark of a run that `repeats` does not depend on time and command.
    """
    source = provenance(command)
    passing = ("created", "command") if repeats else ()
    lasting = {key: value for key, value in source.items() if key not in passing}
    return source | {"run": mark_of(settings, [everything, lasting])}
