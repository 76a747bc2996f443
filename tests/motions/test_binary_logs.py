"""Bags of ROS 1 and ROS 2, and Parquet files, written by the libraries that read them."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gd_analyze import read_log
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError
from gd_analyze.types import Reading
from log_arms import arm_of

pytest.importorskip("rosbags", reason="bags need the extra `logs`")
pytest.importorskip("pyarrow", reason="Parquet needs the extra `logs`")

import pyarrow as pa
import pyarrow.parquet as parquet
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

TWO = arm_of("hip", "knee")
STEP = 8_000_000
START = 1_700_000_000


def header(store: Any, k: int, **ros1: int) -> Any:
    stamp = store.types["builtin_interfaces/msg/Time"](sec=START, nanosec=k * STEP)
    return store.types["std_msgs/msg/Header"](stamp=stamp, frame_id="", **ros1)


def state(store: Any, k: int, **ros1: int) -> Any:
    return store.types["sensor_msgs/msg/JointState"](
        header=header(store, k, **ros1),
        name=["knee", "hip"],
        position=np.array([0.1 * k, 1.0]),
        velocity=np.array([2.0, 3.0]),
        effort=np.array([4.0, 5.0]),
    )


def bag2(path: Path, messages: dict[str, list[Any]], store: Any, plugin: Any = StoragePlugin.SQLITE3) -> Path:
    with Writer2(path, version=9, storage_plugin=plugin) as writer:
        for topic, sent in messages.items():
            kind = sent[0].__msgtype__
            connection = writer.add_connection(topic, kind, typestore=store)
            for k, message in enumerate(sent):
                writer.write(connection, START * 10**9 + k * STEP, store.serialize_cdr(message, kind))
    return path


@pytest.fixture
def store() -> Any:
    return get_typestore(Stores.ROS2_HUMBLE)


def assert_states(path: Path, **asked: Any) -> None:
    logged = read_log(path, TWO, Reading.of(**asked))
    np.testing.assert_array_equal(logged.q, [[1.0, 0.1 * k] for k in range(5)])
    np.testing.assert_array_equal(logged.qd, [[3, 2]] * 5)
    np.testing.assert_array_equal(logged.torque, [[5, 4]] * 5)
    np.testing.assert_allclose(logged.time, 0.008 * np.arange(5), rtol=1e-15)
    assert logged.measured


@pytest.mark.parametrize("plugin", StoragePlugin, ids=lambda plugin: plugin.name)
def test_a_bag_and_its_file_by_itself(plugin, tmp_path, store):
    folder = bag2(tmp_path / "run", {"/joint_states": [state(store, k) for k in range(5)]}, store, plugin)
    assert_states(folder)
    suffix = {"SQLITE3": ".db3", "MCAP": ".mcap"}[plugin.name]
    alone = tmp_path / f"alone{suffix}"
    next(folder.glob(f"*{suffix}")).rename(alone)
    assert_states(alone)


def test_ros_1(tmp_path):
    store = get_typestore(Stores.ROS1_NOETIC)
    path = tmp_path / "run.bag"
    with Writer1(path) as writer:
        connection = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        for k in range(5):
            data = store.serialize_ros1(state(store, k, seq=k), "sensor_msgs/msg/JointState")
            writer.write(connection, START * 10**9 + k * STEP, data)
    assert_states(path)


def test_commanded_states_are_a_plan(tmp_path, store):
    sent = {"/joint_command": [state(store, k) for k in range(5)]}
    assert not read_log(bag2(tmp_path / "run", sent, store), TWO).measured


def test_dynamic_states(tmp_path, store):
    store.register(
        get_types_from_msg("string[] interface_names\nfloat64[] values", "control_msgs/msg/InterfaceValue")
        | get_types_from_msg(
            "std_msgs/Header header\nstring[] joint_names\ncontrol_msgs/InterfaceValue[] interface_values",
            "control_msgs/msg/DynamicJointState",
        )
    )
    value, message = (store.types[f"control_msgs/msg/{of}"] for of in ("InterfaceValue", "DynamicJointState"))
    sent = [
        message(
            header=header(store, k),
            joint_names=["knee", "hip"],
            interface_values=[
                value(interface_names=["effort", "position"], values=np.array([7.0, float(k)])),
                value(interface_names=["position"], values=np.array([3.0])),
            ],
        )
        for k in range(3)
    ]
    with pytest.warns(GdAnalyzeWarning, match="no torques are read: knee/effort .* none is of hip"):
        logged = read_log(bag2(tmp_path / "run", {"/dynamic_joint_states": sent}, store), TWO)
    np.testing.assert_array_equal(logged.q, [[3, 0], [3, 1], [3, 2]])
    assert logged.torque is None  # of the knee alone


def test_topics(tmp_path, store):
    states, text = [state(store, k) for k in range(5)], store.types["std_msgs/msg/String"](data="hello")
    two = bag2(tmp_path / "two", {"/joint_states": states, "/left": states[:1]}, store)
    none = bag2(tmp_path / "none", {"/chatter": [text]}, store)
    listed = "/joint_states (JointState, 5 messages); /left (JointState, 1 messages)"
    for path, topic, found in ((two, None, listed), (two, "/tf", listed), (none, None, "/chatter (String")):
        with pytest.raises(TrajectoryError) as caught:
            read_log(path, TWO, Reading(topic=topic))
        assert found in caught.value.details["found"]
    assert_states(two, topic="/joint_states")


@pytest.mark.parametrize("suffix", [".db3", ".mcap", ".bag", ".parquet"])
def test_damaged_files(suffix, tmp_path):
    path = tmp_path / f"run{suffix}"
    beginnings = (b"SQLite format 3\0" + b"x" * 99, b"\x89MCAP0\r\n", b"#ROSBAG V2.0\n" + b"\0" * 50)
    for content in (b"", *beginnings, b"PAR1", b"PAR1" + b"x" * 50 + b"PAR1"):
        path.write_bytes(content)
        with pytest.raises(TrajectoryError, match="cannot be read") as caught:
            read_log(path, TWO)
        assert str(path) in str(caught.value)


def test_without_the_library(tmp_path, monkeypatch):
    for name, module in (("a.mcap", "rosbags.highlevel"), ("a.parquet", "pyarrow")):
        (tmp_path / name).write_bytes(b"")
        monkeypatch.setitem(sys.modules, module, None)
        library = module.partition(".")[0]
        with pytest.raises(TrajectoryError, match=f"needs the library {library}") as caught:
            read_log(tmp_path / name, TWO)
        assert f"next: pip install {library}" in str(caught.value)


def written(path: Path, columns: dict[str, object], **how: object) -> Path:
    parquet.write_table(pa.table(columns), path, **how)
    return path


def test_columns_of_numbers(tmp_path):
    path = written(
        tmp_path / "log.parquet",
        {
            "mode": ["auto"] * 5,
            "stamp": pa.array([START * 10**9 + k * 8_000_001 for k in range(5)], pa.int64()),
            "knee_deg": pa.array([0.0, 90.0, None, 180.0, 0.0]),
            "hip_deg": pa.array([90] * 5, pa.int32()),
            "hip_effort": pa.array([1.5] * 5, pa.float32()),
            "knee_effort": pa.array([2.5] * 5, pa.float32()),
        },
        row_group_size=2,
    )
    logged = read_log(path, TWO)
    np.testing.assert_allclose(logged.time, 8.000001e-3 * np.arange(5), rtol=1e-15)
    np.testing.assert_allclose(logged.q[:, 1], np.pi * np.array([0, 0.5, np.nan, 1, 0]), rtol=1e-15)
    np.testing.assert_array_equal(logged.torque, [[1.5, 2.5]] * 5)
    assert logged.columns[0].role == "unused"
    assert "motion" in logged.columns[0].why


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
def test_instants_that_say_what_they_are(unit, tmp_path):
    instants = np.array([START, START + 1, START + 2], "datetime64[s]").astype(f"datetime64[{unit}]")
    path = written(tmp_path / "log.pq", {"time": instants, "q_0": [1.0, 2.0, 3.0], "q_1": [4.0, 5.0, 6.0]})
    np.testing.assert_array_equal(read_log(path, TWO).time, [0, 1, 2])


def test_stamps_beyond_64_bits_with_a_sign(tmp_path):
    time = np.array([2**63, 2**63 + 1], dtype=np.uint64)
    path = written(tmp_path / "log.parquet", {"time": time, "q_0": [1.0, 1.0], "q_1": [1.0, 2.0]})
    with pytest.raises(TrajectoryError, match=r"log\.parquet"):
        read_log(path, TWO)


def test_numbers_too_large(tmp_path):
    path = written(tmp_path / "log.parquet", {"time": [0.0, 0.1], "q_0": [1.0, np.inf], "q_1": [1.0, 2.0]})
    with pytest.raises(TrajectoryError, match="q_0 is too large") as caught:
        read_log(path, TWO)
    assert caught.value.details["where"] == f"{path}, line 2, column 2"


def test_dates_as_text(tmp_path):
    stamps = ["2025-03-04T10:20:30.000Z", "2025-03-04T10:20:30.016Z", None]
    columns = {"datetime": stamps, "note": ["a", "b", "c"], "q_0": [0.1, 0.2, 0.3], "q_1": [1.0, 2.0, 3.0]}
    logged = read_log(written(tmp_path / "log.parquet", columns), TWO)
    np.testing.assert_allclose(logged.time, [0.0, 0.016], rtol=1e-15)
    columns["datetime"] = [*stamps[:2], "soon"]
    with pytest.raises(TrajectoryError, match="soon"):
        read_log(written(tmp_path / "log.parquet", columns), TWO)
