"""Hypotheses on the arm: how it is mounted, what it carries, and when that changes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.diagnosis.equations import with_gravity
from gd_analyze.diagnosis.hypothesis import (
    COST_PER_NUMBER,
    KNOWN_ADVANTAGE,
    Candidate,
    Hypothesis,
    Problem,
)
from gd_analyze.diagnosis.remedies import NO_PAYLOAD, edited, under_gravity, vector, with_load
from gd_analyze.diagnosis.trial import Added, Trial
from gd_analyze.dynamics.base_parameters import PARAMETERS, inertial_parameters, link_regressor
from gd_analyze.robots.parts import Link, of_point_mass
from gd_analyze.text import number, to_digits_of, with_error

_CARRIED_MASS_SHARE = 0.1  # plausible mass of what an arm carries, as a share of its own
_DISTANCE_SHARE = 0.15  # plausible distance of this mass, as a share of the reach
_INERTIA_SHARE = 0.5  # its inertia as a share of its mass times the square of its distance
LEAST_MASS_SHARE = 0.01  # least share of an arm's mass that is mentioned as a payload
# Standard deviation of a torque's change at a restart, as a share of its RMS.
_JUMP_SHARE = 0.3

# The search for the direction of gravity, by steps of a tangent.
_FIRST_TILT = 0.35  # first size of a step
_LAST_TILT = 0.02  # size of a step at which the search ends
_WORTHWHILE_FALL = 0.5  # fall of the score worth a step
_LARGEST_TILT = 3.0  # tangent of the largest tilt from where the search began
_LEAST_TILT_DEGREES = 1.0  # least tilt that is mentioned

_DRIVEN = "record a motion that the drives make, with the torques that they need for it"

# Powers of length in a body's numbers, and its inertia as a share of the square of its distance.
_POWERS = np.array([kind.count("x") + kind.count("y") + kind.count("z") for kind in PARAMETERS])


class Gravity(Hypothesis):
    """The arm hangs, leans, or compensates its gravity."""

    name = "gravity"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best of six directions and none; and any other direction if it is clearly better."""
        file, size = problem.arm.gravity_vector, float(np.linalg.norm(problem.arm.gravity_vector))
        if size == 0.0:
            return
        down = file / size
        axes = [axis for unit in np.eye(3) for axis in (unit, -unit) if axis @ down < 0.9]
        scores = problem.roughly(replace(problem.correction, gravity=size * axis) for axis in axes)
        k = int(np.argmin(scores))
        known = size * axes[k]
        leaning, score = self._leaning(problem, [down, known / size][: 1 + problem.helps(scores[k])], size)
        told = [("Torques do not contain gravity: the controller compensates it", np.zeros(3))]
        if problem.score(replace(problem.correction, gravity=known)) < score + KNOWN_ADVANTAGE:
            mounted = f"The arm is mounted on a wall: gravity is along {vector(axes[k])} of its base"
            hangs = "The arm hangs from the ceiling, the file says it stands"
            told.append((hangs if axes[k] @ down < -0.9 else mounted, known))
            tilt = 0.0
        else:
            tilt = float(np.degrees(np.arccos(np.clip(leaning @ down / size, -1.0, 1.0))))
        if tilt >= _LEAST_TILT_DEGREES:
            told.append((f"The arm's base is tilted by {number(tilt)} degrees", leaning))
        for sentence, gravity in told:
            yield Candidate(
                self.name,
                sentence,
                under_gravity(problem.samples, gravity),
                replace(problem.correction, gravity=gravity),
                numbers=2 if gravity is leaning else 0,
                alternatives=1 if gravity is leaning else len(axes) + 1,
            )

    def _leaning(self, problem: Problem, begins: list[FloatArray], size: float) -> tuple[FloatArray, float]:
        """Direction of gravity by steps from some beginnings, judged by few samples, then by all."""
        ends = [_descended(problem, begin, size) for begin in begins]
        gravity = min(ends, key=lambda end: end[1])[0]
        for side in np.linalg.svd(gravity[None])[2][1:]:

            def turned(angle: float, down: FloatArray = gravity, side: FloatArray = side) -> Trial:
                leaning = np.cos(angle) * down + np.sin(angle) * size * side
                return replace(problem.correction, gravity=np.asarray(leaning))

            angle = problem.refined(turned, 0.0, np.radians(1.5))
            gravity = np.cos(angle) * gravity + np.sin(angle) * size * side
        return gravity, problem.score(replace(problem.correction, gravity=gravity))


def _descended(problem: Problem, begin: FloatArray, size: float) -> tuple[FloatArray, float]:
    """Gravity of that size near a unit vector whose rough score no step improves, and that score."""
    across = np.linalg.svd(begin[None])[2][1:]

    def gravity_along(x: FloatArray) -> FloatArray:
        turned = begin + x @ across
        return np.asarray(size * turned / np.linalg.norm(turned))

    def score(x: FloatArray) -> float:
        return problem.rough_score(replace(problem.correction, gravity=gravity_along(x)))

    x, width = np.zeros(2), _FIRST_TILT
    current = score(x)
    while width > _LAST_TILT:
        moves = [x + width * step for step in (*np.eye(2), *-np.eye(2))]
        scores = [score(move) for move in moves]
        if min(scores) < current - _WORTHWHILE_FALL and np.linalg.norm(x) < _LARGEST_TILT:
            x, current = moves[int(np.argmin(scores))], min(scores)
        else:
            width /= 2.5
    return gravity_along(x), current


class GravityAlone(Hypothesis):
    """Torques hold the arm and do not move it: a hand does, or they are a controller's gravity term."""

    name = "gravity alone"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """Torques as at rest in every position."""
        yield Candidate(
            self.name,
            "Torques hold gravity alone, as where a hand moves the arm: they do not follow its motion",
            edited(problem.samples, _DRIVEN),
            replace(problem.correction, pace=np.inf),
        )


class AnotherArm(Hypothesis):
    """The file is of another size or variant: its links are off by far more than a file's usually are."""

    name = "another arm"
    _FREEDOM = 4.0  # factor on the usual errors of a file
    _NUMBERS = 10  # those of a link: a cause of fewer that is about as good is told instead

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """Links as free as this."""
        if problem.correction.freedom != 1.0:
            return
        yield Candidate(
            self.name,
            "The links are far off, as of another variant of the robot, or of torques in another scale",
            edited(problem.samples, "take the file of this robot"),
            replace(problem.correction, freedom=self._FREEDOM),
            numbers=self._NUMBERS,
            rare=-self._NUMBERS * COST_PER_NUMBER,  # the score has the cost of what is free
            unsure="the links alone are that far off",
        )


def carried(problem: Problem) -> Added:
    """Torque per unit of a body's ten numbers in the last link's frame."""
    arm = problem.arm
    q, qd, qdd, _ = problem.correction.states(problem.samples)
    # Of the last link alone, (n, 10, N).
    per_unit = link_regressor(with_gravity(arm, problem.correction.gravity), q.T, qd.T, qdd.T)[:, -1]
    mass = _CARRIED_MASS_SHARE * float(arm.mass.sum())
    away = _DISTANCE_SHARE * (arm.reach or 1.0)
    sizes = mass * away**_POWERS * np.where(_POWERS == 2, _INERTIA_SHARE, 1.0)
    return Added(np.ascontiguousarray(np.swapaxes(per_unit, 1, 2)), sizes)


class Payload(Hypothesis):
    """The arm carries what its file does not say, or the other way round."""

    name = "payload"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """Four numbers of a body at the last link."""
        added = carried(problem)
        correction = problem.correction.with_added(added)
        fit = problem.fit(correction)
        body, errors_of_body = (x[-len(added.sizes) :] * added.sizes for x in (fit.free, fit.errors))
        mass, *moment = body[:4]
        place = np.array(moment) / mass if mass else np.zeros(3)
        is_light = abs(mass) < LEAST_MASS_SHARE * problem.arm.mass.sum()
        if is_light or np.linalg.norm(place) > (problem.arm.reach or 1.0):
            return
        error, *moment_errors = errors_of_body[:4]
        if mass > 0.0:
            tip = problem.arm.tip_frame
            local = tip.rotation.T @ (place - tip.translation)
            errors = np.hypot(moment_errors, place * error) / mass
            errors = np.sqrt(np.square(tip.rotation.T) @ errors**2)
            numbers = map(to_digits_of, [mass, *local.tolist()], [error, *errors.tolist()])
            sentence = f"The arm carries {with_error(mass, error)} kg that its file lacks"
            remedy = with_load(problem.samples, [*numbers])
        else:
            sentence = f"The file carries {with_error(-mass, error)} kg at its end that the robot did not"
            remedy = edited(problem.samples, f"take {to_digits_of(-mass, error)} kg off the file's last link")
        yield Candidate(
            self.name, sentence, remedy, correction, numbers=4, unsure="the last link is wrong by as much"
        )


class NamedEnd(Hypothesis):
    """A body that the file names beyond the last joint, or --payload, is not on the robot."""

    name = "payload"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best of these bodies."""
        arm, correction = problem.arm, problem.correction
        last = arm.links[-1]
        ends = [
            (f"{end.name} ({number(end.mass)} kg)", f"take {end.name} out of the file", _numbers_of(end))
            for end in arm.ends
        ]
        if last.bare is not None:
            mass = f"The payload ({number(last.mass - last.bare.mass)} kg)"
            ends.append((mass, NO_PAYLOAD, _numbers_of(last) - _numbers_of(last.bare)))
        ends = [end for end in ends if end[2][0] > LEAST_MASS_SHARE * arm.mass.sum()]
        corrections = [replace(correction, taken_off=numbers) for *_, numbers in ends]
        for k in problem.best(corrections):
            body, remedy, _ = ends[k]
            yield Candidate(
                self.name,
                f"{body} is in the file, not on the robot",
                edited(problem.samples, remedy),
                corrections[k],
                alternatives=len(ends),
                unsure="the last link is wrong by as much",
            )


def _numbers_of(link: Link) -> FloatArray:
    """A body's ten numbers about the origin of its frame, (10,)."""
    inertia = link.inertia_com + of_point_mass(link.mass, link.com)
    return inertial_parameters(link.mass, link.mass * link.com, inertia)


class ChangeInTime(Hypothesis):
    """From some instant on the arm carries another load, or its torques have other offsets."""

    name = "change in time"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best instant of either kind."""
        samples, n = problem.samples, problem.n
        order = np.arange(len(samples))
        if len(samples.logs) > 1 or len(order) < 40:
            return
        load = carried(problem)
        size = np.sqrt((samples.torque**2).mean(axis=0)) + 1e-12
        single = np.repeat(np.eye(n)[:, None], len(samples), axis=1)
        offsets = Added(single, _JUMP_SHARE * size)
        places = np.linspace(0.1, 0.9, 7) * len(order)
        ends = places[[0, -1]]

        def changed(place: float, kind: Added) -> Trial:
            after = (order >= place).astype(float)
            return problem.correction.with_added(Added(kind.columns * after[:, None], kind.sizes))

        for kind, numbers, sentence in (
            (load, 5, "The load changes"),
            (offsets, n + 1, "Torques change by an offset"),
        ):
            scores = problem.roughly(changed(place, kind) for place in places)
            if not problem.helps(scores.min()):
                continue
            place = float(places[int(scores.argmin())])
            for width in (0.05, 0.025, 0.0125):
                near = np.clip(
                    [place, place - width * len(order), place + width * len(order)], *ends
                ).tolist()
                place = near[problem.best([changed(x, kind) for x in near])[0]]
            when = f"{number(float(samples.time[round(place)]))} s"
            yield Candidate(
                self.name,
                f"{sentence} at {when}",
                edited(samples, f"split the log at {when}, and diagnose its parts"),
                changed(place, kind),
                numbers=numbers,
                alternatives=9,
            )
