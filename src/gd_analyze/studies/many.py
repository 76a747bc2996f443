"""Many tasks: one after the other, in processes of this machine (joblib), or on a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from typing import Any, TypeVar

from gd_analyze.errors import UsageError

T = TypeVar("T")


def each(
    work: Callable[..., T], tasks: Iterable[tuple[Any, ...]], jobs: int = 1, scheduler: str | None = None
) -> Iterator[tuple[int, T]]:
    """Number and result of every task, in the order in which they end.

    Tasks are drawn when they are needed, a few more than there are workers. What a task raises is raised
    here. Sending, queues and tasks of workers that die are the engines': Dask runs these again elsewhere.

    Parameters
    ----------
    work
        Called with each task's values; a function of a module, as it is sent to other processes.
    jobs
        Processes of this machine.
    scheduler
        Address of a Dask scheduler, "tcp://host:8786", whose workers take the place of these.

    Raises
    ------
    UsageError
        If Dask is not installed, or no scheduler answers there.
    """
    numbered = enumerate(tasks)
    if scheduler is None and jobs == 1:
        yield from ((number, work(*task)) for number, task in numbered)
        return
    from joblib import Parallel, delayed, parallel_config

    with ExitStack() as held:
        if scheduler is not None:
            held.enter_context(parallel_config(backend="dask", client=held.enter_context(_client(scheduler))))
        many = Parallel(n_jobs=jobs, return_as="generator_unordered", pre_dispatch="2*n_jobs")
        yield from many(delayed(_numbered)(work, *task) for task in numbered)


def _numbered(work: Callable[..., T], number: int, task: tuple[Any, ...]) -> tuple[int, T]:
    return number, work(*task)


def _client(scheduler: str) -> Any:
    try:
        import distributed
    except ImportError:
        step, what = "pip install 'gd-analyze[distributed]'", "a Dask cluster needs the extra `distributed`"
        raise UsageError(what, where=f"--scheduler {scheduler}", next_step=step) from None
    try:
        made: Any = distributed.Client  # not annotated
        return made(scheduler, timeout=10, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        step = "start one with `dask scheduler`, and workers with `dask worker ADDRESS`"
        what, found = "no Dask scheduler answers there", str(error) or type(error).__name__
        raise UsageError(what, where=f"--scheduler {scheduler}", found=found, next_step=step) from None
