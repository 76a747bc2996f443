"""Mechanics: kinematics, formulations, the decomposition by effect, simulation, measured torques."""
