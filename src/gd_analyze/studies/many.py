"""Many tasks: one after the other, in processes of this machine (joblib), or on a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from typing import Any, TypeVar

from gd_analyze.errors import StorageError, UsageError

_T = TypeVar("_T")
# Idle time after which a worker whose parent was killed ends, s.
_IDLE_SECONDS = 30.0
# How long a Dask scheduler may take to answer, s.
ANSWER_SECONDS = 10.0


def each(
    work: Callable[..., _T],
    tasks: Iterable[tuple[Any, ...]],
    jobs: int = 1,
    scheduler: str | None = None,
) -> Iterator[tuple[int, _T]]:
    """Yield number and result of every task, in the order of completion.

    Tasks are drawn as needed, a few more than there are workers. Exceptions of tasks are raised here. The
    engines handle transport, queues and dead workers: Dask runs lost tasks again elsewhere.

    Parameters
    ----------
    work
        Called with each task's values; a function of a module, as it is sent to other processes.
    jobs
        Number of processes on this machine.
    scheduler
        Address of a Dask scheduler, "tcp://host:8786", whose workers take the place of these.

    Raises
    ------
    UsageError
        If Dask is not installed, or no scheduler answers there.
    StorageError
        If a worker of this machine died, or one task killed several workers of a cluster.
    """
    numbered = enumerate(tasks)
    if scheduler is None and jobs == 1:
        yield from ((number, work(*task)) for number, task in numbered)
        return
    from joblib import Parallel, delayed, parallel_config

    with ExitStack() as stack:
        # Workers whose parent was killed end after this idle time.
        engine: dict[str, Any] = {"backend": "loky", "idle_worker_timeout": _IDLE_SECONDS}
        if scheduler is not None:
            engine, jobs = {"backend": "dask", "client": stack.enter_context(_client(scheduler))}, -1
        stack.enter_context(parallel_config(**engine))
        parallel = Parallel(
            n_jobs=jobs, return_as="generator_unordered", pre_dispatch="2*n_jobs", batch_size=1
        )
        try:
            yield from parallel(delayed(_numbered)(work, *task) for task in numbered)
        except Exception as error:
            if type(error).__name__ not in ("TerminatedWorkerError", "KilledWorker"):
                raise
            step = "run it again to continue where it stopped; fewer `jobs` take less memory"
            raise StorageError("a worker died", found=str(error).splitlines()[0], next_step=step) from None


def _numbered(work: Callable[..., _T], number: int, task: tuple[Any, ...]) -> tuple[int, _T]:
    return number, work(*task)


def _client(scheduler: str) -> Any:
    try:
        import distributed
    except ImportError:
        step, message = "pip install distributed", "a Dask cluster needs the library distributed"
        raise UsageError(message, where="scheduler", found=scheduler, next_step=step) from None
    try:
        client_class: Any = distributed.Client  # not annotated
        return client_class(scheduler, timeout=ANSWER_SECONDS, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        step = "start one with `dask scheduler`, and workers with `dask worker ADDRESS`"
        message, reason = "no Dask scheduler answers there", str(error) or type(error).__name__
        found = f"{scheduler}: {reason}"
        raise UsageError(message, where="scheduler", found=found, next_step=step) from None
