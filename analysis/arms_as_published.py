"""Does it work for the arms that people own?

Takes every serial chain of one to eight joints out of the robots that two collections publish, example-robot-data and frax,
holds each against Pinocchio on the same file, does the main job to both reports, and writes
`arms_as_published.md` beside this file. It takes a quarter of an hour on two cores:

    pip install example-robot-data frax && python analysis/arms_as_published.py
"""

from __future__ import annotations

import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import numpy as np
import pinocchio as pin

import gd_analyze as gd
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.motions.planning import plan_motion
from gd_analyze.robots.description import fingerprint
from gd_analyze.simplification.exact import has_more_terms
from psdm_measure import made_with

# Where the installed packages have their files.
COLLECTIONS = {"example-robot-data": "cmeel.prefix/share/example-robot-data/robots", "frax": "frax/assets"}
MOST_JOINTS = 8
# Branches behind a link of no more joints than a finger has make that link a hand.
_FINGER = 3
# A link with as many branches as a hand has fingers is one, whatever comes behind it, unless it is the trunk.
_HAND = 5
_STATES = 200
# Seconds after which a chain is given up.
_PATIENCE = 120
# Torque terms up to which they are counted: those of eight general joints would not fit into memory.
_MOST_TERMS = 40_000


@dataclass(frozen=True)
class Chain:
    """A serial chain of a robot's file, by the links it leads from and to; None for the file's own base."""

    file: Path
    base: str | None
    tip: str | None
    n_joints: int

    @property
    def name(self) -> str:
        """File and tip, as a table has room for."""
        return f"{self.file.stem} to {self.tip}" if self.tip else self.file.stem


def files() -> list[Path]:
    """URDF files of the collections that are installed."""
    found: list[Path] = []
    for package, folder in COLLECTIONS.items():
        with suppress(PackageNotFoundError):
            found += sorted(Path(str(distribution(package).locate_file(folder))).rglob("*.urdf"))
    return found


def chains_of(file: Path) -> Iterator[Chain]:
    """Chains from the base, or of too many joints from the last branching that leaves few enough, to every hand and foot."""
    try:
        model = pin.buildModelFromUrdf(str(file))
    except ValueError:  # not even Pinocchio reads it: its line says what we say of it
        yield Chain(file, None, None, 0)
        return
    behind: list[list[int]] = [[] for _ in range(model.njoints)]
    for joint in range(1, model.njoints):
        behind[model.parents[joint]].append(joint)

    def depth(joint: int) -> int:
        return 1 + max(map(depth, behind[joint]), default=0)

    def ends(joint: int) -> Iterator[int]:
        several = [depth(other) for other in behind[joint]]
        if joint and (not several or (len(several) > 1 and max(several) <= _FINGER)):
            yield joint
            return
        if joint and len(several) >= _HAND:
            yield joint
        for other in behind[joint]:
            yield from ends(other)

    links = {
        frame.parentJoint: frame.name for frame in reversed(model.frames) if frame.type == pin.FrameType.BODY
    }
    for end in ends(0):
        path = [end]
        while model.parents[path[0]]:
            path.insert(0, model.parents[path[0]])
        base = None
        while len(path) > MOST_JOINTS:
            cut = next(
                (k for k in range(1, len(path)) if len(behind[path[k - 1]]) > 1), len(path) - MOST_JOINTS
            )
            base, path = links[path[cut - 1]], path[cut:]
        yield Chain(file, base, links[end], len(path))


@dataclass(frozen=True)
class Row:
    """What became of one chain; `refused` holds the first line of the error where it was refused."""

    chain: Chain
    terms: int = 0
    exact: int = 0
    simplified: int = 0
    seconds: float = 0.0
    difference: float = 0.0
    warnings: tuple[str, ...] = ()
    refused: str = ""


def motion_of(arm: gd.types.RobotArm) -> gd.Trajectory:
    """Through 70 % of each range, joints in turn up and down, as fast as the slowest can; half a turn where there is no range."""
    lower = np.where(np.isfinite(arm.limits("lower")), arm.limits("lower"), -np.pi / 2)
    upper = np.where(np.isfinite(arm.limits("upper")), arm.limits("upper"), np.pi / 2)
    middle, half = (upper + lower) / 2, np.minimum((upper - lower) / 2, np.pi)
    signs = np.where(np.arange(arm.n_joints) % 2, -1.0, 1.0)
    start, goal = middle - 0.7 * half * signs, middle + 0.7 * half * signs
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
        quick = plan_motion(arm, start, goal, 2.0, profile="quintic", allow_violations=True)
    stretch = max(1.0, 1.01 * (quick.limits.least_stretch or 1.0))
    return gd.plan(arm, start, goal, 2.0 * stretch, profile="quintic")


def reduced(chain: Chain) -> tuple[pin.Model, list[str]]:
    """Pinocchio's own model of a chain, every other joint held at zero, and the names of the chain's joints."""
    model = pin.buildModelFromUrdf(str(chain.file))
    links = {frame.name: frame.parentJoint for frame in model.frames if frame.type == pin.FrameType.BODY}
    path: list[int] = []
    joint = links[chain.tip]
    while joint and joint != (links[chain.base] if chain.base else 0):
        path.insert(0, joint)
        joint = model.parents[joint]
    held = [joint for joint in range(1, model.njoints) if joint not in path]
    for number, frame in enumerate(model.frames):  # two of one name are more than the reduction can take
        if frame.type != pin.FrameType.JOINT:
            frame.name += f" {number}"
    return pin.buildReducedModel(model, held, pin.neutral(model)), [model.names[joint] for joint in path]


def difference(chain: Chain, arm: gd.types.RobotArm) -> float:
    """Largest difference from Pinocchio's torque at random states, over what explains it.

    That is round-off, and that angles within 1e-5 rad of a right one are taken as right, lengths below a nanometre as none.
    What changes by d changes a coordinate behind it by d of its length at most; a coordinate passes n of them, a moment is of
    products of two, and an inertia is turned from both sides: 4 n d of the magnitudes of which round-off is 20 n eps.
    """
    model, names = reduced(chain)
    model.armature = np.zeros(model.nv)
    data = model.createData()
    n = arm.n_joints
    random = np.random.default_rng(1987)
    q, qd, qdd = (random.uniform(-1.0, 1.0, (_STATES, n)) * scale for scale in (np.pi, 2.0, 5.0))
    q[:, [not turns for turns in arm.is_revolute]] *= 0.1
    ours = gd.tables.decompose_states(arm, gd.types.States(q, qd, qdd), drives=False)["torque"]
    theirs = []
    for state in zip(q, qd, qdd, strict=True):
        position = np.zeros(model.nq)
        for value, joint in zip(state[0], map(model.getJointId, names), strict=True):
            place, size = model.joints[joint].idx_q, model.joints[joint].nq
            position[place : place + size] = [value] if size == 1 else [np.cos(value), np.sin(value)]
        theirs.append(pin.rnea(model, data, position, *state[1:]).copy())
    bound = round_off_bounds(arm, q, qd, qdd)["torque"] * (
        1 + changed(arm, model, names) / (5 * np.finfo(float).eps)
    )
    return float(np.abs(ours - np.array(theirs)).max()) / bound


def changed(arm: gd.types.RobotArm, model: pin.Model, names: Sequence[str]) -> float:
    """Largest change that reading made to a file's numbers: of a rotation, a length in m, an inertia over its largest entry."""
    changes = [0.0]
    for joint, link, name in zip(arm.joints, arm.links, names, strict=True):
        index = model.getJointId(name)
        placement, body = model.jointPlacements[index], model.inertias[index]
        largest = max(float(np.abs(body.inertia).max()), np.finfo(float).tiny)
        changes += [
            float(np.abs(joint.placement.rotation - placement.rotation).max()),
            float(np.abs(joint.placement.translation - placement.translation).max()),
            float(np.abs(link.com - body.lever).max()),
            float(np.abs(link.inertia_com - body.inertia).max()) / largest,
        ]
    return max(changes)


def row_of(chain: Chain) -> Row:
    """Try one chain."""
    began = resource.getrusage(resource.RUSAGE_SELF)
    with warnings.catch_warnings(record=True) as caught, tempfile.TemporaryDirectory() as folder:
        warnings.simplefilter("always")
        try:
            arm = gd.load_arm(chain.file, tip=chain.tip, base=chain.base)
            away = difference(chain, arm)
            findings = gd.analyze(arm, motion_of(arm), out=folder, at_set_points=True)
            form = gd.types.ExactDynamics.of(arm, findings.trajectory, drives=False).form
        except gd.GdAnalyzeError as error:
            return Row(chain, refused=error.what)
    ended = resource.getrusage(resource.RUSAGE_SELF)
    return Row(
        chain,
        terms=0 if has_more_terms(form, _MOST_TERMS) else len(form.torques),
        exact=findings.model.operations_full.total,
        simplified=findings.model.operations.total,
        seconds=ended.ru_utime - began.ru_utime,
        difference=away,
        warnings=tuple(str(item.message) for item in caught),
    )


def rows(chains: Sequence[Chain]) -> Iterator[Row]:
    """Try all chains, each in a process of its own, as many at a time as there are processors."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for row in pool.map(_row_apart, chains):
            print(row.chain.name, row.exact, row.simplified, f"{row.seconds:.1f} s", row.refused, flush=True)
            yield row


def _row_apart(chain: Chain) -> Row:
    words = [str(chain.file), chain.base or "", chain.tip or "", str(chain.n_joints)]
    command = [sys.executable, __file__, *words]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=_PATIENCE)
    except subprocess.TimeoutExpired:
        return Row(chain, refused=f"not refused, but stopped after {_PATIENCE} s")
    found = json.loads(done.stdout.splitlines()[-1])
    return Row(**found | {"chain": chain, "warnings": tuple(found["warnings"])})


def with_own_numbers(chains: Sequence[Chain]) -> dict[Chain, int]:
    """Chains that are not the same as one before but for names and limits, and how many others are the same."""
    first: dict[str, Chain] = {}
    alike: dict[Chain, int] = {}
    for chain in chains:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
            try:
                numbers = fingerprint(gd.load_arm(chain.file, tip=chain.tip, base=chain.base), drives=True)
            except gd.GdAnalyzeError:
                numbers = chain.name
        first.setdefault(numbers, chain)
        alike[first[numbers]] = alike.get(first[numbers], -1) + 1
    return alike


def report(found: Sequence[Row], alike: Mapping[Chain, int]) -> str:
    """Write what became of the chains that have numbers of their own."""
    refused = [row for row in found if row.refused]
    went = [row for row in found if not row.refused]
    worst = max(row.difference for row in went)
    seven = [row for row in went if row.chain.n_joints >= 7]
    saving = [row for row in went if row.simplified < row.exact]
    lines = [
        "# Does it work for the arms that people own?",
        "",
        made_with(),
        "",
        f"Every serial chain of one to {MOST_JOINTS} joints of {len({row.chain.file for row in found})} robots' files: "
        f"{len(found) + sum(alike.values())} chains, {len(found)} of them with numbers of their own, "
        f"{len(refused)} of these refused or given up.",
        "",
        f"- **Against Pinocchio**, which reads the same file and holds the other joints: torques at {_STATES} random states differ "
        f"by at most {worst:.2g} of what round-off and angles set to right angles explain.",
        f"- **The main job** wrote both reports for all others. At the set points of a motion "
        f"through most of its range, it found a model cheaper than exact for {len(saving)} of {len(went)} chains, and for "
        f"{sum(row.simplified < row.exact for row in seven)} of the {len(seven)} of seven and eight joints.",
        f"- **Seconds** are processor time of one run with an empty cache, at most {max(row.seconds for row in went):.0f}.",
        f"- **Warnings** were given for {sum(bool(row.warnings) for row in went)} arms; what they say is listed below.",
        "",
        "Written by `analysis/arms_as_published.py` from example-robot-data and frax as pip installs them.",
        "",
        "| arm | joints | terms | exact | model | seconds | warnings | the same numbers |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in went:
        lines.append(
            f"| {row.chain.name} | {row.chain.n_joints} | {row.terms or 'more'} | {row.exact} | {row.simplified} | {row.seconds:.1f} "
            f"| {len(row.warnings) or ''} | {alike[row.chain] or ''} |"
        )
    if refused:
        lines += ["", "## Refused or given up", "", "| arm | why |", "|---|---|"]
        lines += [f"| {row.chain.name} | {row.refused} |" for row in refused]
    lines += [
        "",
        "## What was warned of",
        "",
        "| warning, without its numbers and names | arms |",
        "|---|---|",
    ]
    kinds = Counter(kind for row in went for kind in {_kind(said) for said in row.warnings})
    lines += [f"| {kind} | {count} |" for kind, count in kinds.most_common()]
    return "\n".join(lines) + "\n"


def _kind(warning: str) -> str:
    """What a warning says of any arm: without its place, names and numbers."""
    said = re.sub(r"^(\S+\.urdf: |.*?, line \d+(, column \d+)?: )", "", warning)
    said = re.sub(r"\b(link|joint|arm) [\w./-]+", r"\1 ...", said)
    return re.sub(r"[-+]?\d[\d.e+-]*", "#", said).replace("|", " ")


def main() -> None:
    """Write the study, or try the one chain that is named; what other runs have kept is not used."""
    os.environ["GD_ANALYZE_CACHE"] = ""
    if len(sys.argv) > 1:
        file, base, tip, joints = sys.argv[1:]
        row = row_of(Chain(Path(file), base or None, tip or None, int(joints)))
        print(json.dumps({**vars(row), "chain": None}))
        return
    alike = with_own_numbers([chain for file in files() for chain in chains_of(file)])
    path = Path(__file__).with_suffix(".md")
    path.write_text(report(list(rows(list(alike))), alike), encoding="utf-8")
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
