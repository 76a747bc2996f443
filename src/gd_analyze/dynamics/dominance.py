"""Dominance and consequence of every element, ranked by torque.

Dominance is [FGL87]'s measure: the size of each part along the trajectory, and whether one part
alone represents the element. Consequence is the torque of element and parts as a share of the torque error
allowed. Consequence decides whether an element is negligible; dominance gives the verdict on any other. A
tiny element dominated by one effect matters less than a large mixed one, so the ranking is by torque.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations_with_replacement
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from gd_analyze.arguments import strict
from gd_analyze.arrays import Array, FloatArray, array_of, chunks, peak_magnitude, round_off_of
from gd_analyze.dynamics.decomposition import decompose
from gd_analyze.dynamics.verdicts import (
    effect_words,
    least_changes,
    negligible_torque,
    representing,
    verdict_words,
)
from gd_analyze.errors import UsageError
from gd_analyze.files import data_folder
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import GROUPS, require_table, table, unit_of
from gd_analyze.text import in_python, joined

if TYPE_CHECKING:
    import xarray as xr

    from gd_analyze.motions.pool import GivenMotions


@dataclass(frozen=True)
class Element:
    """One element of D (i <= j), h or c, or h_ijk (j <= k); joints count from 0, in its label from 1."""

    quantity: str
    i: int
    j: int | None = None
    k: int | None = None

    @property
    def label(self) -> str:
        """D12, h3, c2, h213."""
        return _SYMBOLS[self.quantity] + joined(self.index)

    @property
    def index(self) -> tuple[int, ...]:
        """Index in the quantity's array."""
        return tuple(joint for joint in (self.i, self.j, self.k) if joint is not None)

    @property
    def is_diagonal(self) -> bool:
        """Whether this is D_ii, to which drive i adds its inertia."""
        return self.k is None and self.i == self.j

    def parts(self, quantities: Mapping[Any, Any]) -> FloatArray:
        """Both parts of the element in arrays of `decompose`, (2, N); gravity is translation."""
        if self.quantity == "gravity_loading":
            values = np.asarray(quantities["gravity_loading"])[:, self.i]
            return np.stack([values, np.zeros_like(values)])
        index: Any = (slice(None), slice(None), *self.index)
        array: Array = np.asarray(quantities[self.quantity])[index]
        return array.T

    def torque_factors(self, quantities: Mapping[Any, Any]) -> dict[int, FloatArray]:
        """Factors (N,) that turn the element into its torque at each joint it acts on."""
        qdd = np.asarray(quantities["qdd"])
        if self.j is None:
            return {self.i: np.ones(len(qdd))}
        if self.k is None:
            return {self.i: qdd[:, self.j], self.j: qdd[:, self.i]}
        qd = np.asarray(quantities["qd"])
        # h_ijk and h_ikj are the same number.
        return {self.i: (1.0 + (self.j != self.k)) * qd[:, self.j] * qd[:, self.k]}


_SYMBOLS = {"inertia": "D", "coriolis_centrifugal": "h", "gravity_loading": "c", "christoffel": "h"}
# Kinds of unit by the number of joints in an element's index.
_UNITS = {1: "effort", 2: "inertia", 3: "christoffel"}


def elements(n_joints: int, *, christoffel: bool = False) -> tuple[Element, ...]:
    """Upper triangle of D, then h, then c, then h_ijk if asked for."""
    n = range(n_joints)
    pairs = list(combinations_with_replacement(n, 2))
    vectors = (Element(name, i) for name in ("coriolis_centrifugal", "gravity_loading") for i in n)
    coefficients = (Element("christoffel", i, *pair) for i in n for pair in pairs if christoffel)
    return (*(Element("inertia", *pair) for pair in pairs), *vectors, *coefficients)


DOMINANCE_THRESHOLD = 0.10
# Parts of an element by what makes them; the drive adds its constant inertia to the diagonal of D.
SOURCES = ("translation", "rotation", "drive")
DEFAULT_BUDGET = 0.01


@strict
def rank(
    dataset: xr.Dataset | RobotArm | str | Path,
    trajectory: GivenMotions | None = None,
    *,
    threshold: float = DOMINANCE_THRESHOLD,
    budget: float | FloatArray = DEFAULT_BUDGET,
    christoffel: bool = False,
    extremes: Extremes | None = None,
) -> xr.Dataset:
    """Rank the elements of D, h and c by their torque, and give the verdict on each.

    Torques of elements are those of the links, except where drives are named; shares are of the dataset's
    peak torque, drives included.

    Parameters
    ----------
    dataset, trajectory
        The result of `decompose`; or what it takes, an arm and its motion.
    threshold
        A part dominates when leaving the other out changes the element by at most this share of the
        element's peak magnitude; of two such parts, the larger.
    budget
        Torque error budget: a share of each joint's peak torque, or N m per joint, shape (n,). Joint i's row
        has n elements of D, one of h and one of c. An element is negligible if its torque, its drive's
        included, is at most budget / (n + 2) at every joint and set point, so that all negligible elements
        may be dropped together.
    christoffel
        Also rank every h_ijk of the dataset, the coefficients of h.
    extremes
        Extremes of the elements along a longer motion, if the dataset holds a selection of its set points,
        including those of the peak torques.

    Returns
    -------
    xarray.Dataset
        One entry per element along `element`, largest torque share first. `peak`, `rms` of the whole element
        and, along `effect`, `part_peak`, `part_rms` and `part_share` (the part's RMS among both parts'),
        `change_without` (largest change of the element without the part, over its peak), `torque_peak` (N m
        at joint `torque_joint`) and `torque_share` (of that joint's peak torque). `drive` is the drive's
        inertia, on the diagonal of D, with `drive_torque_peak` and `drive_torque_share`. `consequence` is the
        largest torque of the element, drive included, over the budget of the joint, `part_consequence` that
        of each part. `dominant` is "translation", "rotation", "both", or "zero" for links' parts that are
        zero. `verdict` is "zero", "negligible", "drive" if the links' parts are negligible but the element
        is not, "gravity" of elements of c, or else `dominant`.

    Raises
    ------
    UsageError
        If the dataset is no decomposition, the budget is neither a share nor one torque per joint, or h_ijk
        are asked for but missing.
    """
    if trajectory is not None or isinstance(dataset, RobotArm | str | Path):
        dataset = decompose(cast("RobotArm", dataset), trajectory)
    require_table(dataset, "decomposition", "decompose")
    if christoffel and "christoffel" not in dataset:
        raise UsageError(
            "there are no h_ijk to rank",
            where="christoffel",
            expected="a dataset of `decompose` with christoffel=True",
            found=f"a dataset of {', '.join(map(str, dataset.data_vars))}",
        )
    n = dataset.sizes["joint"]
    torque, explained = dataset.torque.values, float(dataset.attrs["torque_round_off"])
    peak_torque = peak_magnitude(torque, explained)
    # Without any torque to give, what elements make is round-off.
    no_torque = 0.0 if peak_torque.any() else round_off_of(torque, explained)
    allowed = _allowed_torque(budget, peak_torque)
    all_elements = elements(n, christoffel=christoffel)
    drive_inertia = np.asarray(dataset.attrs["drive_inertia"])
    if extremes is None:
        extremes = Extremes(n, all_elements, drive_inertia)
        for chunk in chunks(dataset.sizes["time"]):
            extremes.add({name: x.values for name, x in dataset[extremes.read].isel(time=chunk).items()})
    drive = np.array([drive_inertia[element.i] * element.is_diagonal for element in all_elements])
    limits = _RankingLimits(threshold, peak_torque, allowed, no_torque)
    columns = _names(all_elements) | _measures(extremes, all_elements, drive, limits)
    # An infinite share, at a joint where all torques cancel, ranks like the whole of a joint's torque.
    shares = columns["torque_share"]
    most = shares[np.isfinite(shares)].max(initial=1.0)
    order = np.argsort(-np.minimum(shares, most), kind="stable")
    columns = {key: values[order] for key, values in columns.items()}
    revolute = (dataset.joint_kind.values == "revolute").tolist()
    ranked = [all_elements[k] for k in order]
    units = [unit_of(_UNITS[len(element.index)], *(revolute[k] for k in element.index)) for element in ranked]
    torque_units = [unit_of("effort", revolute[k - 1]) for k in columns["torque_joint"]]
    return table(
        "dominance",
        {name: columns[name] for name in GROUPS["dominance"] if name != "k" or christoffel},
        revolute,
        {
            "element": [element.label for element in ranked],
            "effect": dataset.effect.values,
            "source": list(SOURCES),
            "unit": ("element", units),
            "torque_unit": ("element", torque_units),
        },
        {
            "threshold": float(threshold),
            "allowed": allowed.tolist(),
            "floor": limits.floor.tolist(),
            "no_torque": no_torque,
            "ranked_by": "torque_share",
            "arm": dataset.attrs["arm"],
            "trajectory": dataset.attrs["trajectory"],
        },
    )


@dataclass(frozen=True)
class _RankingLimits:
    """Numbers that verdicts are measured by; torques are of every joint, N m, shape (n,)."""

    threshold: float  # largest change of an element, over its peak, without a part that does not count
    peak_torque: FloatArray
    allowed: FloatArray  # torque error
    no_torque: float  # torque up to which what elements make is round-off, N m

    @property
    def floor(self) -> FloatArray:
        """Torque up to which an element is negligible."""
        return negligible_torque(self.allowed)


def _allowed_torque(budget: float | FloatArray, peak_torque: FloatArray) -> FloatArray:
    """Torque error allowed at every joint, (n,); UsageError unless the budget is a share or n torques."""
    values = np.array(np.nan) if isinstance(budget, str) else array_of(budget, "budget", UsageError)
    n = len(peak_torque)
    if values.shape not in ((), (n,)) or not (values >= 0.0).all():
        raise UsageError(
            "this is not a budget",
            where="budget",
            expected=f"a share of 0 or more, or {n} torques",
            found=in_python(budget) if isinstance(budget, str) else str(values.tolist()),
            next_step="0.01 is 1% of peak torque",
        )
    return values * peak_torque if values.ndim == 0 else values


def _names(all_elements: Sequence[Element]) -> dict[str, Array]:
    """Quantity and joints of every element; 0 where it has no such index."""
    return {
        "quantity": np.array([element.quantity for element in all_elements]),
        "i": np.array([element.i + 1 for element in all_elements]),
        "j": np.array([0 if element.j is None else element.j + 1 for element in all_elements]),
        "k": np.array([0 if element.k is None else element.k + 1 for element in all_elements]),
    }


def _measures(
    extremes: Extremes, all_elements: Sequence[Element], drive: FloatArray, limits: _RankingLimits
) -> dict[str, Array]:
    """Sizes, torques and verdicts of every element, in the columns of `rank`."""
    peaks = extremes.peaks
    largest = np.array([extremes.largest[element.quantity] for element in all_elements])
    least = least_changes(peaks[:, :2].T, peaks[:, 2], largest, limits.threshold)
    is_there = np.isfinite(least.T)
    rms = np.sqrt(extremes.squares / extremes.count)
    part_peak, part_rms = np.where(is_there, [peaks[:, :2], rms[:, :2]], 0.0)
    # The links' element is the sum of both parts, or the only one there is.
    links = np.arange(len(all_elements)), np.where(is_there.all(axis=1), 2, is_there.argmax(axis=1))
    exists, has_drive = np.asarray(is_there.any(axis=1)), drive > 0.0
    peak, acts = peaks[links] * exists, extremes.torques[..., 0] >= 0.0
    makes_torque = acts[..., None] & (extremes.torques > limits.no_torque)
    curve_torques = np.where(makes_torque, extremes.torques, 0.0).swapaxes(1, 2)
    torques = curve_torques[links] * exists[:, None]
    with_drive = np.where(exists[:, None], curve_torques[:, 4], curve_torques[:, 3])
    whole = np.where(has_drive[:, None], with_drive, torques)
    of_parts = curve_torques[:, [0, 1, 3]] * np.column_stack([is_there, has_drive])[..., None]
    shares = ratio(torques, limits.peak_torque)
    joint = links[0], np.where(acts, shares, -1.0).argmax(axis=1)
    dominant = effect_words(representing(part_peak.T, least))
    is_gravity = np.array([element.quantity == "gravity_loading" for element in all_elements])
    is_small, are_links_small = (np.asarray((x <= limits.floor).all(axis=1)) for x in (whole, torques))
    return {
        "peak": peak,
        "rms": rms[links] * exists,
        "part_peak": part_peak,
        "part_rms": part_rms,
        "part_share": ratio(part_rms, part_rms.sum(axis=1, keepdims=True)),
        "change_without": ratio(part_peak, peak[:, None]),
        "torque_peak": torques[joint],
        "torque_joint": joint[1] + 1,
        "torque_share": shares[joint],
        "drive": drive,
        "drive_torque_peak": of_parts[:, 2].max(axis=1),
        "drive_torque_share": ratio(of_parts[:, 2], limits.peak_torque).max(axis=1),
        "consequence": ratio(whole, limits.allowed).max(axis=1),
        "part_consequence": ratio(of_parts, limits.allowed).max(axis=2),
        "dominant": dominant,
        "verdict": verdict_words(dominant, ~exists & ~has_drive, is_small, are_links_small, is_gravity),
    }


class Extremes:
    """Extremes of elements along a motion, given block by block: translation, rotation and their sum.

    Of torques also the drive's, and that of all parts together.

    Parameters
    ----------
    n_joints, elements
        Number of joints, and the elements, E in number.
    drive_inertia
        Inertia of every drive, kg m^2 (kg), shape (n,); 0 where drives are not included.
    """

    def __init__(self, n_joints: int, elements: Sequence[Element], drive_inertia: FloatArray) -> None:
        self.elements, self.count, self.drive_inertia = elements, 0, drive_inertia
        # Largest magnitudes and sums of squares; largest torques, -1 at joints where an element does not act;
        # and the set points, from 0, where they occur.
        self.peaks, self.squares = np.zeros((2, len(elements), 3))
        self.torques = np.full((len(elements), n_joints, 5), -1.0)
        self.reached = np.zeros((len(elements), n_joints + 1, 5), dtype=np.intp)
        self.largest = dict.fromkeys((element.quantity for element in elements), 0.0)  # of a whole quantity
        self.read = [*self.largest, "qdd", *(["qd"] if "christoffel" in self.largest else [])]

    def add(self, block: Mapping[Any, Any]) -> None:
        """Add the next set points, as arrays of `decompose`."""
        for name in self.largest:
            self.largest[name] = max(self.largest[name], float(np.abs(block[name]).max()))
        for k, element in enumerate(self.elements):
            parts = element.parts(block)
            curves = np.vstack([parts, parts.sum(axis=0)])
            self._reach(self.peaks[k], self.reached[k, -1], curves)
            self.squares[k] += np.einsum("cn,cn->c", curves, curves)
            drive = self.drive_inertia[element.i]
            if element.is_diagonal and drive:
                curves = np.vstack([curves, np.full_like(curves[2], drive), curves[2] + drive])
            for joint, factor in element.torque_factors(block).items():
                self._reach(self.torques[k, joint], self.reached[k, joint], curves * factor)
        self.count += len(block["qdd"])

    def _reach(self, peaks: FloatArray, reached: Array, curves: FloatArray) -> None:
        size, peaks, reached = np.abs(curves), peaks[: len(curves)], reached[: len(curves)]
        at = size.argmax(axis=1)
        top = size[np.arange(len(at)), at]
        beyond = top > peaks
        peaks[beyond], reached[beyond] = top[beyond], self.count + at[beyond]


def ratio(values: FloatArray, whole: FloatArray) -> FloatArray:
    """Share of a whole: infinite if the whole is zero or nearly so, 0 if the value is zero."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.where(values == 0.0, 0.0, values / whole)


@dataclass(frozen=True)
class TextVerdicts:
    """Verdicts of a publication on an arm's elements."""

    source: str
    verdicts: dict[str, str]
    remarks: dict[str, str]


@cache
def text_verdicts(arm_name: str) -> TextVerdicts | None:
    """Verdicts read from Figs 3.10 and 3.11 of [FGL87]; None for an arm they do not show."""
    reference = tomllib.loads((data_folder("references") / "fgl87_figures.toml").read_text(encoding="utf-8"))
    if arm_name != reference["arm"]:
        return None
    named = {label: effect for effect, labels in reference["verdicts"].items() for label in labels}
    labels = [e.label for e in elements(6) if e.quantity != "gravity_loading"]
    return TextVerdicts(
        reference["source"],
        {label: named.get(label, reference["default"]) for label in labels},
        reference["remarks"],
    )
