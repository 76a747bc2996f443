"""The numbers that a diagnosis depends on."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class DiagnosisSettings:
    """Weights and thresholds of a diagnosis, chosen in trials with synthetic and real logs.

    analysis/diagnosis_trial.md states what they give.
    """

    # What a file's links are off by, one standard deviation.
    mass_error: float = 0.15  # share of a link's mass
    com_error: float = 0.15  # share of each coordinate of the centre of mass
    com_error_m: float = 0.008  # metres on top of that
    inertia_error: float = 0.20  # share of each moment of inertia

    samples_of_logs: int = 400  # samples taken of all logs together
    samples_of_search: int = 100  # samples in a search for a number
    worthwhile_fall: float = 3.0  # fall of the score in such a search that is worth a closer look
    stretches: int = 10  # stretches of a log, fitted and scored in turn
    fewest_samples: int = 12  # least samples of a joint that moves, fitted and scored alike

    # Weight of a joint's log of its mean squared residual: half its independent samples, this at most.
    most_weight: float = 50.0
    samples_per_weight: float = 4.0  # samples of a short log for each unit of weight
    least_residual_share: float = 0.015  # share of a joint's torque below which a residual is worth no more
    cost_per_number: float = 3.9  # cost of a fitted number
    cost_per_alternative: float = 2.0  # cost of the logarithm of the number of alternatives
    # Standard deviation of the logarithms of joints' torque constants about their common mean.
    constants_deviation: float = 0.5

    clear_fall: float = 30.0  # fall of the score that makes a cause
    # Share of what then remains unexplained that it falls by beside: where a model misses much anyway, wrong
    # causes help by chance.
    clear_fall_share: float = 0.05
    alike_fall: float = 10.0  # a second cause as good to within this is told, too
    known_advantage: float = 25.0  # a known value wins over a fitted one within this
    # Changes of the links, squared in standard deviations, beyond which another cause is looked for; logs
    # with no fault stay below.
    most_changes: float = 40.0
    most_residual_share: float = 0.15  # the same for a residual, as a share of the torque
    most_causes: int = 2  # most causes of one log


DIAGNOSIS_SETTINGS = DiagnosisSettings()
