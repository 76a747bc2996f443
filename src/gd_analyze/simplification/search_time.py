"""The processor time that searches may take."""

from __future__ import annotations

import math
import time

from gd_analyze.errors import UsageError, require_type

SEARCH_SECONDS = 30.0  # processor time of all searches of a job
# Share of a search's time after which it closes.
_CLOSING_SHARE = 0.6


class SearchTime:
    """Processor time, s, that searches may take together from now on."""

    def __init__(self, seconds: float = math.inf) -> None:
        require_type(seconds, (float, int), "seconds", "processor time, s")
        if not seconds > 0.0:
            raise UsageError("no time to search", where="seconds", expected="above 0", found=f"{seconds:g}")
        self.seconds = seconds
        self._start = time.process_time()

    @property
    def share_spent(self) -> float:
        """Time spent over that allowed."""
        return (time.process_time() - self._start) / self.seconds

    @property
    def is_closing(self) -> bool:
        """Whether what remains is for ending with a model that holds: no attempts, and smaller budgets."""
        return self.share_spent > _CLOSING_SHARE

    @property
    def is_over(self) -> bool:
        """Whether nothing is left."""
        return self.share_spent >= 1.0


UNLIMITED = SearchTime()
