"""How far long work is: its stages, the steps of each, and the main job's first answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr


class Progress:
    """What long work tells while it goes on, to whoever is given as its `progress`.

    This class ignores it. A subclass shows it, by methods in place of some of these.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> class Printed(gd.types.Progress):
    ...     def stage(self, label, total=None):
    ...         print(label)
    >>> motion = gd.read_trajectory("two-link-swing", "two_link", progress=Printed())
    reading
    """

    def stage(self, label: str, total: int | None = None) -> None:
        """Begin a stage of `total` steps, or of an unknown number; it ends when the next one begins."""

    def advance(self, steps: int = 1) -> None:
        """Note that so many steps of the stage are done since the last call."""

    def counted(self, count: str) -> None:
        """Note in words how far the stage is: "12 of 40 rows"."""

    def ranked(self, ranking: xr.Dataset, budget: str) -> None:
        """Take the main job's first answer, the result of `rank` at a budget, while models are searched."""


NO_PROGRESS = Progress()
