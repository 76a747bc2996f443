"""Every step that `identify` and `diagnose` print is typed, and what it prints in turn, to the end."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.arrays import FloatArray
from logs_of_arms import TrueArm, fourier
from long_cases import long

COMMAND = re.compile(r"`gd-analyze ([^`]*)`")
FLAGS = ("--anyway", "--plain")
# Verbs whose options mend how a log is read.
READING = ("identify", "diagnose")
MOST_STEPS = 4

Arrays = tuple[FloatArray, FloatArray, FloatArray]


def dead(time: FloatArray, q: FloatArray, torque: FloatArray) -> Arrays:
    return time, q, torque * [0.0, 1.0]


def copied(time: FloatArray, q: FloatArray, torque: FloatArray) -> Arrays:
    return time, q, torque[:, [1, 1]]


def reversed_(time: FloatArray, q: FloatArray, torque: FloatArray) -> Arrays:
    return time, q, -torque


def one_reversed(time: FloatArray, q: FloatArray, torque: FloatArray) -> Arrays:
    return time, q, torque * [1.0, -1.0]


def millinewtons(time: FloatArray, q: FloatArray, torque: FloatArray) -> Arrays:
    return time, q, 1e3 * torque


def turned(time: FloatArray, q: FloatArray, torque: FloatArray) -> Arrays:
    return time, q + np.array([np.pi / 2.0, 0.0]), torque


def still(time: FloatArray, q: FloatArray, torque: FloatArray) -> Arrays:
    noise = np.random.default_rng(0).normal(size=q.shape)
    return time, 0.3 + 1e-4 * noise, 0.0 * torque + 1e-3 * noise[::-1]


def of_noise(time: FloatArray, q: FloatArray, torque: FloatArray) -> Arrays:
    return time, q, np.random.default_rng(0).normal(size=torque.shape)


def clipped(time: FloatArray, q: FloatArray, torque: FloatArray) -> Arrays:
    return time, q, np.clip(torque, *np.quantile(torque, [0.2, 0.8], axis=0))


def good(time: FloatArray, q: FloatArray, torque: FloatArray) -> Arrays:
    return time, q, torque


@pytest.fixture
def robots(here, two_link) -> dict[str, str]:
    """Files of an arm, as it is and without masses."""
    nothing = [
        replace(link, mass=0.0, com=np.zeros(3), inertia_com=np.zeros((3, 3))) for link in two_link.links
    ]
    gd.save_arm(replace(two_link, links=tuple(nothing), drives=()), "massless.toml")
    return {"full": "two_link", "massless": "massless.toml"}


def written(two_link: gd.types.RobotArm, spoil: Callable[..., Arrays]) -> None:
    true = TrueArm.near(two_link, 3)
    time, states = fourier(two_link, 8.0, 100.0, 1)
    recording = true.log(time, states, seed=1).recording
    arrays = spoil(time, recording.q, recording.torque)
    head = "time,q1,q2,torque1,torque2"
    np.savetxt("log.csv", np.column_stack(arrays), delimiter=",", header=head, comments="", fmt="%.10g")


def steps_of(line: str, text: str, robot: str) -> list[str]:
    """Commands that an answer prints, and its options added to the command that was typed."""
    text = " ".join(text.split())
    commands = [
        command.replace("ROBOT", robot).replace("LOG", "log.csv") for command in COMMAND.findall(text)
    ]
    if line.split()[0] in READING:
        for advice in re.findall(r"(?:next: |; |Use )(--.*?)(?=; |$|error|Remedy)", COMMAND.sub("", text)):
            options: list[str] = []
            words = iter(shlex.split(advice.replace("'", "\\'")))
            for word in words:
                if not word.startswith("--"):
                    break
                options += [word] if word in FLAGS else [word, next(words).rstrip(".")]
            # A column that is named is the user's to fill in.
            if not any("COLUMN" in word for word in options):
                commands.append(f"{line} {shlex.join(options)}")
    return list(dict.fromkeys(commands))


@pytest.mark.parametrize("arm", ["full", "massless"])
@pytest.mark.parametrize(
    "spoil",
    [
        dead,
        reversed_,
        of_noise,
        *map(long, (still, copied, one_reversed, millinewtons, turned, clipped, good)),
    ],
)
def test_no_printed_step_leads_to_a_dead_end(run, robots, two_link, arm, spoil):
    """Each ends in an answer within some steps, and none leads back to what was tried before."""
    written(two_link, spoil)
    robot = robots[arm]
    outcomes: dict[str, tuple[int, list[str]]] = {}

    def follow(line: str, before: tuple[str, ...]) -> None:
        assert line not in before, f"{' -> '.join(before)} leads back to {line}"
        assert len(before) <= MOST_STEPS, before
        if line not in outcomes:
            result = run(line)
            outcomes[line] = result.code, steps_of(line, result.err + "\n" + result.out, robot)
            assert result.code in (0, 2), result.err
        code, steps = outcomes[line]
        # Who is refused is told what else to do, if only to record more or to name a column.
        assert code == 0 or steps or "next: " in run(line).err, line
        assert code == 0 or line.split()[0] in READING, f"{before[-1]} prints {line}, which is refused"
        for step in steps:
            # Once there is an answer, only what mends the log goes on.
            if code or step.startswith(line):
                follow(step, (*before, line))

    for verb in READING:
        follow(f"{verb} {robot} log.csv" + (" --no-model" if verb == "identify" else ""), ())
    assert spoil is still or 0 in {code for code, _ in outcomes.values()}
