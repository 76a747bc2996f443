"""The one verdict on logs and an arm's file, in a word and in sentences: whether they agree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gd_analyze.diagnosis.answer import MUCH_TORQUE_SHARE, answer
from gd_analyze.diagnosis.causes import is_unexplained
from gd_analyze.diagnosis.diagnose import Diagnosis, diagnosed
from gd_analyze.diagnosis.hypothesis import MOST_REMAINDER
from gd_analyze.diagnosis.of_one_log import FrictionOfLogs
from gd_analyze.errors import UsageError
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.threads import one_thread

# The verdict as the sentence that begins every answer.
SENTENCES = {
    "agrees": "The log agrees with the file.",
    "agrees in part": "The log agrees with the file in part.",
    "does not agree": "The log does not agree with the file.",
    "tells nothing": "The log does not tell whether the file is right.",
}
# Verdicts of logs that leave something to explain.
DISPUTED = ("does not agree", "agrees in part")
# Share of faulty readings of which a verdict takes note; lost messages and spikes of a sound log are fewer.
_FAULTY_SHARE = 0.02
Word = Literal["agrees", "agrees in part", "does not agree", "tells nothing"]


@dataclass(frozen=True, eq=False)
class LogVerdict:
    """Whether logs agree with an arm's file.

    Parameters
    ----------
    word
        The verdict: "agrees", "agrees in part", "does not agree" or "tells nothing".
    text
        The verdict, what is wrong and what to do, in sentences.
    diagnosis
        What it comes of; None if nothing can be compared.
    """

    word: Word
    text: str
    diagnosis: Diagnosis | None

    def __repr__(self) -> str:
        return f"LogVerdict({self.word!r})"


@one_thread()
def log_verdict(arm: RobotArm, motions: Sequence[Trajectory]) -> LogVerdict:
    """Ask for the cause of a disagreement, of one thing wrong; `diagnose` searches for two."""
    try:
        diagnosis = diagnosed(arm, motions, pairs=False)
    except UsageError as error:
        return LogVerdict("tells nothing", f"{SENTENCES['tells nothing']} Reason: {error.what}.", None)
    word = _word_of(diagnosis)
    text = f"{SENTENCES[word]} {answer(diagnosis)}"
    if word in DISPUTED:
        text += " `gd-analyze diagnose ROBOT LOG` shows where."
    return LogVerdict(word, text, diagnosis)


def _word_of(diagnosis: Diagnosis) -> Word:
    """The verdict on logs and file.

    They do not agree if there is a cause, a column is of no use, the links must be off by more than a file's
    usually are, or most of a joint's torque remains. They agree in part if some have other friction than the
    others, many readings are faulty, the links are off by much, or more remains than a file's usual error
    leaves.
    """
    fit = diagnosis.after
    is_column_useless = any(fault.is_of_column for fault in diagnosis.faults)
    is_most_left = float(np.nanmax(fit.residuals, initial=0.0)) > MOST_REMAINDER
    of_friction = [cause for cause in diagnosis.causes if cause.name == FrictionOfLogs.name]
    is_cause = len(diagnosis.causes) > len(of_friction) or bool(diagnosis.apart)
    if is_cause or is_column_useless or diagnosis.is_far_off or is_most_left:
        return "does not agree"
    if not diagnosis.tells:
        return "tells nothing"
    is_faulty = any(fault.share > _FAULTY_SHARE for fault in diagnosis.faults)
    is_in_part = bool(of_friction) or is_faulty or is_unexplained(fit) or fit.off > MUCH_TORQUE_SHARE
    return "agrees in part" if is_in_part else "agrees"
