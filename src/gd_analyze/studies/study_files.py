"""Files of a study: its result as a page that opens offline, a typeset PDF, and JSON."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path

from gd_analyze.files import mark_of, replacing_together, require_one_run
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.report.html import page_of
from gd_analyze.report.pdf import pdf_of
from gd_analyze.result import Result
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import fingerprint

_WRITERS: Mapping[str, Callable[[Result], bytes]] = {
    "html": lambda result: page_of(result).encode(),
    "pdf": lambda result: pdf_of(result, result.provenance["created"]),
    "json": lambda result: (json.dumps(result.document(), indent=2, allow_nan=False) + "\n").encode(),
}


class StudyFolder:
    """Files NAME.html, NAME.pdf and NAME.json of one run in a folder.

    A run of something else than was asked for is not replaced, unless it shall be overwritten: see
    `require_one_run`.
    """

    def __init__(
        self, folder: Path, name: str, formats: Collection[str], asked: Sequence[str], *, overwrite: bool
    ) -> None:
        files = {format_: f"{name}.{format_}" for format_ in _WRITERS}
        self._others = require_one_run(folder, files, formats, mark_of(asked), overwrite=overwrite)
        self.paths = {format_: folder / files[format_] for format_ in formats}

    def write(self, result: Result) -> None:
        """Write all files when the last is made, and remove those of another run."""
        made = [_WRITERS[format_](result) for format_ in self.paths]
        with replacing_together([*self.paths.values()]) as temporaries:
            for temporary, content in zip(temporaries, made, strict=True):
                temporary.write_bytes(content)
        for path in self._others:
            path.unlink(missing_ok=True)


def inputs_stated(arm: RobotArm, motion: Trajectory | None) -> dict[str, str]:
    """State arm, payload and motion with their hashes."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # given when the arm was read
        stated = {"arm": f"{arm.name}, SHA-256 {fingerprint(arm)[:16]}"}
    payload = [note for note in arm.assumptions if "payload" in note]
    if payload:
        stated["payload"] = "; ".join(payload)
    motion_stated = "none given" if motion is None else f"{motion.name}, SHA-256 {motion.fingerprint[:16]}"
    return stated | {"trajectory": motion_stated}
