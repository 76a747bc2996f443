"""The main job: find everything about an arm along a trajectory, and write it down."""

from gd_analyze.main_job.analyze import analyze
from gd_analyze.main_job.find import find
from gd_analyze.main_job.how import Origin, Progress, Settings

__all__ = ["Origin", "Progress", "Settings", "analyze", "find"]
