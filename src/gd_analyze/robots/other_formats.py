"""Formats of robots that are not read here, and what makes a URDF, MJCF or TOML of them."""

from __future__ import annotations

_AS_TOML = "write its table and masses as TOML, as `gd-analyze arms puma560 --to toml` prints them, with"
_OF_CAD = (
    "a drawing or a mesh",
    "export URDF with masses from the CAD program: onshape-to-robot, SolidWorks URDF Exporter, fusion2urdf",
)
_OF_USD = (
    "OpenUSD",
    "`pip install nvidia-srl-usd-to-urdf`, then `usd_to_urdf -o robot.urdf robot.usd`; Isaac Sim's URDF "
    "exporter does it, too",
)
_OF_TOOLBOX = (
    "a model of the Robotics Toolbox",
    f'{_AS_TOML} convention = "standard" or "modified"; com is its r, inertia its I, drives its G^2 Jm',
)
_OF_COPPELIA = ("a CoppeliaSim model", "CoppeliaSim's URDF exporter writes it as URDF")
_BY_SUFFIX = {
    ".proto": (
        "a Webots PROTO",
        "name the URDF that urdf2webots made it from, if any; else a controller in Webots writes one by "
        "`Robot.getUrdf()`: see with `gd-analyze arms` whether it has the masses",
    ),
    ".par": (
        "a SYMORO parameter file",
        f'{_AS_TOML} convention = "modified": a is its d, d its r, com (MX, MY, MZ) / M; XX, XY, ... with '
        'inertia_about = "origin", IA as inertia of drives',
    ),
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), _OF_USD),
    **dict.fromkeys((".rtb", ".m"), _OF_TOOLBOX),
    **dict.fromkeys((".ttm", ".ttt"), _OF_COPPELIA),
    **dict.fromkeys((".step", ".stp", ".stl", ".obj", ".dae", ".sldasm", ".f3d"), _OF_CAD),
    ".srdf": ("MoveIt's groups of joints", "name the URDF that it belongs to"),
    ".py": (
        "a Python script",
        "in Python every function takes an arm: gd.save_arm(arm, 'robot.toml') writes it",
    ),
}


def other_format(suffix: str) -> tuple[str, str] | None:
    """What a file of this suffix is, and what makes one of it that is read; None where nothing is known."""
    return _BY_SUFFIX.get(suffix)
