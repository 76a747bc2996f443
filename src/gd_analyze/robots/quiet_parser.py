"""What Pinocchio's parsers print to the process's standard error, caught for a message."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from typing import Any

from gd_analyze.errors import ArmError, Location


def parsed(build: Callable[[], Any], where: Location, kind: str) -> Any:
    """Build a model with the parser's own complaints kept off the terminal.

    Raises
    ------
    ArmError
        If the parser gives up; with the first of its complaints.
    """
    with tempfile.TemporaryFile() as complaints:
        if sys.stderr is not None:
            sys.stderr.flush()
        kept = os.dup(2)
        os.dup2(complaints.fileno(), 2)
        try:
            model, failure = build(), None
        except Exception as error:
            model, failure = None, str(error)
        finally:
            os.dup2(kept, 2)
            os.close(kept)
        complaints.seek(0)
        said = complaints.read(10_000).decode(errors="replace")
    if failure is None:
        return model
    lines = [line.strip() for line in (said or failure).splitlines() if line.strip()]
    raise ArmError(
        f"Pinocchio cannot read the {kind}",
        where=where,
        expected=f"a {kind} of one robot",
        found=lines[:3] or "no reason given",
        next_step="mend the file there",
    ) from None
