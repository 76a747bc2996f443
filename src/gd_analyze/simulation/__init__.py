"""From torque to motion: energy, joint accelerations, and motions integrated over time."""

from gd_analyze.simulation.energy import kinetic_energy, potential_energy
from gd_analyze.simulation.forward import joint_accelerations
from gd_analyze.simulation.resistance import Resistance
from gd_analyze.simulation.simulate import Simulation, simulate

__all__ = [
    "Resistance",
    "Simulation",
    "joint_accelerations",
    "kinetic_energy",
    "potential_energy",
    "simulate",
]
