"""How a log shall be read, where its columns do not tell it themselves."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.logged import Quantity

ROLES: tuple[Quantity, ...] = ("q", "qd", "qdd", "torque")
TIME_UNIT_NAMES = ("s", "ms", "us", "ns")
NONE = "none"

_RANGE = re.compile(r"(.*?)([0-9]{1,4})\.\.(.*?)([0-9]{1,4})")
_MOST_COLUMNS = 10_000


@dataclass(frozen=True)
class Reading:
    """What the user says about a log; all that is left out is understood from the log.

    Parameters
    ----------
    columns
        Names of the columns of a file without a header, `-` for one that is not needed; of a file with one,
        the only columns to look at. `q1..q6` stands for six names.
    map
        What a column holds: "time", "q:JOINT" (or qd, qdd, torque) and its column, by name or as #NUMBER
        from 1; "joint:JOINT" and the joint's name in the log; "torque" (or qd, qdd) and "none".
    rate
        Samples per second, Hz, where the log counts samples or has no time.
    time_unit
        s, ms, us or ns.
    degrees
        Whether angles of columns that state no unit are in degrees.
    family
        Which columns to take where several hold the same: a word of their names, or a role and a word.
    topic
        Of a bag.
    mapping
        A mapping file; `save_mapping` writes it.
    save_mapping
        Where to write how the log was understood.
    measured
        Whether these are readings of sensors, or else a plan.
    """

    columns: tuple[str, ...] = ()
    map: tuple[tuple[str, str], ...] = ()
    rate: float | None = None
    time_unit: str | None = None
    degrees: bool = False
    family: tuple[tuple[str, str], ...] = ()
    topic: str | None = None
    mapping: str | Path | None = None
    save_mapping: str | Path | None = None
    measured: bool | None = None

    @classmethod
    def of(
        cls,
        columns: str | Iterable[str] = (),
        map: Iterable[str] | dict[str, str] = (),
        family: str | Iterable[str] = (),
        **rest: Any,
    ) -> Reading:
        """Take words as they are typed: "time,q1..q6", "q:elbow=Position3", "torque=cur".

        Raises
        ------
        TrajectoryError
            If they cannot be read.
        """
        listed = columns.split(",") if isinstance(columns, str) else list(columns)
        pairs = map.items() if isinstance(map, dict) else (_pair(entry, "map") for entry in map)
        families = [family] if isinstance(family, str) else list(family)
        return cls(
            columns=tuple(name for entry in listed if entry for name in _counted(entry.strip())),
            map=tuple((role.strip(), column.strip()) for role, column in pairs),
            family=tuple(_pair(word, "family") if "=" in word else ("", word) for word in families),
            **rest,
        )

    def __post_init__(self) -> None:
        if self.time_unit is not None and self.time_unit not in TIME_UNIT_NAMES:
            raise TrajectoryError(
                "there is no such unit of time",
                where="time_unit",
                expected=", ".join(TIME_UNIT_NAMES),
                found=repr(self.time_unit),
            )
        if self.rate is not None and not 0.0 < self.rate <= 1e12:
            raise TrajectoryError(
                "the rate is not possible", where="rate", expected="Hz, above 0", found=repr(self.rate)
            )
        if self.rate is not None and self.time_unit is not None:
            raise TrajectoryError(
                "a rate and a unit of time contradict each other",
                where="rate",
                expected="a rate where the log counts samples, or the unit of its time",
                found=f"{self.rate:g} Hz and {self.time_unit}",
            )
        for role, word in self.family:
            if role not in ("", *ROLES):
                raise TrajectoryError(
                    f"there is no role {role!r}",
                    where="family",
                    expected=", ".join(ROLES),
                    found=f"{role}={word}",
                )

    @property
    def asked(self) -> bool:
        """Whether anything is said at all."""
        return self != Reading()

    def words_for(self, role: str) -> tuple[str, ...]:
        """Words that columns of a role shall have in their names."""
        own = tuple(word for of, word in self.family if of == role)
        return own or tuple(word for of, word in self.family if not of)


def _pair(entry: str, where: str) -> tuple[str, str]:
    role, equals, column = entry.partition("=")
    if not equals or not role.strip() or not column.strip():
        raise TrajectoryError(
            "this maps nothing",
            where=f"--{where}",
            expected="ROLE=COLUMN, such as time=Time, q:elbow_joint=Position3 or joint:elbow_joint=joint_a3",
            found=repr(entry),
        )
    return role.strip(), column.strip()


def _counted(entry: str) -> list[str]:
    """Names of `q1..q6`; of any other entry itself."""
    found = _RANGE.fullmatch(entry)
    if found is None:
        return [entry]
    first, last = int(found[2]), int(found[4])
    if found[3] not in ("", found[1]) or not first <= last < first + _MOST_COLUMNS:
        raise TrajectoryError(
            "this is no row of names",
            where="--columns",
            expected="q1..q6, with the same letters on both sides",
            found=repr(entry),
        )
    return [f"{found[1]}{k}" for k in range(first, last + 1)]
