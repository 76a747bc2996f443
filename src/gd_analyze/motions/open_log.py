"""Opens a log, whatever its format."""

from __future__ import annotations

from pathlib import Path

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.echoed_csv import echoed_names
from gd_analyze.motions.reading import Reading
from gd_analyze.motions.table import LogTable, Progress, no_progress
from gd_analyze.motions.text_layout import is_number, refuse_long_names
from gd_analyze.motions.text_table import TextTable

_SUFFIXES = {
    **dict.fromkeys((".db3", ".mcap", ".bag"), "bag"),
    **dict.fromkeys((".parquet", ".pq"), "parquet"),
    **dict.fromkeys((".yaml", ".yml"), "yaml"),
}
_NOT_NEEDED = "-"


def format_by_name(path: str | Path) -> str | None:
    """Format of a log that its name tells: "bag" (a folder with metadata.yaml too), "parquet" or "yaml"."""
    path = Path(path)
    if path.is_dir():
        return "bag" if (path / "metadata.yaml").is_file() else None
    return _SUFFIXES.get(path.suffix.lower())


def open_log(
    path: str | Path, reading: Reading, data: bytes | None = None, progress: Progress = no_progress
) -> LogTable:
    """Open a log.

    Parameters
    ----------
    path
        The file, or what to call the bytes.
    reading
        What the user says of columns and topic.
    data
        Its bytes, where it is no file.
    progress
        Told of what takes long.

    Raises
    ------
    TrajectoryError
        If it cannot be opened, or has no names of columns.
    """
    kind = None if data is not None else format_by_name(path)
    if kind == "bag":
        from gd_analyze.motions.rosbag import read_bag

        return read_bag(Path(path), reading.topic, progress)
    if kind == "parquet":
        from gd_analyze.motions.parquet import ParquetTable

        return ParquetTable(path)
    if kind == "yaml":
        from gd_analyze.motions.yaml_messages import read_yaml

        return read_yaml(path, progress=progress)
    if data is None and not Path(path).is_file():
        raise TrajectoryError(
            "there is no such log",
            where=Location(path),
            expected="a file, or a folder with the metadata.yaml of a bag",
            found="a folder" if Path(path).is_dir() else "nothing",
            next_step="check the path",
        )
    table = TextTable(path, data)
    if (table.names or table.first_cells)[0].lstrip().startswith("<"):
        raise TrajectoryError(
            "this is no log",
            where=Location(path, table.layout.first),
            expected="a log: text in columns, a bag, Parquet or YAML",
            found="XML, as robots' files are",
            next_step="name the robot first, then the log",
        )
    return _named(table, reading)


def _named(table: TextTable, reading: Reading) -> TextTable:
    """The table with names: those of its header, of the messages in it, or those that the user gives."""
    if any(table.names):
        return table
    cells = table.first_cells
    echoed = echoed_names(cells, [is_number(cell) for cell in cells])
    if echoed is not None and not reading.columns:
        refuse_long_names(echoed, Location(table.path, table.layout.first))
        names = {k: cell for k, cell in enumerate(cells) if k > 2 and cell and not is_number(cell)}
        table.require_constant(names)
        return TextTable(table.path, table.data, echoed)
    width = table.layout.width
    if not reading.columns:
        raise _no_names(table, cells)
    if len(reading.columns) != width:
        raise TrajectoryError(
            "the names given do not fit the columns",
            where=f"--columns; {Location(table.path, table.layout.first)}",
            expected=f"{width} names, {_NOT_NEEDED} for a column that is not needed",
            found=str(len(reading.columns)),
            next_step="name every column",
        )
    return TextTable(table.path, table.data, tuple("" if n == _NOT_NEEDED else n for n in reading.columns))


def _no_names(table: TextTable, cells: list[str]) -> TrajectoryError:
    values = len(cells) - 1
    kinds = next((count for count in (3, 2) if values % count == 0 and values // count > 1), 1)
    joints = values // kinds
    names = [
        "time",
        *(f"{kind}1..{kind}{joints}" if joints > 1 else f"{kind}1" for kind in ("q", "qd", "qdd")[:kinds]),
    ]
    return TrajectoryError(
        "the file has no header line",
        where=Location(table.path, table.layout.first),
        expected="the names of the columns",
        found=f"numbers in {len(cells)} columns",
        next_step=f"if these are the columns, name them: --columns {','.join(names)}",
    )
