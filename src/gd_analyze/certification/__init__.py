"""Bounds on a model's torque error that no state of a box exceeds."""

from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import Certificate, certify
from gd_analyze.certification.certified_model import simplify_certified
from gd_analyze.certification.positive_definite import Definiteness, certify_positive_definite

__all__ = ["Box", "Certificate", "Definiteness", "certify", "certify_positive_definite", "simplify_certified"]
