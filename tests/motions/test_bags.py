"""Bags of ROS 1 and ROS 2, written by the library that reads them."""

from __future__ import annotations

import builtins
import importlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from log_arms import arm_of

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.read import read_log
from gd_analyze.motions.reading import Reading

pytest.importorskip("rosbags", reason="bags need the extra `logs`")

from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

TWO = arm_of("hip", "knee")
STEP = 8_000_000
START = 1_700_000_000


def header(store: Any, k: int, ros1: bool = False) -> Any:
    stamp = store.types["builtin_interfaces/msg/Time"](sec=START, nanosec=k * STEP)
    more = {"seq": k} if ros1 else {}
    return store.types["std_msgs/msg/Header"](stamp=stamp, frame_id="", **more)


def state(store: Any, k: int, ros1: bool = False) -> Any:
    return store.types["sensor_msgs/msg/JointState"](
        header=header(store, k, ros1),
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
def test_a_bag_and_its_file_by_itself(plugin: Any, tmp_path: Path, store: Any) -> None:
    folder = bag2(tmp_path / "run", {"/joint_states": [state(store, k) for k in range(5)]}, store, plugin)
    assert_states(folder)
    suffix = {"SQLITE3": ".db3", "MCAP": ".mcap"}[plugin.name]
    alone = tmp_path / f"alone{suffix}"
    next(folder.glob(f"*{suffix}")).rename(alone)
    assert_states(alone)


def test_ros_1(tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS1_NOETIC)
    path = tmp_path / "run.bag"
    with Writer1(path) as writer:
        connection = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        for k in range(5):
            data = store.serialize_ros1(state(store, k, ros1=True), "sensor_msgs/msg/JointState")
            writer.write(connection, START * 10**9 + k * STEP, data)
    assert_states(path)


def test_commanded_states_are_a_plan(tmp_path: Path, store: Any) -> None:
    sent = {"/joint_command": [state(store, k) for k in range(5)]}
    assert not read_log(bag2(tmp_path / "run", sent, store), TWO).measured


def test_dynamic_states(tmp_path: Path, store: Any) -> None:
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
    logged = read_log(bag2(tmp_path / "run", {"/dynamic_joint_states": sent}, store), TWO)
    np.testing.assert_array_equal(logged.q, [[3, 0], [3, 1], [3, 2]])
    assert logged.torque is None  # of the knee alone


def test_topics(tmp_path: Path, store: Any) -> None:
    states, text = [state(store, k) for k in range(5)], store.types["std_msgs/msg/String"](data="hello")
    two = bag2(tmp_path / "two", {"/joint_states": states, "/left": states[:1]}, store)
    none = bag2(tmp_path / "none", {"/chatter": [text]}, store)
    listed = "/joint_states (JointState, 5 messages); /left (JointState, 1 messages)"
    for path, topic, found in ((two, None, listed), (two, "/tf", listed), (none, None, "/chatter (String")):
        with pytest.raises(TrajectoryError) as caught:
            read_log(path, TWO, Reading(topic=topic))
        assert found in caught.value.details["found"]
    assert_states(two, topic="/joint_states")


@pytest.mark.parametrize("suffix", [".db3", ".mcap", ".bag"])
def test_damaged_bags(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"run{suffix}"
    for content in (b"", b"SQLite format 3\0" + b"x" * 99, b"\x89MCAP0\r\n", b"#ROSBAG V2.0\n" + b"\0" * 50):
        path.write_bytes(content)
        with pytest.raises(TrajectoryError, match="the bag cannot be read") as caught:
            read_log(path, TWO)
        assert str(path) in str(caught.value)


def test_without_the_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str, *rest: Any) -> Any:
        if name.startswith(("rosbags", "pyarrow")):
            raise ImportError(name)
        return importlib.__import__(name, *rest)

    monkeypatch.setattr(importlib, "import_module", missing)
    monkeypatch.setattr(builtins, "__import__", missing)
    for name, library in (("run.mcap", "rosbags"), ("run.parquet", "pyarrow")):
        (tmp_path / name).write_bytes(b"")
        with pytest.raises(TrajectoryError, match=f"needs the library {library}") as caught:
            read_log(tmp_path / name, TWO)
        assert f"next: pip install {library}" in str(caught.value)
