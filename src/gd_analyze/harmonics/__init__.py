"""The exact trigonometric-polynomial form of an arm's dynamics."""

from gd_analyze.harmonics.basis import Basis, Mode, Run
from gd_analyze.harmonics.identification import Harmonics, identify
from gd_analyze.harmonics.series import Series

__all__ = ["Basis", "Harmonics", "Mode", "Run", "Series", "identify"]
