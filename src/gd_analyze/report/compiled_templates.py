"""Templates of pages as compiled before, kept where Python keeps compiled modules and on the same terms."""

from __future__ import annotations

import hashlib
import sys
from contextlib import suppress
from importlib.util import cache_from_source
from pathlib import Path
from pickle import UnpicklingError

from jinja2 import FileSystemBytecodeCache
from jinja2.bccache import Bucket

TEMPLATES = Path(__file__).parent / "templates"
_SUFFIX = ".template.pyc"


class CompiledTemplates(FileSystemBytecodeCache):
    """Keeps what compiling a page's templates gives, which takes longer than filling them in."""

    def __init__(self) -> None:
        place = Path(cache_from_source(str(TEMPLATES / "page.py"))).parent
        self._code = _state_of_code()
        super().__init__(str(place), f"{self._code}-%s{_SUFFIX}")

    def load_bytecode(self, bucket: Bucket) -> None:
        """Read one; a damaged one is none."""
        with suppress(OSError, EOFError, ValueError, UnpicklingError):
            super().load_bytecode(bucket)

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Write one, unless Python is told to write none or nobody may write there, and remove older ones."""
        if sys.dont_write_bytecode:
            return
        place = Path(self.directory)
        with suppress(OSError):
            place.mkdir(parents=True, exist_ok=True)
            super().dump_bytecode(bucket)
            for path in place.glob(f"*{_SUFFIX}"):
                if not path.name.startswith(self._code):
                    path.unlink(missing_ok=True)


def _state_of_code() -> str:
    """What tells whether our code has changed, as Python tells it: compiling applies filters to constants."""
    root = Path(__file__).parents[1]
    known = [(str(path.relative_to(root)), path.stat()) for path in sorted(root.rglob("*.py"))]
    stated = repr([(name, of.st_mtime_ns, of.st_size) for name, of in known])
    return hashlib.sha256(stated.encode()).hexdigest()[:16]
