"""The one verdict on logs and an arm's file, in a word and in sentences: whether they agree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from gd_analyze.diagnosis.answer import (
    TELLS_NOTHING,
    Word,
    answer,
    contradicted_joints,
    is_for_identification,
    opening,
    word_of,
)
from gd_analyze.diagnosis.diagnose import Diagnosis, diagnosed
from gd_analyze.diagnosis.log_resolution import LogResolution
from gd_analyze.errors import LeadingWarning, UsageError, warn_caller
from gd_analyze.motions.pool import taken_apart
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.threads import one_thread

# Verdicts of logs that leave something to explain.
DISPUTED = ("does not agree", "agrees in part")


@dataclass(frozen=True, eq=False)
class LogVerdict:
    """Whether logs agree with an arm's file.

    Parameters
    ----------
    word
        The verdict: "agrees", "agrees in part", "does not agree" or "tells nothing".
    opening
        The verdict in a sentence: what of the robot the file describes.
    text
        The same, what is wrong and what to do.
    diagnosis
        What it comes of; None if nothing can be compared.
    """

    word: Word
    opening: str
    text: str
    diagnosis: Diagnosis | None

    def __repr__(self) -> str:
        return f"LogVerdict({self.word!r})"

    @cached_property
    def contradicted(self) -> tuple[int, ...]:
        """Joints, from 1, of which the log says that the file is wrong."""
        return () if self.diagnosis is None else contradicted_joints(self.diagnosis)

    @cached_property
    def resolution(self) -> LogResolution | None:
        """What the logs can tell of errors in torque; None where they tell nothing, or of a wrong file."""
        if self.diagnosis is None or self.word not in ("agrees", "agrees in part"):
            return None
        is_mended = not self.diagnosis.causes and not self.contradicted
        return LogResolution.of(self.diagnosis) if is_mended else None


@one_thread()
def log_verdict(arm: RobotArm, motions: Sequence[Trajectory]) -> LogVerdict:
    """Ask for the cause of a disagreement, of one thing wrong; `diagnose` searches for two."""
    try:
        diagnosis = diagnosed(arm, motions, pairs=False)
    except UsageError as error:
        text = f"{TELLS_NOTHING}: {error.what}."
        return LogVerdict("tells nothing", text, text, None)
    word, text = word_of(diagnosis), answer(diagnosis)
    if is_for_identification(diagnosis):
        text += " `gd-analyze identify` fits the links to the log."
    if word in DISPUTED:
        text += " `gd-analyze diagnose ROBOT LOG` shows where."
    return LogVerdict(word, opening(diagnosis), text, diagnosis)


def verdict_with_warning(arm: RobotArm, motion: Trajectory) -> LogVerdict:
    """Ask for the verdict on a motion's torques, and warn unless file and log agree."""
    verdict = log_verdict(arm, taken_apart(motion))
    if verdict.word != "agrees":
        warn_caller(LeadingWarning(f"log {motion.name}: {verdict.text}"))
    return verdict
