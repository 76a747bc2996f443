"""Hypotheses on the arm: how it is mounted, what it carries, and when that changes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.diagnosis.correction import Added, Correction
from gd_analyze.diagnosis.equations import with_gravity
from gd_analyze.diagnosis.fit import FileFit
from gd_analyze.diagnosis.hypothesis import COST_PER_NUMBER, KNOWN_ADVANTAGE, Candidate, Hypothesis, Problem
from gd_analyze.diagnosis.remedies import vector
from gd_analyze.dynamics.base_parameters import PARAMETERS, inertial_parameters, regressor
from gd_analyze.robots.parts import Link, of_point_mass
from gd_analyze.text import number, to_digits_of, with_error

_CARRIED_MASS_SHARE = 0.1  # plausible mass of what an arm carries, as a share of its own
_DISTANCE_SHARE = 0.15  # plausible distance of this mass, as a share of the reach
_INERTIA_SHARE = 0.5  # its inertia as a share of its mass times the square of its distance
_LEAST_MASS_SHARE = 0.01  # least share of an arm's mass that is mentioned as a payload
_CURVED_OVER = 0.3  # step over which the score's curvature is taken, in plausible sizes
# Standard deviation of a torque's change at a restart, as a share of its RMS.
_JUMP_SHARE = 0.3

# The search for the direction of gravity, by steps of a tangent.
_FIRST_TILT = 0.35  # first size of a step
_LAST_TILT = 0.02  # size of a step at which the search ends
_WORTHWHILE_FALL = 0.5  # fall of the score worth a step
_LARGEST_TILT = 3.0  # tangent of the largest tilt from where the search began
_LEAST_TILT_DEGREES = 1.0  # least tilt that is mentioned

# Powers of length in a body's numbers, and its inertia as a share of the square of its distance.
_POWERS = np.array([kind.count("x") + kind.count("y") + kind.count("z") for kind in PARAMETERS])


class Gravity(Hypothesis):
    """The arm hangs, leans, or compensates its gravity."""

    name = "gravity"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best of six directions and none; and any other direction if it is clearly better."""
        correction, file = problem.correction, problem.arm.gravity
        size = float(np.linalg.norm(file))
        if size == 0.0:
            return
        down = file / size
        axes = [vector for axis in np.eye(3) for vector in (axis, -axis) if vector @ down < 0.9]
        directions = [(self._named(axis, down), size * axis) for axis in axes]
        corrections = [replace(correction, gravity=g) for _, g in directions]
        scores = problem.roughly(corrections)
        k = int(np.argmin(scores))
        weightless = replace(correction, gravity=np.zeros(3))
        yield Candidate(
            self.name,
            "Torques do not contain gravity: the controller compensates it",
            "--gravity 0,0,0",
            weightless,
            alternatives=len(directions) + 1,
        )
        sentence, g = directions[k]
        leaning, score = self._leaning(problem, [down, g / size][: 1 + problem.helps(scores[k])], size)
        if problem.score(corrections[k]) < score + KNOWN_ADVANTAGE:
            yield Candidate(
                self.name,
                sentence,
                f"--gravity {vector(g)}",
                corrections[k],
                alternatives=len(directions) + 1,
            )
        else:
            tilt = np.degrees(np.arccos(np.clip(leaning @ down / size, -1.0, 1.0)))
            if tilt < _LEAST_TILT_DEGREES:
                return
            yield Candidate(
                self.name,
                f"The arm's base is tilted by {number(float(tilt))} degrees",
                f"--gravity {vector(leaning)}",
                replace(correction, gravity=leaning),
                numbers=2,
            )

    def _named(self, axis: FloatArray, down: FloatArray) -> str:
        if axis @ down < -0.9:
            return "The arm hangs from the ceiling, the file says it stands"
        return f"The arm is mounted on a wall: gravity is along {vector(axis)} of its base"

    def _leaning(self, problem: Problem, begins: list[FloatArray], size: float) -> tuple[FloatArray, float]:
        """Direction of gravity by steps from some beginnings, judged by few samples, then by all."""
        ends = [_descended(problem, begin, size) for begin in begins]
        gravity = min(ends, key=lambda end: end[1])[0]
        for side in np.linalg.svd(gravity[None])[2][1:]:

            def turned(angle: float, down: FloatArray = gravity, side: FloatArray = side) -> Correction:
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
            "record a motion that the drives make, with the torques that they need for it",
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
            "The file is of another size or variant of the robot: its links are far off",
            "take the file of this robot",
            replace(problem.correction, freedom=self._FREEDOM),
            numbers=self._NUMBERS,
            rare=-self._NUMBERS * COST_PER_NUMBER,  # the score has the cost of what is free
            unsure="the links alone are that far off",
        )


def _carried(problem: Problem, when: FloatArray | None = None) -> Added:
    """Torque per unit of a body's ten numbers in the last link's frame, where `when` is 1."""
    arm = problem.arm
    q, qd, qdd, _ = problem.correction.states(problem.samples)
    # Of the last link alone, (n, 10, N).
    per_unit = regressor(with_gravity(arm, problem.correction.gravity), q.T, qd.T, qdd.T)[:, -1]
    mass = _CARRIED_MASS_SHARE * float(arm.mass.sum())
    away = _DISTANCE_SHARE * (arm.reach or 1.0)
    columns = np.swapaxes(per_unit, 1, 2)
    if when is not None:
        columns = columns * when[:, None]
    sizes = mass * away**_POWERS * np.where(_POWERS == 2, _INERTIA_SHARE, 1.0)
    return Added(np.ascontiguousarray(columns), sizes)


def _of_added(fit: FileFit, added: Added) -> FloatArray:
    return np.asarray(fit.free[-len(added.sizes) :] * added.sizes)


def _errors_of_added(problem: Problem, added: Added, values: FloatArray) -> FloatArray:
    """Standard errors of the first numbers of a body, by the curvature of the score with each held."""
    taken_off = problem.correction.taken_off
    errors = []
    for k, value in enumerate(values.tolist()):
        size, others = float(added.sizes[k]), np.arange(len(added.sizes)) != k
        free = Added(added.columns[..., others], added.sizes[others])

        def score(x: float, k: int = k, size: float = size, free: Added = free) -> float:
            held = np.zeros(len(added.sizes))
            held[k] = x
            body = -held if taken_off is None else taken_off - held
            correction = replace(problem.correction, taken_off=body).with_added(free)
            return problem.rough_score(correction) + (x / size) ** 2

        step = _CURVED_OVER * size
        bend = (score(value - step) - 2.0 * score(value) + score(value + step)) / step**2
        # What the log does not tell is as plausible as before.
        errors.append(float(np.sqrt(2.0 / max(bend, 2.0 / size**2))))
    return np.array(errors)


class Payload(Hypothesis):
    """The arm carries what its file does not say, or the other way round."""

    name = "payload"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """Four numbers of a body at the last link."""
        added = _carried(problem)
        correction = problem.correction.with_added(added)
        mass, *moment = _of_added(problem.fit(correction), added)[:4]
        place = np.array(moment) / mass if mass else np.zeros(3)
        is_light = abs(mass) < _LEAST_MASS_SHARE * problem.arm.mass.sum()
        if is_light or np.linalg.norm(place) > (problem.arm.reach or 1.0):
            return
        error, *moment_errors = _errors_of_added(problem, added, np.array([mass, *moment]))
        if mass > 0.0:
            tip = problem.arm.tip_frame
            local = tip.rotation.T @ (place - tip.translation)
            errors = np.hypot(moment_errors, place * error) / mass
            errors = np.sqrt(np.square(tip.rotation.T) @ errors**2)
            coordinates = ",".join(map(to_digits_of, local.tolist(), errors.tolist()))
            sentence = f"The arm carries {with_error(mass, error)} kg that its file lacks"
            remedy = f"--payload {to_digits_of(mass, error)},{coordinates}"
        else:
            sentence = f"The file carries {with_error(-mass, error)} kg at its end that the robot did not"
            remedy = f"take {to_digits_of(-mass, error)} kg off the file's last link"
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
            ends.append((mass, "leave out --payload", _numbers_of(last) - _numbers_of(last.bare)))
        ends = [end for end in ends if end[2][0] > _LEAST_MASS_SHARE * arm.mass.sum()]
        corrections = [replace(correction, taken_off=numbers) for *_, numbers in ends]
        for k in problem.best(corrections) if corrections else []:
            body, remedy, _ = ends[k]
            yield Candidate(
                self.name,
                f"{body} is in the file, not on the robot",
                remedy,
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
        load = _carried(problem)
        size = np.sqrt((samples.torque**2).mean(axis=0)) + 1e-12
        single = np.zeros((n, len(samples), n))
        for i in range(n):
            single[i, :, i] = 1.0
        offsets = Added(single, _JUMP_SHARE * size)
        places = np.linspace(0.1, 0.9, 7) * len(order)
        ends = places[[0, -1]]

        def changed(place: float, kind: Added) -> Correction:
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
            at = samples.time[min(max(round(place), 0), len(order) - 1)]
            when = f"{number(float(at))} s"
            yield Candidate(
                self.name,
                f"{sentence} at {when}",
                f"split the log at {when}, and diagnose its parts",
                changed(place, kind),
                numbers=numbers,
                alternatives=9,
            )
