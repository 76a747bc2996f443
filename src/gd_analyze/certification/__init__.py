"""Proven bounds on a model's torque error in a box of states, or in a tube around a motion."""
