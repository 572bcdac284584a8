"""Programs filtered by several processes of this machine; a process that dies takes nothing else with it."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

from chipbreak.batch.work import Finished, Task, filtered, lost


def by_processes(tasks: Iterable[Task], jobs: int) -> Iterator[Finished]:
    """What became of each task, in the order in which they finish; ``jobs`` of them run at a time.

    Nobody can say which program a dead worker had in hand, so those that were under way when it died are
    tried again, each in a process of its own; one that dies there too is given as lost.
    """
    waiting = iter(tasks)
    suspects: list[Task] = []
    while (first := next(waiting, None)) is not None:
        yield from _until_one_dies(first, waiting, jobs, suspects)
    for task in suspects:
        yield _alone(task)


def _until_one_dies(
    first: Task, waiting: Iterator[Task], jobs: int, suspects: list[Task]
) -> Iterator[Finished]:
    """Run tasks until there are no more, or until a worker dies; those it may have had go to ``suspects``."""
    with _pool(jobs) as pool:
        under_way: dict[Future[Finished], Task] = {pool.submit(filtered, first): first}
        while under_way:
            while len(under_way) < jobs and (task := next(waiting, None)) is not None:
                try:
                    under_way[pool.submit(filtered, task)] = task
                except BrokenProcessPool:
                    suspects += [task, *under_way.values()]
                    return
            ready, _ = wait(under_way, return_when=FIRST_COMPLETED)
            dead = [under_way.pop(future) for future in ready if _has_died(future)]
            yield from (future.result() for future in ready if under_way.pop(future, None))
            if dead:
                suspects += [*dead, *under_way.values()]
                return


def _has_died(future: Future[Finished]) -> bool:
    return isinstance(future.exception(), BrokenProcessPool)


def _alone(task: Task) -> Finished:
    with _pool(1) as pool:
        try:
            return pool.submit(filtered, task).result()
        except BrokenProcessPool as error:
            return lost(task, str(error))


def _pool(jobs: int) -> ProcessPoolExecutor:
    """Workers that start clean: a copy of a process with threads may hang."""
    methods = multiprocessing.get_all_start_methods()
    context = multiprocessing.get_context("forkserver" if "forkserver" in methods else "spawn")
    if context.get_start_method() == "forkserver":
        context.set_forkserver_preload(["chipbreak.batch.work"])
    return ProcessPoolExecutor(jobs, mp_context=context)
