"""Robot arms: the value, the ways to build one, and the built-in ones."""

from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import read_arm
from gd_analyze.robots.arm_toml import toml_of
from gd_analyze.robots.box_limits import BoxLimits, box_limits
from gd_analyze.robots.catalogue import arm_of, builtin_arms, load_arm
from gd_analyze.robots.description import (
    arm_from_description,
    describe,
    describe_in_full,
    describe_with_drives,
    fingerprint,
)
from gd_analyze.robots.link_uncertainty import LinkUncertainty
from gd_analyze.robots.parts import DHRow, Drive, Joint, Link, Placement
from gd_analyze.robots.payload import Payload, parse_payload, with_payload
from gd_analyze.robots.slips import slips_of, warn_of_slips

__all__ = [
    "BoxLimits",
    "DHRow",
    "Drive",
    "Joint",
    "Link",
    "LinkUncertainty",
    "Payload",
    "Placement",
    "RobotArm",
    "arm_from_description",
    "arm_of",
    "box_limits",
    "builtin_arms",
    "describe",
    "describe_in_full",
    "describe_with_drives",
    "fingerprint",
    "load_arm",
    "parse_payload",
    "read_arm",
    "slips_of",
    "toml_of",
    "warn_of_slips",
    "with_payload",
]
