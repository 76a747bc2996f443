"""Results files: a valid one, and what is done to it by way of h5py and as bytes."""

from __future__ import annotations

import io
import json
import tempfile
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import h5py
import numpy as np
from changes import Change, Format, Plan, Stage, carried_out, cut
from hdf5_reader import Process
from hostile_values import NOT_FINITE, number, text
from tree_changes import TREE_CHANGES
from verdict import BrokenError

from gd_analyze import Trajectory, analyze, load_arm, read_trajectory
from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.results.store import SEAL_LENGTH, require_sealed, seal
from gd_analyze.tables import decompose_states, save_results, states_of
from recordings import with_torques

# Numbers that a dataset says it has, and that no memory holds.
HUGE = 2**40
# Attributes of netCDF's dimensions, which refer to other datasets.
OF_SCALES = {"CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST"}


@cache
def base() -> tuple[bytes, bytes]:
    """Results of some set points of two motions, with measured torques, and the seal behind them."""
    arm = load_arm("two_link")
    swing = read_trajectory("two-link-swing", arm)
    motions = []
    for name, rows in (("begin", slice(0, 12)), ("go on", slice(15, 27))):
        part = Trajectory(*(x[rows] for x in (swing.time, swing.q, swing.qd, swing.qdd)), name)
        measured = 1.5 * decompose_states(arm, states_of(part))["torque"] + np.sign(part.qd)
        motions.append(with_torques(part, measured))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "analysis.h5"
        with warnings.catch_warnings(action="ignore", category=GdAnalyzeWarning):  # they contradict the arm
            save_results(analyze(arm, motions, fit_friction=True), path)
        whole = path.read_bytes()
        require_sealed(path)
    return whole[:-SEAL_LENGTH], whole[-SEAL_LENGTH:]


def _edit(change: Callable[[Random, h5py.File], None]) -> Change:
    """A change of an open file as one of its bytes; what HDF5 itself refuses to do is not done."""

    def changed(random: Random, content: bytes) -> bytes:
        memory = io.BytesIO(content)
        with suppress(OSError, ValueError, TypeError, RuntimeError, LookupError, OverflowError):
            with h5py.File(memory, "r+") as file:
                change(random, file)
            return memory.getvalue()
        return content

    return changed


def _some(random: Random, file: h5py.File, kind: type = object) -> Any:
    """A group or dataset anywhere in a file, none that an earlier change made too large to be touched."""
    items: list[Any] = []
    file.visititems(lambda _, item: items.append(item) if isinstance(item, kind) else None)
    return random.choice([item for item in items if getattr(item, "size", None) != HUGE])


def _values(random: Random, file: h5py.File) -> None:
    """One entry of a dataset, or all."""
    dataset = _some(random, file, h5py.Dataset)
    place: Any = tuple(random.randrange(size) for size in dataset.shape if size)
    if random.randrange(4) == 0:
        place = ...
    if h5py.check_string_dtype(dataset.dtype):
        dataset[place] = text(random)
    else:
        with np.errstate(all="ignore"):
            value = np.float64(random.choice([number(random), random.choice(NOT_FINITE)]))
            dataset[place] = value.astype(dataset.dtype)


def _attribute(random: Random, file: h5py.File) -> None:
    """An attribute replaced, removed or added."""
    item = random.choice([file, _some(random, file)])
    name = random.choice([*item.attrs, text(random)])
    if name in item.attrs and random.randrange(4) == 0:
        del item.attrs[name]
    else:
        odd = [np.zeros(3), np.nan, h5py.Empty("f"), b"\xff\xfe", ["a", "b"], np.zeros((2, 0))]
        item.attrs[name] = random.choice([number(random), text(random), random.choice(odd)])


def _remove(random: Random, file: h5py.File) -> None:
    del file[_some(random, file).name]


def _rename(random: Random, file: h5py.File) -> None:
    item = _some(random, file)
    file.move(item.name, random.choice([text(random), f"{item.name}2", f"/{item.name.split('/')[-1]}"]))


def _made_again(file: h5py.File, old: h5py.Dataset, values: Any) -> None:
    """A dataset of other values in the place of one, stored and described in the same way."""
    how = {"chunks": True, "fletcher32": old.fletcher32} if np.size(values) and np.ndim(values) else {}
    described = {
        key: (old.attrs[key], old.attrs.get_id(key).dtype) for key in old.attrs if key not in OF_SCALES
    }
    name = old.name
    del file[name]
    new = file.create_dataset(name, data=values, **how)
    for key, (value, kind) in described.items():
        new.attrs.create(key, value, dtype=kind)


def _other_dataset(random: Random, file: h5py.File) -> None:
    """A dataset of another shape or kind in the place of one."""
    old = _some(random, file, h5py.Dataset)
    name, shape, values = old.name, old.shape, old[()]
    kind, rows = random.randrange(7), np.atleast_1d(values)
    if kind < 5:
        odd = [0.0, "text", np.zeros((0,)), np.zeros((2,) * 9), h5py.Empty("f")]
        dtype = random.choice(["c16", "f2", "i1", "u8", "S3", "bool"])
        compound = np.zeros(shape, [("a", "f8"), ("b", "i4")])
        datasets = (random.choice(odd), [*rows, *rows], rows[:-1], compound, np.zeros(shape, dtype))
        _made_again(file, old, datasets[kind])
        return
    del file[name]
    if kind == 5:
        file.create_dataset(name, (HUGE,), "f8", chunks=(1024,), fletcher32=True)
    else:
        file.create_dataset(name, shape, h5py.string_dtype())


def _link(random: Random, file: h5py.File) -> None:
    """A link in the place of an item: round in circles, to nothing, to another file."""
    name = _some(random, file).name
    del file[name]
    links = [h5py.SoftLink("/"), h5py.SoftLink(name), h5py.SoftLink("/none"), file["/"]]
    file[name] = random.choice([*links, h5py.ExternalLink("/etc/hostname", "/"), _some(random, file)])


def _is_document(name: str, item: Any) -> bool:
    in_bytes = isinstance(item, h5py.Dataset) and item.dtype in (np.int8, np.uint8)
    return name.startswith("documents/") and in_bytes


def _document(random: Random, file: h5py.File) -> None:
    """A change in one of the JSON documents."""
    documents: list[h5py.Dataset] = []
    file.visititems(lambda name, item: documents.append(item) if _is_document(name, item) else None)
    dataset = random.choice(documents)
    tree = json.loads(dataset[()].astype(np.uint8).tobytes())
    tree = TREE_CHANGES[random.choice(list(TREE_CHANGES))](random, tree)
    written = json.dumps(tree, default=lambda raw: raw.text).encode()
    _made_again(file, dataset, np.frombuffer(written, dtype=dataset.dtype))


def _flip(random: Random, content: bytes) -> bytes:
    """Some bits the other way round."""
    changed = bytearray(content)
    for _ in range(random.choice([1, 1, 4, 64])):
        if changed:
            changed[random.randrange(len(changed))] ^= 1 << random.randrange(8)
    return bytes(changed)


def _overwrite(random: Random, content: bytes) -> bytes:
    """A run of zeros, of ones, of noise, or of what stands elsewhere."""
    length, place = random.choice([1, 4, 8, 16, 64, 512, 4096]), random.randint(0, len(content))
    elsewhere = random.randint(0, len(content))
    copied = content[elsewhere : elsewhere + length]
    runs = [bytes(length), b"\xff" * length, random.randbytes(length), copied]
    return content[:place] + random.choice(runs) + content[place + length :]


def _tail(random: Random, content: bytes) -> bytes:
    return content + random.choice([bytes(8), bytes(4096), content])


EDITS = {
    "values": _values,
    "attribute": _attribute,
    "remove": _remove,
    "rename": _rename,
    "other dataset": _other_dataset,
    "link": _link,
    "document": _document,
}
PROCESS = Process()
STALE = "leave the digest"
STAGES = (
    Stage({name: _edit(change) for name, change in EDITS.items()}, bytes, weight=2),
    Stage({"flip": _flip, "overwrite": _overwrite}, bytes, weight=4),
    Stage({"cut": cut, "tail": _tail, STALE: lambda random, content: content}, bytes),
)


def write(plan: Plan, path: Path) -> None:
    """Write a results file changed as planned, mostly with the digest of what it now holds."""
    content, line = base()
    changed = carried_out(plan, content, STAGES)
    if STALE in dict(plan.steps):
        path.write_bytes(changed + line)
    else:
        path.write_bytes(changed)
        seal(path)


def judged(path: Path) -> bool:
    """Hold the property against a file, see `verdict.judge`."""
    answer = PROCESS.read(path)
    if "cause" in answer:
        raise BrokenError(*answer["cause"], answer["detail"])
    return answer["read"]


FORMAT = Format(1, STAGES, write, judged)
