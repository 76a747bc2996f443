"""The exact trigonometric-polynomial form of an arm's dynamics."""

from gd_analyze.harmonics.absolute_rates import AbsoluteRates as AbsoluteRates
from gd_analyze.harmonics.transform import Harmonics as Harmonics
from gd_analyze.harmonics.transform import harmonics_of as harmonics_of
from gd_analyze.harmonics.waves import Waves as Waves
