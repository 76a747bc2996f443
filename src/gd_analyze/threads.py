"""One thread for linear algebra: with matrices this small a second thread only waits for the first."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from threading import Lock
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
_T = TypeVar("_T")

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
                # SciPy has a library of its own, whose threads are limited only once it is loaded.
                import scipy.linalg  # noqa: F401
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


@contextmanager
def one_thread() -> Iterator[None]:
    """Let libraries of linear algebra run one thread, unless the environment states their number.

    The last bits then do not depend on the number of cores either.
    """
    _LIMIT.begin()
    try:
        yield
    finally:
        _LIMIT.end()


def on_one_thread(function: Callable[P, _T]) -> Callable[P, _T]:
    """Run a function with `one_thread`."""

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> _T:
        with one_thread():
            return function(*args, **kwargs)

    return limited
