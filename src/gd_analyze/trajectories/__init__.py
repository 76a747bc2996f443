"""Trajectories: the value, its CSV file, planning, and what a motion asks of an arm."""

from gd_analyze.trajectories.checks import check_against_arm
from gd_analyze.trajectories.csv_file import read_trajectory, shipped_trajectories
from gd_analyze.trajectories.csv_writing import recorded_command, trajectory_csv, write_trajectory
from gd_analyze.trajectories.limits import JointExtremes, LimitReport, Violation, limit_report
from gd_analyze.trajectories.measured import motion_of
from gd_analyze.trajectories.motions import Motion
from gd_analyze.trajectories.planning import Plan, Schedule, plan
from gd_analyze.trajectories.pool import (
    GivenMotion,
    GivenMotions,
    motions_of,
    pool,
    taken_apart,
    trajectory_of,
)
from gd_analyze.trajectories.profiles import PROFILES, Profile
from gd_analyze.trajectories.recording import Recording
from gd_analyze.trajectories.trajectory import Trajectory
from gd_analyze.trajectories.treatment import Treatment

__all__ = [
    "PROFILES",
    "GivenMotion",
    "GivenMotions",
    "JointExtremes",
    "LimitReport",
    "Motion",
    "Plan",
    "Profile",
    "Recording",
    "Schedule",
    "Trajectory",
    "Treatment",
    "Violation",
    "check_against_arm",
    "limit_report",
    "motion_of",
    "motions_of",
    "plan",
    "pool",
    "read_trajectory",
    "recorded_command",
    "shipped_trajectories",
    "taken_apart",
    "trajectory_csv",
    "trajectory_of",
    "write_trajectory",
]
