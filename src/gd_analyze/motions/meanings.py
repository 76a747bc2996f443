"""What the columns of a log say, each by its name; text that names joints counts, other text says nothing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from gd_analyze.motions.reading import ROLES, Reading
from gd_analyze.motions.roles import Meaning, known_joints, meaning_of
from gd_analyze.motions.said import joint_named, no_column
from gd_analyze.motions.table import LogTable
from gd_analyze.motions.text_table import TextTable, is_text
from gd_analyze.motions.units import TIME_UNITS, fitting_unit
from gd_analyze.motions.words import words_of
from gd_analyze.robots.arm import RobotArm


def meanings_of(table: LogTable, arm: RobotArm, reading: Reading) -> list[Meaning]:
    """What the columns' names say; text and columns not asked for say nothing."""
    known = known_joints([joint.name for joint in arm.joints])
    for role, other in reading.map:
        if role.startswith("joint:"):
            joint = joint_named(role.removeprefix("joint:"), arm)
            known = {words: k for words, k in known.items() if k != joint} | {words_of(other): joint}
    named = tuple(name or "-" for name in table.names) == reading.columns  # those of a file without a header
    only = set() if named else set(reading.columns)
    missing = only - set(table.names)
    if missing:
        raise no_column(sorted(missing)[0], table, "--columns")
    meanings = []
    for name in table.names:
        meaning = meaning_of(name, known) if name and (not only or name in only) else Meaning("other")
        if meaning.unit and meaning.role in ROLES:
            fits = any(fitting_unit(meaning.unit, meaning.role, turns) for turns in (True, False))
            meaning = meaning if fits else Meaning("other", unit=meaning.unit)
        if meaning.role == "time" and meaning.unit and meaning.unit not in TIME_UNITS:
            meaning = Meaning("other", unit=meaning.unit)
        meanings.append(meaning)
    return _without_text(_named_in_rows(meanings, table, known), table)


def _without_text(meanings: list[Meaning], table: LogTable) -> list[Meaning]:
    return [
        Meaning("other")
        if meaning.role in (*ROLES, "time") and is_text(table.head(k)) and not _some_numbers(table, k)
        else meaning
        for k, meaning in enumerate(meanings)
    ]


def _some_numbers(table: LogTable, column: int) -> bool:
    return any(isinstance(cell, float) for cell in table.head(column))


def _named_in_rows(
    meanings: list[Meaning], table: LogTable, known: Mapping[tuple[str, ...], int]
) -> list[Meaning]:
    """Give counted columns the joints' names where the log has columns name0, name1 and so on."""
    labels, cells = {}, {}
    for k, meaning in enumerate(meanings):
        if meaning.role == "name" and meaning.number is not None:
            text = next((cell for cell in table.head(k) if isinstance(cell, str)), None)
            if text is not None:
                labels[meaning.number], cells[k] = words_of(text), text
    if not labels:
        return meanings
    if isinstance(table, TextTable):  # of other tables in which text may change none is read
        table.require_constant(cells, or_empty=True)
    return [
        replace(
            meaning, token=() if labels[number] in known else labels[number], joint=known.get(labels[number])
        )
        if meaning.role in ROLES and (number := meaning.number) in labels and meaning.joint is None
        else meaning
        for meaning in meanings
    ]
