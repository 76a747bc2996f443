"""The rate of samples that a log states beside its rows: in comments, in names of columns or of its file."""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.reading import rate_in
from gd_analyze.motions.table import LogTable
from gd_analyze.text import shortened

# "fs=100", "sampling_rate_hz: 500", "Frequency [Hz] = 62.5", "rate: 5 Hz"; or "250 Hz" alone.
_NAME = r"(?<![a-z])(?:[a-z]*[ _-]?(?:rate|freq|frequency)|f_?s)(?:[ _]?[\[(]?hz[\])]?)?"
_NUMBER, _UNIT = r"([0-9]+(?:\.[0-9]+)?)", r"(k?hz)"
_RATE = re.compile(
    rf"(?i){_NAME}\s*[:=]\s*{_NUMBER}\s*{_UNIT}?(?![0-9.a-z])|(?<![0-9.,]){_NUMBER}[ _]?{_UNIT}(?![a-z])"
)
# Slower frequencies without a name may be the motion's, as in sine_2Hz.csv.
_FASTEST_MOTION_HERTZ = 10.0
_LONGEST_QUOTED = 60
# A text with one of these words may state another frequency.
_OF_OTHERS = re.compile(r"(?i)cut|filter|pass|(?<![a-z])lp|bandwidth|baud|noise")


def stated_rate(table: LogTable) -> tuple[str, str]:
    """The rate as `map` takes it, and words that quote what says so; RATEHz and "" unless one is stated."""
    texts = [Path(table.path).stem, *table.names, *table.about]
    rates: dict[float, str] = {}
    for text in texts:
        for match in () if _OF_OTHERS.search(text) else _RATE.finditer(text):
            with suppress(TrajectoryError):  # no motion is sampled so
                rate = rate_in(f"{match[1] or match[3]}{match[2] or match[4] or 'Hz'}")
                if rate is not None and (match[1] or rate > _FASTEST_MOTION_HERTZ):
                    rates.setdefault(rate, text)
    if len(rates) != 1:
        return "RATEHz", ""
    ((rate, text),) = rates.items()
    return f"{rate:.9g}Hz", f', as "{shortened(text.strip(), _LONGEST_QUOTED)}" says'
