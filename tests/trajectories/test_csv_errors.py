"""Every way a trajectory file can be wrong: the message says what, where and what to do next."""

from __future__ import annotations

import os
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions import csv_file as csv_file_module
from gd_analyze.motions.csv_file import read_trajectory
from gd_analyze.robots.arm import RobotArm

CsvFile = Callable[[str | bytes], Path]

Q_ROWS = [f"{k / 10},0.{k},0.2" for k in range(7)]
Q_FILE = "\n".join(["time,q1,q2", *Q_ROWS]) + "\n"
FULL_HEADER = "time,q1,q2,qd1,qd2,qdd1,qdd2"
FULL_FILE = f"{FULL_HEADER}\n0,1,2,0,0,0,0\n0.1,1,2,0,0,0,0\n"


def with_header(header: str) -> str:
    return Q_FILE.replace("time,q1,q2", header)


def with_row(number: int, row: str) -> str:
    """The positions file with its data row `number` (from 1, on line number + 1) replaced."""
    return "\n".join(["time,q1,q2", *Q_ROWS[: number - 1], row, *Q_ROWS[number:]]) + "\n"


CASES: dict[str, tuple[str | bytes, list[str]]] = {
    "empty": ("", ["is empty", "0 bytes", "time,q1,q2", "plan --help"]),
    "comments only": ("# a\n\n", ["is empty", "no data"]),
    "header only": ("# a\ntime,q1,q2\n", ["a header only", "line 2", "add the set points"]),
    "unknown column": (
        with_header("time,q1,forearm"),
        ["no position of joint elbow", "line 1", "shoulder, elbow", "q1; beside it time, forearm", "--map"],
    ),
    "unknown column after comments": (
        "# a\n\n" + with_header("time,q1,q2x"),
        ["no position of joint elbow", "line 3", "q2x"],
    ),
    "duplicate": (
        with_header("time,q1,q1"),
        ["column q1 is given twice", "line 1, column 3", "q1 in column 2", "remove one"],
    ),
    "duplicate in degrees": (with_header("time,q1,q1_deg"), ["q1_deg is given twice", "line 1, column 3"]),
    "duplicate time": (with_header("time,time,q1"), ["column time is given twice", "line 1, column 2"]),
    "no time": (with_header("q1,q2,qd1"), ["column time is missing", "line 1", "in s"]),
    "no q": (with_header("time,qd1,qd2"), ["column q1 is missing", "no q column", "time,q1,q2"]),
    "q2 missing": (with_header("time,q1,q3"), ["column q2 is missing", "line 1", "q1, q3", "time,q1,q2"]),
    "too few joints": (
        "time,q1\n0,1\n",
        ["q columns do not fit arm two_link", "2 joints", "found: 1 joint\n", "choose the arm"],
    ),
    "too many joints": (with_header("time,q1,q2,q3"), ["do not fit arm two_link", "found: 3 joints"]),
    "too few rates": (FULL_FILE.replace(",qd2", ",qdd3"), ["qd columns do not fit", "found: 1 joint\n"]),
    "surplus acceleration": (
        FULL_FILE.replace("time,q1,q2,qd1,qd2", "time,q1,q2,qdd5,qdd7"),
        ["column qdd5 is one too many for arm two_link", "qdd1, qdd2, qdd5, qdd7"],
    ),
    "no name": (with_header("time,q1,q2,"), ["too few columns", "line 2, column 4", "4 columns", "found: 3"]),
    "no header": (
        "0,1,2,3,4,5,6\n1,1,2,3,4,5,6\n",
        [
            "no header line",
            "line 1",
            "found: numbers in 7 columns",
            "--columns time,q1..q2,qd1..qd2,qdd1..qdd2",
        ],
    ),
    "no header, rates": ("0,1,2,3,4\n", ["--columns time,q1..q2,qd1..qd2"]),
    "no header, positions": ("# a\n0,1\n", ["line 2", "--columns time,q1"]),
    "not a number": (
        with_row(3, "0.2,0.3,abc"),
        ["q2 is not a number", "line 4, column 3", "found: 'abc'", "give a number"],
    ),
    "not a number, after comments": (
        "# a\n\n" + with_row(3, "0.2,x,0.3"),
        ["q1 is not a number", "line 6, column 2"],
    ),
    "empty cell": (with_row(2, "0.1,,0.3"), ["q1 is not a number", "line 3, column 2", "an empty cell"]),
    "decimal comma": (
        Q_FILE.replace(",", ";").replace("0.2;", "0,2;"),
        ["not a number", "found: '0,2'", "decimal points"],
    ),
    "NaN": (with_row(4, "0.3,0.4,nan"), ["q2 is not a finite number", "line 5, column 3", "found: nan"]),
    "infinite": (with_row(4, "0.3,-inf,0"), ["q1 is not a finite number", "line 5, column 2", "found: -inf"]),
    "overflow": (with_row(4, "0.3,1e999,0"), ["q1 is too large for any motion", "found: '1e999'", "line 5"]),
    "first time": (
        Q_FILE.replace("\n0.0,", "\n-1e308,"),
        ["time is too large", "line 2, column 1", "up to 1e+12", "may start at 0"],
    ),
    "underscores": (
        with_row(3, "0.2,1_000,0.2"),
        ["q1 is not a number", "line 4, column 2", "found: '1_000'", "the digits 0 to 9"],
    ),
    "underscores behind the point": (with_row(3, "0.2,0.3_1,0.2"), ["line 4, column 2", "'0.3_1'"]),
    "full-width digits": (with_row(3, "0.2,\uff11.5,0.2"), ["line 4, column 2", "q1 is not a number"]),
    "digits of another script": (with_row(3, "0.2,\u0663,0.2"), ["line 4, column 2", "not a number"]),
    "infinity in words": (with_row(3, "0.2,Infinity,0"), ["q1 is not a finite number", "line 4, column 2"]),
    "hexadecimal": (with_row(3, "0.2,0x10,0"), ["line 4, column 2", "not a number", "'0x10'"]),
    "a cell of a page": (
        with_row(3, f"0.2,{'x' * 9000},0"),
        ["line 4, column 2", "... (9002 characters) ..."],
    ),
    "a header of full-width digits": (
        with_header("time,q1,q\uff12"),
        ["no position of joint elbow", "line 1"],
    ),
    "an underscore in a header": (with_header("time,q1,q2_0"), ["no position of joint elbow", "q2_0"]),
    "a header of many digits": (
        with_header(f"time,q1,{'1' * 10_000}x"),
        ["name of column 3 is far too long", "line 1, column 3", "(10003 characters)"],
    ),
    "a joint of a large number": (
        with_header("time,q1,q" + "2" * 150),
        ["no position of joint elbow", "line 1"],
    ),
    "NaN time": (with_row(4, "nan,0,0"), ["time is not a finite number", "line 5, column 1"]),
    "short row": (
        with_row(5, "0.4,0.5"),
        ["too few columns", "line 6, column 3", "3 columns", "found: 2", "broke off"],
    ),
    "long row": (with_row(5, "0.4,0.5,0.6,0.7"), ["too many columns", "line 6, column 4", "found: 4"]),
    "all rows long": ("time,q1,q2\n0,1,2,3\n1,1,2,3\n", ["too many columns", "line 2, column 4"]),
    "unclosed quote": (with_row(5, '0.4,0.5,"0.6'), ["not CSV", "line 6", "every quote closed"]),
    "time stands": (
        with_row(3, "0.1,0,0"),
        ["time does not increase", "line 4, column 1", "more than 0.1 s", "found: 0.1 s", "sort"],
    ),
    "time falls": (with_row(3, "0.05,0,0"), ["time does not increase", "line 4, column 1", "0.05 s"]),
    "too few for both": (
        "\n".join(["time,q1,q2", *Q_ROWS[:5]]),
        ["too few set points to derive qd and qdd", "line 6", "at least 6", "5 set points", "qd1..qd2"],
    ),
    "too few for qdd": (
        "time,q1,q2,qd1,qd2\n0,0,0,0,0\n",
        ["too few set points to derive qdd", "found: 1 set point\n", "qdd1..qdd2"],
    ),
    "Latin-1": (Q_FILE.encode() + b"# K\xf6ln\n", ["not UTF-8", "line 9", "0xf6", "UTF-8"]),
    "UTF-16": (Q_FILE.encode("utf-16"), ["not CSV text", "UTF-16", "save it as CSV in UTF-8"]),
    "binary": (b"PK\x03\x04\x00\x00", ["not CSV text", "binary"]),
    "one endless line": ("x" * 200_000, ["line 1", "not CSV", "trajectory"]),
    "endless cell": (with_row(2, "0.1,0," + "9" * 200_000 + "x"), ["line 3", "not CSV"]),
}


@pytest.mark.parametrize("case", CASES)
def test_message(case: str, csv_file: CsvFile, two_link: RobotArm) -> None:
    content, expected = CASES[case]
    path = csv_file(content)
    with pytest.raises(TrajectoryError) as caught:
        read_trajectory(path, two_link)
    text = str(caught.value) + "\n"
    assert str(path) in text
    for part in expected:
        assert part in text


@pytest.mark.parametrize("step", ["1e-300", "1e-160", "1e-9"])
def test_rates_that_overflow(step: str, csv_file: CsvFile, two_link: RobotArm) -> None:
    rows = [f"{k}{step[1:]},{k * k / 10},0" for k in range(8)]
    path = csv_file("\n".join(["time,q1,q2", *rows]))
    with pytest.raises(TrajectoryError, match="cannot be derived: it is too large") as caught:
        read_trajectory(path, two_link)
    assert str(path) in str(caught.value)
    assert f"time steps of {float(step):g} s" in str(caught.value)


def test_an_endless_source_ends(two_link: RobotArm, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(TrajectoryError, match="not CSV text"):
        read_trajectory("/dev/zero", two_link)
    monkeypatch.setattr(csv_file_module, "LARGEST_FILE", 10_000)
    with tempfile.TemporaryDirectory() as folder:
        pipe = Path(folder) / "pipe.csv"
        os.mkfifo(pipe)
        writer = threading.Thread(target=_write_for_ever, args=(pipe,))
        writer.start()
        with pytest.raises(TrajectoryError, match="too large to be read") as caught:
            read_trajectory(pipe, two_link)
        writer.join()
    assert "expected: up to 0.01 MB" in str(caught.value)


def _write_for_ever(pipe: Path) -> None:
    with suppress(BrokenPipeError), pipe.open("wb") as file:
        while True:
            file.write(b"1,2,3\n")


def test_a_header_is_understood_in_linear_time(csv_file: CsvFile, puma: RobotArm) -> None:
    """A cubic expression took 80 s for 10 000 digits, and some for the 200 that a name may have."""
    names = ["time", *("1" * 199 + "x" for _ in range(400))]
    begin = time.perf_counter()
    with pytest.raises(TrajectoryError) as caught:
        read_trajectory(csv_file(",".join(names) + "\n0\n"), puma)
    assert time.perf_counter() - begin < 2.0  # 0.02 s here; the cubic expression takes 100 s
    assert max(map(len, str(caught.value).splitlines())) < 600


@pytest.mark.parametrize(
    "header",
    [
        ",".join(["time", *(f"q{i}" for i in range(1, 100_000))]),
        ",".join(["time", *(f"q{i}" for i in range(2, 100_000))]),
        ",".join(map(str, range(100_000))),
        ",".join(["q1", "q2"] + [f"qd{i}" for i in range(1, 100_000)]),
        "time,q1," + "q2" * 60_000,
        '"' + "x\t" * 60_000,
    ],
)
def test_a_message_stays_short(header: str, csv_file: CsvFile, two_link: RobotArm) -> None:
    with pytest.raises(TrajectoryError) as caught:
        read_trajectory(csv_file(header + "\n0,1,2\n"), two_link)
    assert max(map(len, str(caught.value).splitlines())) < 600


def test_missing_file(two_link: RobotArm, tmp_path: Path) -> None:
    with pytest.raises(TrajectoryError) as caught:
        read_trajectory(tmp_path / "nothing.csv", two_link)
    text = str(caught.value)
    assert "there is no trajectory" in text
    assert "pick-and-place" in text
    assert "gd-analyze plan" in text


def test_near_miss_of_a_shipped_name(puma: RobotArm) -> None:
    with pytest.raises(TrajectoryError, match="did you mean the shipped 'large-slew'"):
        read_trajectory("large_slew.csv", puma)


def test_folder(two_link: RobotArm, tmp_path: Path) -> None:
    with pytest.raises(TrajectoryError, match="cannot read the trajectory file"):
        read_trajectory(tmp_path, two_link)


def test_degrees_of_a_sliding_joint(csv_file: CsvFile, slider: RobotArm) -> None:
    with pytest.raises(TrajectoryError, match="joint 2 slides") as caught:
        read_trajectory(csv_file(with_header("time,q1,q2_deg")), slider)
    assert "line 1, column 3" in str(caught.value)
    assert "give metres" in str(caught.value)


def test_names_among_the_numbers_of_a_first_row(csv_file: CsvFile, two_link: RobotArm) -> None:
    with pytest.raises(TrajectoryError, match="the file has no header line"):
        read_trajectory(csv_file("0,1,base,0.5,0.25,0.1,0.2\n1,1,base,0.5,0.25,0.1,0.2\n"), two_link)
