"""Bounds on a model's torque error that no state of a box, or of a tube around a motion, exceeds."""

from gd_analyze.certification.box import Box as Box
from gd_analyze.certification.certificate import Certificate as Certificate
from gd_analyze.certification.certificate import certify as certify
from gd_analyze.certification.certified_model import simplify_certified as simplify_certified
from gd_analyze.certification.largest_torque import largest_torque as largest_torque
from gd_analyze.certification.margin import Margin as Margin
from gd_analyze.certification.positive_definite import Definiteness as Definiteness
from gd_analyze.certification.positive_definite import certify_positive_definite as certify_positive_definite
from gd_analyze.certification.tube import Tube as Tube
