"""What an arm's TOML file holds of joints and links that stand anywhere, as in URDF."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from gd_analyze.errors import ArmError
from gd_analyze.robots.arm_schema import ArmTables, JointTable, LinkTable, Number
from gd_analyze.robots.frames import roll_pitch_yaw
from gd_analyze.robots.parts import ORTHONORMAL_TOLERANCE, Placement


def _is_rotation(rows: list[list[float]]) -> list[list[float]]:
    try:
        Placement(np.array(rows))
    except ArmError:
        raise ValueError(
            "three rows of a rotation: each of length 1, square to the others, right-handed"
        ) from None
    return rows


def _is_direction(axis: list[float]) -> list[float]:
    length = float(np.linalg.norm(axis))
    if abs(length - 1) > ORTHONORMAL_TOLERANCE:
        raise ValueError(f"a unit vector, of length 1 instead of {length:g}")
    return axis


_Vector = Annotated[list[Number], Field(min_length=3, max_length=3)]
_Rotation = Annotated[list[_Vector], Field(min_length=3, max_length=3), AfterValidator(_is_rotation)]
_Direction = Annotated[_Vector, AfterValidator(_is_direction)]


def _placement(xyz: list[float], rpy: list[float] | None, rotation: list[list[float]] | None) -> Placement:
    turned = roll_pitch_yaw(*rpy) if rpy is not None else np.eye(3)
    return Placement(turned if rotation is None else np.array(rotation), np.array(xyz))


class PlacedJointTable(JointTable):
    """A joint by its frame in the frame of the link before it, and its axis in its own."""

    xyz: _Vector = Field(default=[0.0, 0.0, 0.0])
    rpy: _Vector | None = None
    rotation: _Rotation | None = None
    axis: _Direction = Field(default=[0.0, 0.0, 1.0])

    @classmethod
    def _unit_suffixes(cls, data: dict[str, Any]) -> dict[str, str]:
        return super()._unit_suffixes(data) | {"xyz": "_mm", "rpy": "_deg"}

    @model_validator(mode="after")
    def _one_rotation(self) -> PlacedJointTable:
        if self.rpy is not None and self.rotation is not None:
            raise ValueError("either rpy or rotation, which say the same")
        return self

    @property
    def placement(self) -> Placement:
        """The joint frame in the frame of the link before."""
        return _placement(self.xyz, self.rpy, self.rotation)


class PlacedLinkTable(LinkTable):
    """A link, and where its frame is in the joint's, which moves with it."""

    frame_xyz: _Vector = Field(default=[0.0, 0.0, 0.0])
    frame_rpy: _Vector | None = None
    frame_rotation: _Rotation | None = None

    @classmethod
    def _unit_suffixes(cls, data: dict[str, Any]) -> dict[str, str]:
        return super()._unit_suffixes(data) | {"frame_xyz": "_mm", "frame_rpy": "_deg"}

    @model_validator(mode="after")
    def _one_rotation(self) -> PlacedLinkTable:
        if self.frame_rpy is not None and self.frame_rotation is not None:
            raise ValueError("either frame_rpy or frame_rotation, which say the same")
        return self

    @property
    def frame(self) -> Placement:
        """The link frame in the joint frame."""
        return _placement(self.frame_xyz, self.frame_rpy, self.frame_rotation)


class PlacementFile(ArmTables[PlacedJointTable, PlacedLinkTable]):
    """A file of an arm by placements."""
