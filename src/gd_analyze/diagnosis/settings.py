"""The numbers that a diagnosis depends on."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class DiagnosisSettings:
    """Weights and thresholds of a diagnosis, chosen in trials with synthetic and real logs.

    analysis/diagnosis_trial.md states what they give.
    """

    # What a file's links are off by, one standard deviation: of mass, of each coordinate of the centre of
    # mass (a share, and metres on top), of each moment of inertia.
    mass: float = 0.15
    lever: float = 0.15
    lever_m: float = 0.008
    inertia: float = 0.20

    # Samples taken of all logs together, and in a search for a number.
    samples: int = 400
    samples_of_search: int = 100
    # Fall of the score in a search that is worth a closer look.
    worth: float = 3.0
    # Stretches of a log, fitted and scored in turn.
    stretches: int = 10
    # Least samples of a joint that moves, fitted and scored alike.
    fewest: int = 12

    # Weight of a joint's log of its mean squared residual: half its independent samples. A short log has
    # fewer, one for so many samples.
    evidence: float = 50.0
    samples_each: float = 4.0
    # Share of a joint's torque below which a residual is not worth less.
    floor: float = 0.015
    # Cost of a fitted number, and of the logarithm of the number of alternatives.
    per_number: float = 3.9
    per_alternative: float = 2.0

    # Standard deviation of the logarithms of joints' torque constants about their common mean.
    constants: float = 0.5

    # Fall of the score that makes a cause.
    margin: float = 30.0
    # Share of what then remains unexplained that it falls by beside: where a model misses much anyway, wrong
    # causes help by chance.
    misfit: float = 0.05
    # A second cause as good to within this is told, too; a known value wins over a fitted one within that.
    alike: float = 10.0
    known: float = 25.0
    # Changes of the links, squared in standard deviations, or a residual, as a share of the torque, beyond
    # which another cause is looked for. Logs with no fault stay below.
    changed: float = 40.0
    left: float = 0.15
    # Most causes of one log.
    causes: int = 2


SETTINGS = DiagnosisSettings()
