"""One thread for linear algebra: with matrices this small a second thread only waits for the first."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Any

# Variables by which a user chooses the number of threads; it is then left alone.
_VARIABLES = {"OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"}


class _Limit:
    """The limit on threads of this process: set when the first job begins, lifted when the last ends."""

    def __init__(self) -> None:
        self._lock, self._jobs, self._limiter = Lock(), 0, None

    _limiter: Any

    def begin(self) -> None:
        """Set the limit, unless another job has."""
        with self._lock:
            self._jobs += 1
            if self._jobs == 1 and not _VARIABLES & set(os.environ):
                import scipy.linalg  # noqa: F401  loads SciPy's own library, limited only once it is there
                from threadpoolctl import threadpool_limits

                self._limiter = threadpool_limits(limits=1, user_api="blas")

    def end(self) -> None:
        """Lift the limit after the last job."""
        with self._lock:
            self._jobs -= 1
            if self._jobs == 0 and self._limiter is not None:
                self._limiter.restore_original_limits()
                self._limiter = None


_LIMIT = _Limit()


def begin_with_one_thread() -> None:
    """Let libraries that this process has yet to load begin with one thread, unless the user chose a number.

    A process of our own then limits none, for which it would have to load all of them first.
    """
    if not _VARIABLES & set(os.environ):
        os.environ.update(dict.fromkeys(_VARIABLES, "1"))


@contextmanager
def one_thread() -> Iterator[None]:
    """Let libraries of linear algebra run one thread, unless the environment states their number.

    The last bits then do not depend on the number of cores either. `@one_thread()` is for a whole function.
    """
    _LIMIT.begin()
    try:
        yield
    finally:
        _LIMIT.end()
