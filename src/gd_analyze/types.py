"""Types of the values that public functions take and give: arms, states, regions, settings and results."""

from __future__ import annotations

from gd_analyze.certification.box import Box
from gd_analyze.certification.tube import Tube
from gd_analyze.diagnosis.diagnose import Diagnosis
from gd_analyze.diagnosis.log_verdict import LogVerdict
from gd_analyze.dynamics.arm_dynamics import ArmDynamics
from gd_analyze.dynamics.base_parameters import BaseParameter, BaseParameters
from gd_analyze.dynamics.drivetrain import Drivetrain
from gd_analyze.dynamics.measured_torque import TorqueComparison
from gd_analyze.dynamics.simulation import Integration, Simulation
from gd_analyze.exporting.export import Exported
from gd_analyze.identification.excitation import Workspace
from gd_analyze.identification.identification import Identification
from gd_analyze.motions.log import Log
from gd_analyze.motions.margin import Margin
from gd_analyze.motions.reading import Reading, Treatment
from gd_analyze.motions.smoothing import Recording
from gd_analyze.motions.states import States
from gd_analyze.progress import Progress
from gd_analyze.results.findings import Findings
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import DHRow, Drive, Joint, Link, Placement
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.studies.evaluation import Evaluation
from gd_analyze.studies.settings import Settings

__all__ = [
    "LEVELS",
    "ArmDynamics",
    "BaseParameter",
    "BaseParameters",
    "Box",
    "Budget",
    "DHRow",
    "Diagnosis",
    "Drive",
    "Drivetrain",
    "Evaluation",
    "ExactDynamics",
    "ExactForm",
    "Exported",
    "Findings",
    "Identification",
    "Integration",
    "Joint",
    "Link",
    "Log",
    "LogVerdict",
    "Margin",
    "Placement",
    "Progress",
    "Reading",
    "Recording",
    "RobotArm",
    "Settings",
    "SimplifiedModel",
    "Simulation",
    "States",
    "TorqueComparison",
    "Treatment",
    "Tube",
    "Workspace",
]
