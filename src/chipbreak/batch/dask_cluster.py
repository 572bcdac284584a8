"""Programs filtered by the workers of a Dask cluster, on this machine or on many."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from itertools import islice
from typing import TYPE_CHECKING, Any

from chipbreak.batch.work import Finished, Task, filtered, lost
from chipbreak.text.diagnostics import RefusalError

if TYPE_CHECKING:
    from distributed import Client

LOCAL = "local"
_NO_CLUSTER = "BAT002"
_WAIT_S = 10
# Tasks a worker has at hand, so that it never waits for the next one.
_AHEAD = 2
_TRIES = 3


def by_dask(tasks: Iterable[Task], address: str, jobs: int) -> Iterator[Finished]:
    """What became of each task, in the order in which they finish, on the cluster at ``address``.

    ``local`` starts a cluster of ``jobs`` processes for as long as it takes.  A task whose worker dies goes
    to another one; one that takes :data:`_TRIES` workers with it, and as many again when it runs alone, is
    given as lost.  Errors: BAT002 without Dask or without a cluster at the address.
    """
    with ExitStack() as stack:
        client = _client(address, jobs, stack)
        yield from _gathered(client, tasks)


def _client(address: str, jobs: int, stack: ExitStack) -> Client:
    try:
        import dask  # noqa: PLC0415 (an optional extra)
        from distributed import Client, LocalCluster  # noqa: PLC0415
    except ImportError:
        help_text = "pip install 'chipbreak[dask]', or leave --dask out and take --jobs"
        raise RefusalError(_NO_CLUSTER, "Dask is not installed", help_text) from None
    stack.enter_context(dask.config.set({"distributed.scheduler.allowed-failures": _TRIES - 1}))
    try:
        if address == LOCAL:
            address = stack.enter_context(
                LocalCluster(n_workers=jobs, threads_per_worker=1, processes=True, dashboard_address=None)
            )
        return stack.enter_context(Client(address, timeout=_WAIT_S))
    except (OSError, ValueError) as error:
        help_text = "start dask-scheduler and workers there, or say --dask local"
        raise RefusalError(_NO_CLUSTER, f"no Dask cluster at {address}: {error}", help_text) from None


def _gathered(client: Client, tasks: Iterable[Task]) -> Iterator[Finished]:
    from distributed import KilledWorker, as_completed  # noqa: PLC0415

    waiting = iter(tasks)
    under_way: dict[str, Task] = {}
    suspects: list[Task] = []

    def submitted(count: int) -> list[Any]:
        futures = []
        for task in islice(waiting, count):
            future = client.submit(filtered, task, pure=False)
            under_way[future.key] = task
            futures.append(future)
        return futures

    workers = max(1, sum(client.nthreads().values()))
    ready = as_completed(submitted(workers * _AHEAD))
    for future in ready:
        task = under_way.pop(future.key)
        if isinstance(future.exception(), KilledWorker):
            suspects.append(task)
        else:
            yield _finished(future, task)
        future.release()
        for other in submitted(1):
            ready.add(other)
    # A worker that dies takes along what else it had at hand: only a task that is alone on the cluster, and
    # dies again, is the one to blame.
    for task in suspects:
        future = client.submit(filtered, task, pure=False)
        yield _finished(future, task)
        future.release()


def _finished(future: Any, task: Task) -> Finished:
    """What a future gives, waited for; lost where it gives nothing."""
    error = future.exception()
    return lost(task, f"{type(error).__name__}: {error}") if error is not None else future.result()
