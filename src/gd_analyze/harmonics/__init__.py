"""The exact trigonometric-polynomial form of an arm's dynamics."""

from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.transform import Harmonics, harmonics_of
from gd_analyze.harmonics.waves import Waves

__all__ = ["AbsoluteRates", "Harmonics", "Waves", "harmonics_of"]
