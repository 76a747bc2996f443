"""Text files of an arm: read, parsed as TOML, and the line of every key."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path
from typing import Any

from gd_analyze.errors import ArmError, Location
from gd_analyze.files import megabytes, read_at_most

# Factors of the unit suffixes of keys, such as a_mm.
UNIT_SUFFIXES = {"_deg": math.pi / 180, "_mm": 1e-3}


def text_of(path: Path, what: str, most: int) -> str:
    """Text of a file; ArmError if it cannot be read, is larger, or is not UTF-8."""
    try:
        data = read_at_most(path, most)
        if data is not None:
            return data.decode("utf-8")
        problem, found = f"the {what} is too large", f"more than {megabytes(most)}"
    except OSError as error:
        problem, found = f"cannot read the {what}", error.strerror or str(error)
    except UnicodeDecodeError as error:
        problem, found = f"the {what} is not text", f"byte 0x{error.object[error.start]:02x} at {error.start}"
    raise ArmError(problem, where=Location(path), expected="a text file in UTF-8", found=found)


def parsed_toml(path: Path, text: str, what: str) -> dict[str, Any]:
    """Document of a text; ArmError with line and column if it is not TOML."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"line (\d+), column (\d+)", str(error))
        line, column = (int(place[1]), int(place[2])) if place else (text.count("\n") + 1, None)
        where, found = Location(path, line, column), re.sub(r" \(at .*\)$", "", str(error))
        problem, next_step = f"the {what} is not valid TOML", "fix the syntax there"
    except ValueError:  # Python reads no integers of thousands of digits
        lines = enumerate(text.splitlines(), start=1)
        line = next((number for number, row in lines if re.search(r"\d[\d_]{4000}", row)), 1)
        where, found = Location(path, line), "thousands of digits"
        problem, next_step = f"the {what} holds a number beyond any arm", "shorten it"
    except RecursionError:
        where, found, next_step = Location(path), "hundreds of levels", "write it flat"
        problem = f"the {what} nests tables or lists beyond any arm"
    raise ArmError(problem, where=where, found=found, next_step=next_step)


class TableLines:
    """Line numbers of tables and keys, which `tomllib` does not keep."""

    def __init__(self, path: Path, content: str) -> None:
        self.path = path
        self._lines: dict[tuple[str | int, ...], int] = {}
        counts: dict[str, int] = {}
        table: tuple[str | int, ...] = ()
        for number, line in enumerate(content.splitlines(), start=1):
            if header := re.match(r"\s*\[\[\s*([\w.-]+)\s*\]\]", line):
                index = counts[header[1]] = counts.get(header[1], -1) + 1
                table = (header[1], index)
                self._lines[table] = number
                self._lines.setdefault(table[:1], number)
            elif key := re.match(r"\s*([\w-]+)\s*=", line):
                self._lines[(*table, key[1])] = number

    def locate(self, keys: tuple[str | int, ...]) -> Location:
        """Line of the innermost known key of a path such as ("links", 2, "mass")."""
        for end in range(len(keys), 0, -1):
            for suffix in ("", *UNIT_SUFFIXES):
                candidate = (*keys[: end - 1], f"{keys[end - 1]}{suffix}") if suffix else keys[:end]
                if candidate in self._lines:
                    return Location(self.path, self._lines[candidate])
        return Location(self.path)
