"""Keeps a process that reads results files, and starts another one where it hangs or dies."""

from __future__ import annotations

import atexit
import json
import select
import subprocess
import sys
from pathlib import Path
from typing import Any

from verdict import SECONDS, BrokenError

# On a machine that does other things as well, a case takes longer than the time it may take for itself.
PATIENCE = 10 * SECONDS


class Process:
    """Asks `hdf5_reader.py`; started when it is first asked."""

    def __init__(self) -> None:
        self._running: subprocess.Popen[str] | None = None
        atexit.register(self.stop)

    def read(self, path: Path) -> dict[str, Any]:
        """Answer of the process; a BrokenError if there is none in time."""
        if self._running is None:
            script = Path(__file__).with_name("hdf5_reader.py")
            self._running = subprocess.Popen(
                [sys.executable, str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
            )
        assert self._running.stdin is not None
        assert self._running.stdout is not None
        self._running.stdin.write(f"{path}\n")
        self._running.stdin.flush()
        # Its own clock stops the process earlier, unless it is inside a library.
        ready, _, _ = select.select([self._running.stdout], [], [], PATIENCE)
        line = self._running.stdout.readline() if ready else ""
        if not line:
            died = self._running.wait() if ready else None
            self.stop()
            raise BrokenError("hangs" if died is None else f"process died with {died}", "reading")
        return json.loads(line)

    def stop(self) -> None:
        """End the process."""
        if self._running is not None:
            with self._running as process:
                process.kill()
            self._running = None


PROCESS = Process()
