"""Why columns cannot be chosen: several fit alike, or none does; the messages list what there is."""

from __future__ import annotations

from collections.abc import Sequence

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.joints import Family
from gd_analyze.motions.roles import Meaning
from gd_analyze.motions.said import listed
from gd_analyze.motions.table import LogTable
from gd_analyze.motions.words import as_written
from gd_analyze.robots.arm import RobotArm

PLURAL = {"q": "positions", "qd": "velocities", "qdd": "accelerations", "torque": "torques"}


class AmbiguityError(TrajectoryError):
    """Several families fit alike; those of them that are 0 throughout may yet be left out."""

    families: tuple[Family, ...] = ()


def ambiguous(role: str, choices: Sequence[Family], table: LogTable) -> AmbiguityError:
    """Error of families of which none is to be preferred."""
    shared = frozenset.intersection(*(family.words for family in choices))
    told, words = [], []
    for family in choices[:6]:
        first = min(family.all_columns)
        own = sorted(
            family.words - shared, key=lambda word: (word in ("plain", "measured", "target", ""), word)
        )
        told.append(f"{table.names[first]} and so on")
        if own and own[0]:
            words.append(own[0])
    choose_by = " or ".join(f"--family {word}" for word in words) or "--columns with the names to look at"
    error = AmbiguityError(
        f"several columns may be the {PLURAL[role]}",
        where=table.where(),
        expected="one column per joint",
        found="; ".join(told),
        next_step=f"choose: {choose_by}",
    )
    error.families = tuple(choices)
    return error


def no_positions(
    of_role: Sequence[Family],
    families: Sequence[Family],
    table: LogTable,
    arm: RobotArm,
    meanings: Sequence[Meaning],
    words: Sequence[str],
) -> TrajectoryError:
    """Error of a log whose positions are not those of the arm's joints, or of some of them only."""
    names = [joint.name for joint in arm.joints]
    if words and not of_role and any(family.role == "q" for family in families):
        return TrajectoryError(
            f"no positions are of family {' '.join(words)}",
            where=table.where(),
            expected=", ".join(sorted({word for f in families if f.role == "q" for word in f.words if word})),
            found=" ".join(words),
            next_step="give one of these words with --family",
        )
    if of_role:
        nearest = max(of_role, key=lambda family: len(family.columns))
        missing = [names[j] for j in range(arm.n_joints) if j not in nearest.columns]
        having = [table.names[c] for c in nearest.all_columns]
        others = [name for name in table.names if name and name not in having]
        return TrajectoryError(
            f"the log has no position of joint {', '.join(missing)}",
            where=table.where(),
            expected=f"a position of every joint of arm {arm.name}: {', '.join(names)}",
            found=f"{listed(having)}; beside it {listed(others)}" if others else listed(having),
            next_step=f"--map 'q:{missing[0]}=COLUMN' names a column, or choose the arm the log is of",
        )
    strangers = [k for k, m in enumerate(meanings) if m.role == "q" and m.token and m.joint is None]
    if strangers:
        tokens = list(
            dict.fromkeys(
                as_written(meanings[k].token, table.names[k]) if meanings[k].label else table.names[k]
                for k in strangers
            )
        )
        pairs = [f"--map joint:{own}={other}" for own, other in zip(names, tokens, strict=False)]
        return TrajectoryError(
            f"the log's joints are not those of arm {arm.name}",
            where=table.where(),
            expected=", ".join(names),
            found=listed(tokens),
            next_step=f"if they are the same in this order: {' '.join(pairs)}",
        )
    return TrajectoryError(
        "no column is known to be a position of a joint",
        where=table.where(),
        expected=f"names such as q1, joint_1, actual_q_0, or those of the arm's joints: {', '.join(names)}",
        found=listed([name for name in table.names if name]) or "columns without names",
        next_step=f"name the columns: --map 'q:{names[0]}=COLUMN' and so on",
    )
