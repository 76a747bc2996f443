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
    # A joint that travels less than both, an angle (or this share of the reach) and this share of the widest
    # travel of its kind, rests: controllers hold a joint within a degree while others move.
    trembling_angle: float = 0.02
    trembling_share: float = 0.02
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
    # What remains with a cause, over what remains without: of 251 true causes two leave more, and a residual
    # of a hundred independent samples is known to a twelfth.
    clear_remainder_ratio: float = 0.8
    most_remainder: float = 0.5  # share of the torque that a cause leaves at most: half of it is explained
    known_advantage: float = 25.0  # a known value wins over a fitted one within this
    alike_fall: float = 10.0  # a second cause as good to within this is told, too
    # Causes of scores and residuals as near as this are one and the same. The score is minus twice the
    # logarithm of a likelihood: no log decides a difference of 2, and searches end nearer than that.
    equal_score: float = 2.0
    equal_remainder: float = 0.05
    most_rivals: int = 2  # most other causes that are told beside one
    # Changes of the links, squared in standard deviations, beyond which another cause is looked for; logs
    # with no fault stay below.
    most_changes: float = 40.0
    most_residual_share: float = 0.15  # the same for a residual, as a share of the torque
    first_causes: int = 2  # causes by score, and by remainder, that pairs begin with


DIAGNOSIS_SETTINGS = DiagnosisSettings()
