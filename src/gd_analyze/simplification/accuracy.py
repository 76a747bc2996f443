"""Stated torque error of a model, the states where it was measured, and the search for the model."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple

import lazy_loader
import numpy as np

from gd_analyze.arrays import FloatArray, peak_magnitude, round_off_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.budget import Allowance, Budget, ReferenceTorques
from gd_analyze.text import amount, named_joints, percent

if TYPE_CHECKING:
    from pydantic import ConfigDict

# It evaluates the annotations below when a model file is read or written, and loads only then.
pydantic = lazy_loader.load("pydantic")

# Shares of the states for which PSDM (Lloyd, Irani, Ahmadi 2021) states its error of the norm.
USUAL_STATES = (0.95, 0.999)
# Of a bound: what this process has shown, and what a file claims and nobody has proven or measured again.
PROVEN, STATED = "proven", "stated in the file"
# Of a class that is written to model files as it is: other keys are refused.
_AS_WRITTEN: ConfigDict = {"extra": "forbid", "allow_inf_nan": False}
# Levels that a budget may lie below, and the entry that accounts for each.
_TAKEN_INTO_ACCOUNT = {"friction": Allowance(0.1, "friction"), "uncertainty": Allowance(1.0, "uncertainty")}


def _numbers(value: Any) -> FloatArray:
    """An array, also from nested lists of a file; a ValueError unless all are finite numbers."""
    array = np.array(value)
    if array.dtype.kind not in "if" or not np.isfinite(array).all():
        raise ValueError("expected finite numbers, and rows of one length")
    return array.astype(float)


def _sizes(value: Any) -> FloatArray:
    """An array of numbers of 0 or more."""
    array = _numbers(value)
    if (array < 0.0).any():
        raise ValueError("expected numbers of 0 or more")
    return array


def _of_states(described: Mapping[str, str | int]) -> Mapping[str, str | int]:
    """Names of states, as `States.described` has them."""
    kinds = {name: type(value) for name, value in described.items() if name != "motions"}
    if kinds not in _DESCRIBED:
        raise ValueError("expected set points of a trajectory, or states drawn from a box")
    return described


_DESCRIBED: tuple[dict[str, type], ...] = (
    {"trajectory": str, "trajectory_fingerprint": str, "set_points": int},
    {"box": str, "states": int, "seed": int},
    {},
)


class _InFiles(NamedTuple):
    """How a value is read from a model file, and how it is written there."""

    read: Callable[[Any], Any]
    write: Callable[[Any], Any]

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """What pydantic asks of an annotation."""
        from pydantic_core import core_schema

        written = core_schema.plain_serializer_function_ser_schema(self.write)
        return core_schema.no_info_plain_validator_function(self.read, serialization=written)


Numbers = Annotated[FloatArray, _InFiles(_numbers, np.ndarray.tolist)]
Sizes = Annotated[FloatArray, _InFiles(_sizes, np.ndarray.tolist)]


def _by_joint(value: Any) -> FloatArray:
    """An array of a number each, or of nan for a joint without, which is null in a file."""
    array = np.array([np.nan if entry is None else float(_numbers(entry)) for entry in value])
    if array.ndim != 1:
        raise ValueError("expected a number or null of each joint")
    return array


ByJoint = Annotated[
    FloatArray,
    _InFiles(_by_joint, lambda array: [x if math.isfinite(x) else None for x in array.tolist()]),
]


def _share(value: Any) -> float:
    """A share of 0 or more; in a file null stands for infinity, which JSON has no number for."""
    return math.inf if value is None else float(_sizes(float(value)))


_Share = Annotated[float, _InFiles(_share, lambda share: share if math.isfinite(share) else None)]


@dataclass(frozen=True, eq=False)
class ErrorTable:
    """Torque error of a model over given states, per joint; N m (N for a prismatic joint), shape (n,)."""

    __pydantic_config__: ClassVar[ConfigDict] = _AS_WRITTEN

    peak_torque: Sizes  # largest magnitude of the exact torque
    largest: Sizes
    rms: Sizes
    # Largest error times `States.weights`; None for equal weights
    weighed: Annotated[Sizes | None, pydantic.Field(exclude=True)] = None

    @classmethod
    def of(
        cls, exact: FloatArray, model: FloatArray, explained: float = 0.0, weights: FloatArray | None = None
    ) -> ErrorTable:
        """Compare torques of shape (N, n); an error of only round-off, see `round_off_of`, is zero."""
        error = model - exact
        error[np.abs(error) <= round_off_of(exact, explained)] = 0.0
        size, rms = np.abs(error), np.sqrt(np.mean(error**2, axis=0))
        weighed = None if weights is None else (size * weights).max(axis=0)
        return cls(peak_magnitude(exact, explained), size.max(axis=0), rms, weighed)

    @property
    def counting(self) -> FloatArray:
        """Largest weighted error, to be compared with the budget, N m, shape (n,)."""
        return self.largest if self.weighed is None else self.weighed

    @property
    def largest_share(self) -> FloatArray:
        """Largest error over peak torque; 0 without error, infinite for an error without torque."""
        return share_of(self.largest, self.peak_torque)

    @property
    def rms_share(self) -> FloatArray:
        """RMS error over peak torque."""
        return share_of(self.rms, self.peak_torque)

    @property
    def worst(self) -> int:
        """The joint, from 0, with the largest error relative to its peak torque."""
        return int(self.largest_share.argmax())


def share_of(error: FloatArray, peak: FloatArray) -> FloatArray:
    """Error over peak torque; 0 without error, infinite for an error without torque."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(error == 0.0, 0.0, error / peak)


@dataclass(frozen=True, eq=False)
class AlongMotion:
    """Accuracy along one of several motions; a joint without torque there is allowed the error over all."""

    __pydantic_config__: ClassVar[ConfigDict] = _AS_WRITTEN

    name: str
    fingerprint: str
    set_points: int
    allowed: Sizes
    errors: ErrorTable
    uncertainty: Sizes | None = None


class NormShare(NamedTuple):
    """Norm of the torque error over that of the torque, of all joints together, at a share of the states."""

    share: _Share  # largest there; infinite for an error without torque
    # Share of the states, those of the smallest errors; 1 for all
    states: Annotated[float, pydantic.Field(gt=0.0, le=1.0)] = 1.0


def norms_by_kind(torque: FloatArray, revolute: Sequence[bool]) -> FloatArray:
    """Norm of the torque (N, n) of the revolute joints, and of the prismatic ones, shape (1 or 2, N)."""
    kinds = np.array(revolute)
    return np.array(
        [np.linalg.norm(torque[:, kinds == kind], axis=1) for kind in (True, False) if kind in revolute]
    )


def norm_shares(
    error: FloatArray, torque: FloatArray, revolute: Sequence[bool], round_off: float = 0.0
) -> FloatArray:
    """Norm of the error (N, n) over that of the torque at every state (N,), of the worse kind of joint.

    Errors up to `round_off`, N m (N), count as none; an error without torque has an infinite share.
    """
    counting = np.where(np.abs(error) <= round_off, 0.0, error)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = norms_by_kind(counting, revolute) / norms_by_kind(torque, revolute)
    return np.where(np.isnan(shares), 0.0, shares).max(axis=0)


def kept_states(share: float, count: int) -> int:
    """Least number of states that make a share of `count`: 95 % of 4000 are 3800."""
    # 0.95 and products with it are rounded: a number that is whole up to rounding is whole.
    return min(math.ceil(round(share * count, 6)), count)


def share_at(shares: FloatArray, states: float) -> float:
    """Smallest share of the norm that this share of the states keeps, from shares (N,)."""
    last = kept_states(states, len(shares)) - 1
    return float(np.partition(shares, last)[last])


class SearchStep(NamedTuple):
    """One step of a search, and the operations of the model after it."""

    name: str
    operations: int


@dataclass(frozen=True, eq=False)
class Proven:
    """A bound on the torque error in a box, or in a tube around a motion."""

    __pydantic_config__: ClassVar[ConfigDict] = _AS_WRITTEN

    certified: Sizes  # no state has a larger torque error, N m (N), shape (n,)
    # The box, or the smallest one around the tube, SI, shape (n,)
    lower: Numbers
    upper: Numbers
    velocity: Sizes
    acceleration: Sizes
    effort: Annotated[int, pydantic.Field(ge=1)]  # as for `certify`
    # Name of the states, which follows from these numbers
    where: Annotated[str, pydantic.Field(exclude=True)] = ""
    margin: str = ""  # of a tube, as read by `Margin.parse`, and the motion's fingerprint
    trajectory_fingerprint: str = ""
    # Of a tube: its piece with the largest bound of each joint, (n, 2, 3, n): lower, upper; q, qd, qdd
    pieces: Numbers | None = None
    # Whether this process has proven it; otherwise a file states it
    proven_here: Annotated[bool, pydantic.Field(exclude=True)] = False


@dataclass(frozen=True, eq=False)
class AgainstLog:
    """What a log says of a model, by joint: N m (N for a prismatic joint), shape (n,); nan without readings.

    Differences are measured torque less that of model and friction, with friction fitted to them.
    """

    __pydantic_config__: ClassVar[ConfigDict] = _AS_WRITTEN

    name: str
    fingerprint: str  # of motion and torques
    read_with: str  # options that correct the log's numbers; "" for none
    readings: int
    rms_exact: ByJoint  # RMS of the exact model's differences
    rms: ByJoint  # RMS of its own
    below_95: ByJoint  # 95 % of its differences are below this
    coulomb: ByJoint  # friction and offset fitted to its differences, N m, N m s and N m (N, N s/m, N)
    viscous: ByJoint
    offset: ByJoint
    left: ByJoint | None = None  # RMS left where links are fitted, too; a reference of budgets
    growth: ByJoint | None = None  # RMS on samples not fitted over that of the exact model there
    contradicted: tuple[int, ...] = ()  # joints, from 1, of which the log says that the file is wrong
    remedy: str = ""  # command that mends it


@dataclass(frozen=True, eq=False)
class Accuracy:
    """Accuracy that a model states, here and in its file."""

    __pydantic_config__: ClassVar[ConfigDict] = _AS_WRITTEN

    allowed: Sizes  # (n,), N m, as the budget comes to
    budget: str  # as written by the user
    errors: ErrorTable  # over the states it was fitted on: sampled, not a bound elsewhere
    # Those states, see `States.described`
    fitted_on: Annotated[Mapping[str, str | int], pydantic.AfterValidator(_of_states)]
    steps: tuple[SearchStep, ...] = ()  # the steps of the search
    # Errors were measured here; otherwise a file states them
    measured: Annotated[bool, pydantic.Field(exclude=True)] = True
    uncertainty: Sizes | None = None  # (n,), largest standard uncertainty of the torque, if stated
    motions: tuple[AlongMotion, ...] = ()  # if it was fitted on several
    norms: tuple[NormShare, ...] = ()  # at `USUAL_STATES`
    certificate: Proven | None = None  # what is proven, if anything
    # Largest |eigenvalue of D^-1 Ds - I| at the states of the errors and, over a region, at others.
    gamma: Annotated[float, pydantic.Field(ge=0.0)] | None = None
    log: AgainstLog | None = None  # if torques were measured along the motion

    def references(self, arm: RobotArm) -> ReferenceTorques:
        """References of its budget's shares."""
        left = None if self.log is None else self.log.left
        return ReferenceTorques(arm, self.errors.peak_torque, self.uncertainty, left)

    def along(self, fingerprint: str) -> Accuracy:
        """Accuracy along one of several motions, by its fingerprint; itself for any other."""
        for motion in self.motions:
            if motion.fingerprint == fingerprint:
                fitted_on: dict[str, str | int] = {
                    "trajectory": motion.name,
                    "trajectory_fingerprint": motion.fingerprint,
                    "set_points": motion.set_points,
                }
                accuracy = replace(
                    self, allowed=motion.allowed, errors=motion.errors, uncertainty=motion.uncertainty
                )
                return replace(accuracy, fitted_on=fitted_on, motions=(), norms=())
        return self

    @property
    def command_to_check(self) -> str:
        """What proves a stated certificate again."""
        is_near_motion = self.certificate is not None and self.certificate.trajectory_fingerprint
        return f"gd-analyze certify MODEL --check{' --along TRAJECTORY' if is_near_motion else ''}"

    @property
    def asked(self) -> Budget:
        """The parsed budget."""
        return Budget.parse(self.budget)

    @property
    def shares(self) -> FloatArray:
        """Largest errors as shares of peak torque or of the budget, see `Budget.shares_of`, shape (n,)."""
        return self.shares_of(self.errors.largest)

    def shares_of(self, error: FloatArray) -> FloatArray:
        """Any errors of the joints, N m, as the same shares, shape (n,)."""
        return share_of(error, self.whole)

    @property
    def whole(self) -> FloatArray:
        """Reference of the shares, N m, shape (n,)."""
        return self.errors.peak_torque if self.asked.shares_of == "peak torque" else self.allowed

    @property
    def search(self) -> str:
        """The steps and their operations in a line."""
        return ", ".join(f"{step.name} {step.operations}" for step in self.steps)


def budget_notice(arm: RobotArm, accuracy: Accuracy) -> str:
    """Joints whose budget is below friction or uncertainty, and a budget that accounts for it; "" if none."""
    by = accuracy.references(arm)
    entries = list(accuracy.asked.of_joints(arm.n_joints))
    # A log's budget accounts for both: it allows what the log would not show.
    accounted = {*_TAKEN_INTO_ACCOUNT, "log"}
    is_open = np.array([accounted.isdisjoint(of for _, of in entry) for entry in entries])
    clauses = []
    for name, allowance in _TAKEN_INTO_ACCOUNT.items():
        level = by.all(name)
        exceeded = is_open & (accuracy.allowed < level)
        if not exceeded.any():
            continue
        joint = int(np.argmin(np.where(exceeded, accuracy.allowed / level, np.inf)))
        unit = arm.joints[joint].effort_unit
        joints = named_joints((1 + np.flatnonzero(exceeded)).tolist(), arm.n_joints)
        clauses.append(
            f"below the {name} at {joints} (joint "
            f"{joint + 1}: {amount(accuracy.allowed[joint], unit)}, {name} {amount(level[joint], unit)})"
        )
        # One entry for all joints is shorter, if they all state it.
        alike = len(set(entries)) == 1 and is_open.all() and np.isfinite(level).all()
        wider = is_open if alike else exceeded
        entries = [(*entry, allowance) if w else entry for entry, w in zip(entries, wider, strict=True)]
        is_open &= ~wider
    if not clauses:
        return ""
    advised = Budget(tuple(entries[:1] if len(set(entries)) == 1 else entries))
    return f'Budget {" and ".join(clauses)}; --budget "{advised}" accounts for it.'


FEEDFORWARD_ONLY = "feedforward only"
# Gamma of an exact D: round-off times the condition number of D, up to 1e5.
_NO_GAMMA = 1e-9
# Gamma above which a mass matrix is not called close to the exact one.
_COARSE_GAMMA = 0.3


def gamma_size(gamma: float | None) -> str:
    """The figure alone, of which round-off is none."""
    if gamma is None:
        return "unknown"
    return percent(gamma) if gamma > _NO_GAMMA else "0 up to round-off"


def gamma_words(gamma: float) -> str:
    """How far the mass matrix is off, and what it is fit for."""
    if gamma <= _NO_GAMMA:
        return "equal to the exact one up to round-off: safe for feedback"
    if gamma >= 1.0:
        return f"up to {gamma_size(gamma)} off the exact one: {FEEDFORWARD_ONLY}"
    if gamma > _COARSE_GAMMA:
        return f"up to {gamma_size(gamma)} off the exact one where it was tried, and positive definite there"
    return f"within {gamma_size(gamma).removeprefix('< ')} of the exact one: safe for feedback"
