"""Bounds on a model's torque error that no state of a box, or of a tube around a motion, exceeds."""
