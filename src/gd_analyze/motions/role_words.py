"""Words by which logs tell what a column holds, and what it does not."""

from __future__ import annotations

import re
from typing import Literal

Said = Literal["time", "sec", "nanosec", "index", "q", "qd", "qdd", "torque", "name", "other"]
Kind = Literal["measured", "plain", "target"]

ROLE_WORDS: dict[str, Said] = {
    **dict.fromkeys(("q", "pos", "position", "positions", "angle", "angles"), "q"),
    **dict.fromkeys(("theta", "th", "phi"), "q"),
    **dict.fromkeys(("qd", "dq", "qdot", "vel", "vels", "velocity", "velocities", "speed", "speeds"), "qd"),
    **dict.fromkeys(("rate", "rates", "omega", "dtheta", "thetadot", "thetad"), "qd"),
    **dict.fromkeys(("qdd", "ddq", "qddot", "acc", "accel", "acceleration", "accelerations"), "qdd"),
    **dict.fromkeys(("ddtheta", "thetaddot", "thetadd"), "qdd"),
    **dict.fromkeys(("tau", "torque", "torques", "trq", "effort", "efforts", "moment", "moments"), "torque"),
}
# A log with q has theta of something else, as libfranka's that of the motors.
SECOND_CHOICE = frozenset({"theta", "th", "phi", "dtheta", "thetadot", "thetad", "omega"})
MEASURED = frozenset(
    {"actual", "act", "measured", "meas", "msr", "feedback", "fbk", "fb", "real", "current", "present"}
)
TARGET = frozenset(
    {
        "target",
        "tgt",
        "command",
        "commanded",
        "cmd",
        "cmptd",
        "desired",
        "des",
        "reference",
        "ref",
        "setpoint",
    }
    | {"setpoints", "planned", "plan", "goal", "nominal", "demand", "demanded", "interpolated"}
)
# What is near a joint in a log and no quantity of its motion.
BLOCKED = frozenset(
    {"temp", "temps", "temperature", "temperatures", "cur", "currents", "amps", "voltage", "voltages", "pose"}
    | {"tcp", "cartesian", "ext", "external", "contact", "collision", "tool", "scaling", "fraction", "mode"}
    | {"error", "errors", "err", "deviation", "force", "forces", "wrench", "imu", "status", "power", "jerk"}
    | {
        "covariance",
        "variance",
        "std",
        "limit",
        "limits",
        "max",
        "min",
        "offset",
        "dtau",
        "stiffness",
        "window",
    }
    | {"model", "modelled", "predicted", "ff", "feedforward", "coriolis", "inertia", "residual", "bias"}
    | {"delta", "init", "initial"}
    | {"damping", "gravity", "friction", "quaternion", "orientation", "tf", "success", "digital", "analog"}
)
CONTAINERS = frozenset(
    {
        "states",
        "state",
        "msg",
        "message",
        "field",
        "data",
        "points",
        "point",
        "header",
        "robot",
        "values",
        "value",
    }
    | {"interface", "rtde", "log", "record", "joint", "joints", "dynamic", "multi", "dof"}
)
TIME_CORE = frozenset(
    {"time", "timestamp", "timestamps", "stamp", "t", "ts", "clock", "elapsed", "epoch", "duration", "millis"}
)
TIME_MORE = frozenset(
    {"from", "start", "since", "rel", "relative", "abs", "absolute", "unix", "system", "ros", "robot", "recv"}
    | {
        "recording",
        "log",
        "header",
        "field",
        "of",
        "sample",
        "utc",
        "controller",
        "receive",
        "received",
        "in",
    }
)
INDEX = frozenset({"index", "idx", "sample", "samples", "tick", "ticks", "cycle", "counter", "seq", "n"})
COMPOSED = re.compile(
    r"(q|dq|qd|ddq|qdd|tau|pos|vel|acc|torque|position|velocity)"
    r"(act|actual|meas|des|desired|ref|cmd|target|tgt)"
)
DERIVED = {
    **{("q", "dot"): "qd", ("qd", "dot"): "qdd", ("q", "ddot"): "qdd", ("d", "q"): "dq", ("dd", "q"): "ddq"},
    **{("theta", "dot"): "thetadot", ("thetadot", "dot"): "thetaddot"},
}
# Columns of the trajectories that gd-analyze writes itself.
SET_POINT_COLUMN = re.compile(r"(qdd|qd|q)([1-9][0-9]{0,5})(_deg)?")
# A1 to A6 of a KUKA count as joints; its E1 and S, L, U of others do not tell which they are.
SINGLE = frozenset({"a"})
