"""Where in a TOML file a table or key stands."""

from __future__ import annotations

import re
from pathlib import Path

from gd_analyze.errors import Location
from gd_analyze.robots.arm_schema import UNIT_SUFFIXES


class TableLines:
    """Line numbers of tables and keys; the TOML parser of the standard library keeps none."""

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
