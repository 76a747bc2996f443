"""Logs of arrays and lists: the numbers that come out, and what is refused without being executed."""

from __future__ import annotations

import json
import os

import h5py
import numpy as np
import pytest
import scipy.io

from gd_analyze import read_log
from gd_analyze.errors import TrajectoryError
from gd_analyze.types import Reading
from log_arms import UR, arm_of

ARM = arm_of(*UR)
TIME = 0.01 * np.arange(20)
Q = np.sin(TIME[:, None] + np.arange(6))
ROWS = [{"time": t, "q": q} for t, q in zip(TIME.tolist(), Q.tolist(), strict=True)]
ORDER = [2, 0, 1, 5, 4, 3]


def hdf5(path):
    with h5py.File(path, "w") as file:  # MATLAB's version 7.3, which stores columns as rows
        file["t"], file["log/q"] = TIME[None], Q.T


def messages():
    names, stamps = [UR[k] for k in ORDER], np.rint(1e9 * TIME).astype(int).tolist()
    for stamp, q in zip(stamps, Q[:, ORDER].tolist(), strict=True):
        yield {"header": {"stamp": {"sec": 5, "nanosec": stamp}}, "name": names, "position": q}


FIELDS = np.rec.fromarrays([TIME, *Q.T], names=["time", *(f"q{k}" for k in range(1, 7))])
CELLS = [(t, " ".join(map(repr, q)), ", ".join(map(repr, q))) for t, q in zip(TIME.tolist(), Q.tolist())]  # noqa: B905
FILES = {
    "a.npz": lambda path: np.savez(path, time=TIME, q=Q, rate=100.0, note="x"),
    "transposed.npz": lambda path: np.savez(path, time=TIME[:, None], q=Q.T),
    "fields.npy": lambda path: np.save(path, FIELDS),
    "a.mat": lambda path: scipy.io.savemat(path, {"t": TIME, "log": {"q": Q}, "note": "x"}),
    "seven.mat": hdf5,
    "a.jsonl": lambda path: path.write_text("\n".join(map(json.dumps, ROWS))),
    "list.json": lambda path: path.write_text(json.dumps(ROWS, indent=1)),
    "arrays.json": lambda path: path.write_text(json.dumps({"t": TIME.tolist(), "q": Q.tolist()}, indent=1)),
    "messages.jsonl": lambda path: path.write_text("\n".join(map(json.dumps, messages()))),
    "blanks.csv": lambda path: path.write_text("t;q\n" + "".join(f"{t};[{q}]\n" for t, q, _ in CELLS)),
    "quotes.csv": lambda path: path.write_text("t,q\n" + "".join(f'{t},"[{q}]"\n' for t, _, q in CELLS)),
}


@pytest.mark.parametrize("name", FILES)
def test_read(name, tmp_path):
    FILES[name](tmp_path / name)
    logged = read_log(tmp_path / name, ARM)
    np.testing.assert_array_equal(logged.q, Q)
    # Stamps are subtracted from the first: an eps of their size.
    np.testing.assert_allclose(logged.time, TIME, rtol=0, atol=1e-15)


class Malicious:
    def __reduce__(self):
        return os.mkdir, ("executed",)


def test_nothing_is_executed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    objects = np.array([Malicious()] * 20, dtype=object)
    np.savez("a.npz", time=TIME, q=objects)
    np.save("a.npy", objects)
    for name in ("a.npz", "a.npy"):
        with pytest.raises(TrajectoryError) as caught:
            read_log(tmp_path / name, ARM)
        assert "Object arr" in caught.value.details["found"]
    assert not (tmp_path / "executed").exists()


def test_damaged_files_are_refused(tmp_path):
    for name in ("a.npz", "a.mat", "fields.npy", "seven.mat"):
        FILES[name](tmp_path / name)
        whole = (tmp_path / name).read_bytes()
        (tmp_path / name).write_bytes(whole[: len(whole) // 3])
        with pytest.raises(TrajectoryError, match=name):
            read_log(tmp_path / name, ARM)


@pytest.mark.parametrize("content", ["5", "[1, 2]", '{"time": 0}\n5\n{"time": 1}'])
def test_what_is_no_object_is_refused(content, tmp_path):
    (tmp_path / "a.jsonl").write_text(content)
    with pytest.raises(TrajectoryError, match=r"a\.jsonl"):
        read_log(tmp_path / "a.jsonl", ARM)


@pytest.mark.parametrize(
    ("name", "content", "advice"),
    [
        ("a.xlsx", b"PK\0", "pandas.read_excel("),
        ("a.csv", "time,q1\n0,1\n".encode("utf-16"), "iconv -f UTF-16 -t UTF-8 "),
    ],
)
def test_the_command_that_converts_is_named(name, content, advice, tmp_path):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(TrajectoryError) as caught:
        read_log(tmp_path / name, ARM)
    assert advice in caught.value.details["next"]


def test_a_matrix_without_names_is_converted_by_the_command_that_is_printed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.save("a.npy", np.column_stack([TIME, Q]))
    with pytest.raises(TrajectoryError) as caught:
        read_log("a.npy", ARM)
    exec(caught.value.details["next"].split('"')[1])
    logged = read_log("log.csv", ARM, Reading.of(["time=#1", "q=#2..#7"]))
    np.testing.assert_allclose(logged.q, Q, rtol=1e-15)
