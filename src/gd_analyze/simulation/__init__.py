"""From torque to motion: energy, joint accelerations, and motions integrated over time."""

from gd_analyze.simulation.accelerations import joint_accelerations
from gd_analyze.simulation.drivetrain import Drivetrain
from gd_analyze.simulation.energy import kinetic_energy, potential_energy
from gd_analyze.simulation.integration import Integration
from gd_analyze.simulation.simulate import Simulation, simulate

__all__ = [
    "Drivetrain",
    "Integration",
    "Simulation",
    "joint_accelerations",
    "kinetic_energy",
    "potential_energy",
    "simulate",
]
