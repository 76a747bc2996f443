"""Two files of one robot compared: the largest torque difference by joint, and what makes it."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gd_analyze.arrays import FloatArray, peak_magnitude
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.mass_matrix import require_positive_definite
from gd_analyze.dynamics.same_base import SameBase
from gd_analyze.errors import ArmError
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Drive, Joint
from gd_analyze.text import joint_name, number

# Shares of peak torque, and relative differences of numbers, that are round-off of turning frames.
NUMBERS_ALIKE = 1e-9
_ROUND_OFF_OF_TORQUE = 1e-11


@dataclass(frozen=True)
class DifferentPart:
    """Numbers in which the two arms differ: a link's, gravity, the drives', or the joints'."""

    name: str  # "link 3 forearm"
    difference: str  # in words
    kind: str  # "link", "gravity", "drives", "axes", "senses" or "zeros"
    link: int | None = None  # from 0


@dataclass(frozen=True)
class Step:
    """A part that the first arm takes over from the second, beside those of the steps before."""

    part: DifferentPart
    alone: FloatArray  # largest change of torque by the part alone, (n,)
    left: FloatArray  # largest difference left after this step, (n,)


@dataclass(frozen=True, eq=False)
class Comparison:
    """Torques of two arms at the same states, joints in the first one's order."""

    first: RobotArm
    second: RobotArm
    states: States
    order: tuple[int, ...]  # the second arm's joint for each of the first, from 0

    @classmethod
    def of(cls, first: RobotArm, second: RobotArm, states: States) -> Comparison:
        """Pair the joints: by name if the names are the same, else from base to tip.

        Raises an `ArmError` if numbers or kinds of joints differ, or D of an arm is not positive definite.
        """
        if first.n_joints != second.n_joints:
            raise ArmError(
                "the two have different numbers of joints",
                found=[
                    f"{arm.name}: {arm.n_joints} ({', '.join(arm.joint_names)})" for arm in (first, second)
                ],
                next_step="hold joints with `lock`, or end both arms at the same link with `tip`",
            )
        names = first.joint_names
        is_named_alike = sorted(names) == sorted(second.joint_names) and len({*names}) == len(names)
        order = [second.joint_names.index(name) if is_named_alike else i for i, name in enumerate(names)]
        for i, k in enumerate(order):
            ours, theirs = first.joints[i], second.joints[k]
            if ours.kind != theirs.kind:
                message = f"joint {joint_name(i + 1, ours.name)} is not of one kind in both"
                raise ArmError(message, where=theirs.place, expected=ours.kind, found=theirs.kind)
        for arm in (first, second):
            require_positive_definite(arm, states, arm.counts_drives())
        return cls(first, second, states, tuple(order))

    @property
    def is_in_order(self) -> bool:
        """Whether the joints follow one another alike in both."""
        return self.order == tuple(range(self.first.n_joints))

    @cached_property
    def torques(self) -> tuple[FloatArray, FloatArray]:
        """Torques of both at all states, N m (N), (N, n) each."""
        q, qd, qdd = (x[:, np.argsort(self.order)] for x in self.states.arrays)
        theirs = torque_of(self.second, States(q, qd, qdd))
        return torque_of(self.first, self.states), theirs[:, list(self.order)]

    @cached_property
    def peaks(self) -> tuple[FloatArray, FloatArray]:
        """Peak torques of both by joint, (n,) each."""
        ours, theirs = self.torques
        return peak_magnitude(ours), peak_magnitude(theirs)

    @cached_property
    def largest(self) -> FloatArray:
        """Largest difference by joint, N m (N), (n,)."""
        return self._largest(self.torques[1] - self.torques[0])

    def shares(self, differences: FloatArray) -> FloatArray:
        """Shares of each joint's peak torque, the larger one of both arms."""
        peak = np.maximum(*self.peaks)
        return np.divide(differences, peak, out=np.zeros_like(peak), where=peak > 0.0)

    def _largest(self, differences: FloatArray) -> FloatArray:
        """Largest magnitude by joint; 0 where it is round-off of the peak torque."""
        largest = np.abs(differences).max(axis=0)
        return np.where(largest > _ROUND_OFF_OF_TORQUE * np.maximum(*self.peaks), largest, 0.0)

    @cached_property
    def base(self) -> SameBase:
        """The second arm in the first one's base frame."""
        return SameBase.of(self.first, self.second)

    @cached_property
    def parts(self) -> tuple[DifferentPart, ...]:
        """Numbers in which the arms differ."""
        return tuple(self._parts())

    def _parts(self) -> Iterator[DifferentPart]:
        base, first, second = self.base, self.first, self.second
        names = [joint_name(i, joint.name) for i, joint in enumerate(first.joints, start=1)]
        if (base.signs < 0).any():
            reverse = [name for name, sign in zip(names, base.signs, strict=True) if sign < 0]
            yield DifferentPart("senses of joints", f"opposite at joint {', '.join(reverse)}", "senses")
        if base.zeros.any():
            moved = zip(names, np.degrees(base.zeros), strict=True)
            text = ", ".join(f"joint {name} by {number(angle)}°" for name, angle in moved if angle)
            yield DifferentPart("zeros of joints", text, "zeros")
        reach = max(first.reach, second.reach) or 1.0
        off = np.maximum(base.turned, base.apart / reach) > NUMBERS_ALIKE
        if off.any():
            worst = int(np.argmax(np.maximum(base.turned, base.apart / reach)))
            turned, apart = np.degrees(base.turned[worst]), base.apart[worst]
            text = f"joint {names[worst]}: turned by {number(turned)}°, {number(1e3 * apart)} mm apart"
            text += f"; less at {off.sum() - 1} more" if off.sum() > 1 else ""
            yield DifferentPart("axes of joints", text, "axes")
        change = float(np.linalg.norm(base.gravity - first.gravity_vector))
        if change > NUMBERS_ALIKE * float(np.linalg.norm(first.gravity_vector)):
            vectors = [", ".join(number(x) for x in g) for g in (first.gravity_vector, base.gravity)]
            yield DifferentPart("gravity", f"({vectors[0]}) and ({vectors[1]}) m/s^2", "gravity")
        ours, theirs = (_drive_inertia(arm) for arm in (first, second))
        if np.abs(ours - theirs).max() > NUMBERS_ALIKE * max(np.abs(ours).max(), np.abs(theirs).max()):
            worst = int(np.argmax(np.abs(ours - theirs)))
            unit = "kg m^2" if first.is_revolute[worst] else "kg"
            text = f"at joint {names[worst]} {number(ours[worst])} and {number(theirs[worst])} {unit}"
            yield DifferentPart("inertia of drives", text, "drives")
        for i, link in enumerate(first.links):
            difference = self._link_difference(i, reach)
            if difference:
                yield DifferentPart(f"link {joint_name(i + 1, link.name)}", difference, "link", i)

    def _link_difference(self, index: int, reach: float) -> str:
        """In what the two links differ."""
        ours, theirs = self.first.links[index], self.base.link(index)
        texts = []
        mass = max(ours.mass, theirs.mass)
        if abs(ours.mass - theirs.mass) > NUMBERS_ALIKE * mass:
            texts.append(f"mass {number(ours.mass)} and {number(theirs.mass)} kg")
        apart = float(np.linalg.norm(ours.com - theirs.com))
        if mass and apart > NUMBERS_ALIKE * reach:
            texts.append(f"centres {number(1e3 * apart)} mm apart")
        size = max(np.abs(ours.inertia_com).max(), np.abs(theirs.inertia_com).max(), mass * reach**2)
        change = float(np.abs(ours.inertia_com - theirs.inertia_com).max())
        if change > NUMBERS_ALIKE * size:
            texts.append(f"inertia by {number(change)} kg m²")
        return ", ".join(texts)

    def steps(self, progress: Progress = NO_PROGRESS) -> list[Step]:
        """Let the first arm take over the second one's parts, at each step the one that leaves least.

        Without parts that no torque shows, such as a centre of mass moved along the first axis.
        """
        taken, waiting, steps = list[DifferentPart](), list(self.parts), list[Step]()
        before = self.largest
        progress.stage("comparing parts", len(waiting) * (len(waiting) + 1) // 2)
        ours, theirs = self.torques
        alone = {part.name: self._largest(self._taking([part]) - ours) for part in waiting}
        while waiting:
            left = []
            for part in waiting:
                left.append(self._largest(theirs - self._taking([*taken, part])))
                progress.advance()
            best = int(np.argmin([self.shares(differences).max() for differences in left]))
            taken.append(waiting.pop(best))
            step = Step(taken[-1], alone[taken[-1].name], left[best])
            if step.alone.any() or (step.left != before).any():
                steps.append(step)
            before = step.left
        return steps

    def _taking(self, parts: Collection[DifferentPart]) -> FloatArray:
        """Torque of the first arm with some parts of the second, (N, n)."""
        kinds, links, base = {part.kind for part in parts}, {part.link for part in parts}, self.base
        # An arm's axes are its frame: with the second one's, what is not taken comes from the first.
        has_second_axes = "axes" in kinds
        arm, other = (self.second, base.reversed) if has_second_axes else (self.first, base)
        inertia = _drive_inertia(self.second if "drives" in kinds else self.first)
        is_foreign = [(i in links) != has_second_axes for i in range(arm.n_joints)]
        arm = replace(
            arm,
            links=tuple(other.link(i) if is_foreign[i] else link for i, link in enumerate(arm.links)),
            gravity_vector=other.gravity if ("gravity" in kinds) != has_second_axes else arm.gravity_vector,
            drives=tuple(Drive(inertia=float(value)) for value in inertia),
            spread=None,
        )
        signs = base.signs if "senses" in kinds else np.ones(len(base.signs))
        zeros = base.zeros if "zeros" in kinds else np.zeros(len(base.zeros))
        # Variables of the first arm whose joints count as the variant's.
        q, qd, qdd = signs * (self.states.q - zeros), signs * self.states.qd, signs * self.states.qdd
        if has_second_axes:
            q, qd, qdd = base.signs * q + base.zeros, base.signs * qd, base.signs * qdd
            signs = signs * base.signs
        torque: FloatArray = signs * torque_of(arm, States(q, qd, qdd))
        return torque


def _drive_inertia(arm: RobotArm) -> FloatArray:
    return arm.drive_inertia if arm.drives else np.zeros(arm.n_joints)


def states_for_both(first: RobotArm, second: RobotArm, count: int, seed: int) -> States:
    """Draw states within the first arm's limits; those it does not state are the second one's."""
    if first.n_joints != second.n_joints:
        return states_in_box(first, 1, seed)  # `Comparison.of` refuses the two
    joints = tuple(map(_with_limits, first.joints, second.joints))
    return states_in_box(replace(first, joints=joints, dh_table=()), count, seed)


def _with_limits(joint: Joint, other: Joint) -> Joint:
    limits = {
        name: getattr(other, name) if getattr(joint, name) is None else getattr(joint, name)
        for name in ("lower", "upper", "velocity_limit", "acceleration_limit")
    }
    return replace(joint, **limits)
