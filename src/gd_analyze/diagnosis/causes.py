"""Which hypotheses there are, how their causes are ranked, and which of these are claimed.

A cause is claimed by one rule: with it the score falls clearly, and so does what remains of the torques,
which are then explained for the most part. Of a pair, each cause passes this beside the other.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gd_analyze.diagnosis.fit import MOST_CHANGES, FileFit
from gd_analyze.diagnosis.hypothesis import (
    CLEAR_REMAINDER_RATIO,
    KNOWN_ADVANTAGE,
    MOST_REMAINDER,
    Candidate,
    Hypothesis,
    Problem,
)
from gd_analyze.diagnosis.of_one_log import FrictionOfLogs, LoadOfLogs, ScaleOfLogs
from gd_analyze.diagnosis.of_positions import (
    Coupling,
    Direction,
    JointOrder,
    PositionUnit,
    TimeUnit,
    WristCoupling,
    Zero,
    ZeroOfSlide,
    doubtful_positions,
)
from gd_analyze.diagnosis.of_the_arm import (
    AnotherArm,
    ChangeInTime,
    Gravity,
    GravityAlone,
    NamedEnd,
    Payload,
)
from gd_analyze.diagnosis.of_torques import (
    Drift,
    JointScale,
    Lag,
    MotorSide,
    TorqueColumns,
    TorqueScale,
    TorqueSign,
)

# Every kind of cause; a new one is one more entry. Of causes that no log tells apart, the first here is the
# first that is told.
HYPOTHESES: tuple[Hypothesis, ...] = (
    PositionUnit(),
    MotorSide(),
    TorqueSign(),
    TorqueScale(),
    JointScale(),
    TorqueColumns(),
    Lag(),
    Direction(),
    Zero(),
    ZeroOfSlide(),
    JointOrder(),
    Coupling(),
    WristCoupling(),
    GravityAlone(),
    TimeUnit(),
    Gravity(),
    Payload(),
    NamedEnd(),
    Drift(),
    ChangeInTime(),
    ScaleOfLogs(),
    LoadOfLogs(),
    FrictionOfLogs(),
    AnotherArm(),
)

# Kinds of cause that concern the unit of positions.
_OF_UNITS = (PositionUnit.name, MotorSide.name)

# Thresholds were chosen in trials with synthetic and real logs; see analysis/diagnosis_trial.md.
# Fall of the score that makes a cause, and share of what then remains unexplained that it falls by beside:
# where a model misses much anyway, wrong causes help by chance.
CLEAR_FALL, CLEAR_FALL_SHARE = 30.0, 0.05
# A second cause as good to within this is told, too.
_ALIKE_FALL = 10.0
# Causes of scores and residuals as near as this are one and the same. The score is minus twice the logarithm
# of a likelihood: no log decides a difference of 2, and searches end nearer than that.
_EQUAL_SCORE, _EQUAL_REMAINDER = 2.0, 0.05
# Most other causes that are told beside one.
_MOST_RIVALS = 2
# Residual, as a share of the torque, beyond which another cause is looked for.
MOST_RESIDUAL_SHARE = 0.15
# Causes by score, and by remainder, that pairs begin with.
_FIRST_CAUSES = 2


def ranked(problem: Problem) -> list[Candidate]:
    """All causes: first the one to be claimed, if there is any, then the others by the fall of the score."""
    candidates = [candidate for hypothesis in HYPOTHESES for candidate in hypothesis.judged(problem)]
    claimable = [candidate for candidate in candidates if is_claimable(candidate, problem)]
    candidates.sort(key=lambda candidate: -candidate.fall)
    if claimable:
        best = _best_of(claimable)
        candidates.remove(best)
        candidates.insert(0, best)
    return candidates


def _best_of(claimable: Sequence[Candidate]) -> Candidate:
    """The best cause: of those about as good, one that is evident, else one of fewest numbers.

    Of those equal, it is the first of `HYPOTHESES`: their order is that of `claimable`.
    """
    fall = max(cause.fall for cause in claimable)
    alike = [cause for cause in claimable if cause.fall > fall - KNOWN_ADVANTAGE]
    alike = [cause for cause in alike if cause.evident] or alike
    fewest = min(cause.numbers for cause in alike)
    simplest = [cause for cause in alike if cause.numbers == fewest]
    score = min(cause.score for cause in simplest)
    return next(cause for cause in simplest if cause.score <= score + _EQUAL_SCORE)


def is_claimable(cause: Candidate, problem: Problem) -> bool:
    """Whether score and remainder fall by enough to claim a cause, beside those that are corrected."""
    before, after = problem.null, cause.fit
    assert after is not None  # judged
    # Where positions are doubtful their unit comes first, unless a cause shows that they are right.
    if cause.name not in _OF_UNITS and is_unexplained(after) and doubtful_positions(problem):
        return False
    # A joint that is compared no longer rests then.
    if np.isnan(after.residuals[problem.moving]).any():
        return False
    # Under an absurd cause the links' torques vanish, and friction remains.
    if cause.score > problem.friction_score - CLEAR_FALL:
        return False
    is_clear = cause.fall > CLEAR_FALL + CLEAR_FALL_SHARE * after.unexplained
    return is_clear and after.remains <= min(CLEAR_REMAINDER_RATIO * before.remains, MOST_REMAINDER)


def is_unexplained(fit: FileFit) -> bool:
    """Whether more is to be explained than a file is usually off by."""
    largest_residual = float(np.nanmax(fit.residuals, initial=0.0))
    return fit.changed > MOST_CHANGES or largest_residual > MOST_RESIDUAL_SHARE


def claimed(problem: Problem, ranking: Sequence[Candidate], *, pairs: bool = True) -> list[Candidate]:
    """The cause, or the pair of causes, of a ranking that is claimed; none if none is."""
    single = [cause for cause in ranking[:1] if is_claimable(cause, problem)]
    if single and single[0].fit is not None and not is_unexplained(single[0].fit):
        return single
    return (pairs and _pair(problem, ranking, single)) or single


def _pair(problem: Problem, ranking: Sequence[Candidate], single: Sequence[Candidate]) -> list[Candidate]:
    """The best pair that begins with one of the best few, if it explains clearly more than one cause."""
    # Links as free as another arm's explain some of whatever is wrong.
    hopeful = [cause for cause in ranking if cause.fall > CLEAR_FALL and _is_of_file(cause)]
    firsts = dict.fromkeys((*hopeful[:_FIRST_CAUSES], *sorted(hopeful, key=_remains)[:_FIRST_CAUSES]))
    best: list[Candidate] = []
    for first in firsts:
        corrected = Problem(problem.samples, first.correction)
        seconds = [
            cause for cause in ranked(corrected) if is_claimable(cause, corrected) and _is_of_file(cause)
        ]
        for second in seconds[:1]:
            pair = [first, second]
            alone = [*single, *(cause for cause in ranking if cause.name == second.name)]
            if not _fit_together(first, second) or not _better(pair, alone, problem):
                continue
            if not best or _fall(pair) > _fall(best) + _EQUAL_SCORE:
                best = pair
    return best


def _better(pair: Sequence[Candidate], alone: Sequence[Candidate], problem: Problem) -> bool:
    """Whether a pair explains clearly more than nothing does, and than either of its causes alone."""
    remains = _remains(pair[1])
    most = min([problem.null.remains, *(_remains(cause) for cause in alone)])
    fall = max([0.0, *(cause.fall for cause in alone)])
    return remains <= CLEAR_REMAINDER_RATIO * most and _fall(pair) > fall + CLEAR_FALL


def _fall(causes: Sequence[Candidate]) -> float:
    return sum(cause.fall for cause in causes)


def _is_of_file(cause: Candidate) -> bool:
    return cause.correction.freedom == 1.0


def _remains(cause: Candidate) -> float:
    assert cause.fit is not None  # judged
    return cause.fit.remains


def _fit_together(first: Candidate, second: Candidate) -> bool:
    """Whether the remedies of two causes, typed together, do what the two corrections do in this order."""
    both = first.remedy.then(second.remedy)
    # What the first fits to states is not that of states which the second changes.
    changes_states = (
        not np.array_equal(second.correction.position, first.correction.position)
        or not np.array_equal(second.correction.offset, first.correction.offset)
        or second.correction.pace != first.correction.pace
    )
    is_typed = bool(both.options) and both.is_typed and not {*first.remedy.arm} & {*second.remedy.arm}
    return is_typed and not (changes_states and first.correction.added)


def rivals_of(cause: Candidate, ranking: Sequence[Candidate], problem: Problem) -> tuple[Candidate, ...]:
    """Causes that the log does not tell from the one claimed, in a fixed order, and others nearly as good."""
    names = [hypothesis.name for hypothesis in HYPOTHESES]
    others = [other for other in ranking if other is not cause and is_claimable(other, problem)]
    same = [other for other in others if is_same(other, cause)]
    same.sort(key=lambda other: names.index(other.name))
    nearly = [
        other
        for other in others
        if other not in same and other.name != cause.name and other.fall > cause.fall - _ALIKE_FALL
    ]
    by_name = {other.name: other for other in reversed([*same, *nearly])}
    return tuple(reversed(by_name.values()))[:_MOST_RIVALS]


def is_same(cause: Candidate, other: Candidate) -> bool:
    """Whether two causes have one consequence: the same score and the same remainder of every joint."""
    assert cause.fit is not None  # judged
    assert other.fit is not None  # judged
    return abs(cause.score - other.score) <= _EQUAL_SCORE and np.allclose(
        cause.fit.residuals, other.fit.residuals, rtol=_EQUAL_REMAINDER, equal_nan=True
    )
