"""Logs in Parquet files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from log_arms import arm_of

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.read import read_log

pa = pytest.importorskip("pyarrow", reason="Parquet needs the extra `logs`")
parquet = pytest.importorskip("pyarrow.parquet", reason="Parquet needs the extra `logs`")

TWO = arm_of("hip", "knee")
START = 1_700_000_000_000_000_000


def written(path: Path, columns: dict[str, object], **how: object) -> Path:
    parquet.write_table(pa.table(columns), path, **how)
    return path


def test_columns_of_numbers(tmp_path: Path) -> None:
    path = written(
        tmp_path / "log.parquet",
        {
            "mode": ["auto"] * 5,
            "stamp": pa.array([START + k * 8_000_001 for k in range(5)], pa.int64()),
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
    assert logged.columns[0].why == "no quantity of the joints' motion"


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
def test_instants_that_say_what_they_are(unit: str, tmp_path: Path) -> None:
    instants = np.array([START + 10**9 * k for k in range(3)], "datetime64[ns]").astype(f"datetime64[{unit}]")
    path = written(tmp_path / "log.pq", {"time": instants, "q_0": [1.0, 2.0, 3.0], "q_1": [4.0, 5.0, 6.0]})
    np.testing.assert_array_equal(read_log(path, TWO).time, [0, 1, 2])


def test_numbers_too_large(tmp_path: Path) -> None:
    path = written(tmp_path / "log.parquet", {"time": [0.0, 0.1], "q_0": [1.0, np.inf], "q_1": [1.0, 2.0]})
    with pytest.raises(TrajectoryError, match="q_0 is too large") as caught:
        read_log(path, TWO)
    assert "log.parquet, line 2, column 2" in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"PAR1", b"PAR1" + b"x" * 50 + b"PAR1"])
def test_damaged_files(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    path.write_bytes(content)
    with pytest.raises(TrajectoryError, match="cannot be read as Parquet") as caught:
        read_log(path, TWO)
    assert str(path) in str(caught.value)
