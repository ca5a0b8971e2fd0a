"""Dask's cluster: one of our own on this machine, or the one at an address."""

import logging
import os
import shutil
import tempfile
import threading
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

import psutil

from .._runtime import undo_at_interrupt
from .constants import MENDING_INTERVAL, NO_WORKER, PATIENCE, TERMINATE, WORKER_MEMORY

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")

SETTINGS = {
    # the largest part of a worker's memory is that of the mesh at hand: neither can go to disk
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.terminate": TERMINATE,
    "distributed.deploy.lost-worker-timeout": NO_WORKER,  # those that start slowly are not lost
}


@contextmanager
def client_of(scheduler: str) -> Iterator[Any]:
    """A client of the scheduler at an address."""
    from distributed import Client

    try:
        client = Client(scheduler, timeout=PATIENCE, set_as_default=False)
    except (OSError, TimeoutError) as error:
        raise OSError(None, f"no scheduler answers there: {error}", scheduler) from None
    with client:
        yield client


@contextmanager
def local_client(workers: int | None, memory: int | None) -> Iterator[Any]:
    """A client of a cluster of single-threaded workers on this machine that listens on loopback only."""
    import dask
    from dask.system import CPU_COUNT
    from distributed import Client, LocalCluster

    with ExitStack() as stack:
        folder = tempfile.mkdtemp(prefix="igl_linabf-")
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        stack.enter_context(_single_threaded())
        stack.enter_context(dask.config.set(SETTINGS))
        cluster = LocalCluster(
            n_workers=workers or CPU_COUNT,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            memory_limit="auto" if memory is None else int((memory + WORKER_MEMORY) / TERMINATE),
            local_directory=folder,
            silence_logs=logging.CRITICAL,  # what becomes of a mesh is in its row
            preload=["igl_linabf.batch_runs.one_mesh"],
            scheduler_kwargs={"allowed_failures": 0},  # who was there when a worker died is tried alone
        )
        stack.enter_context(cluster)
        ending = stack.enter_context(_mended(cluster))

        def end() -> None:
            ending.set()
            for nanny in cluster.workers.values():
                nanny.close_gracefully()  # else it starts another process, which outlives this one
            killed = [psutil.Process(nanny.pid) for nanny in cluster.workers.values() if nanny.pid]
            for process in killed:
                with suppress(psutil.NoSuchProcess):
                    process.kill()
            psutil.wait_procs(killed, timeout=1)
            shutil.rmtree(folder, ignore_errors=True)

        stack.enter_context(undo_at_interrupt(end))
        yield stack.enter_context(Client(cluster, set_as_default=False))


@contextmanager
def _mended(cluster: Any) -> Iterator[threading.Event]:
    """Replace workers of a local cluster that could not be started again, until the event is set.

    Dask starts a process that has died again, once.
    """
    from distributed import Status
    from tornado.ioloop import PeriodicCallback

    ending, wanted = threading.Event(), len(cluster.workers)

    def mend() -> None:
        for name, nanny in list(cluster.workers.items()):
            if nanny.status in (Status.closed, Status.failed) and not ending.is_set():
                del cluster.workers[name]
        if len(cluster.workers) < wanted and not ending.is_set():
            cluster.scale(wanted)

    mending = PeriodicCallback(mend, MENDING_INTERVAL)
    cluster.loop.add_callback(mending.start)
    try:
        yield ending
    finally:
        ending.set()
        cluster.loop.add_callback(mending.stop)


class Lookout:
    """For workers, while no result comes: a batch tells that it waits for one, and does not wait for ever."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._in_vain = 0

    def look(self) -> None:
        """To be called after each `PATIENCE` seconds without a result.

        Raises
        ------
        OSError
            There has been no process of our own for long.
        """
        if self._client.nthreads():
            self._in_vain = 0
            return
        self._in_vain += 1
        if self._client.cluster is None:
            if self._in_vain == 1:
                place = self._client.scheduler.address
                warnings.warn(f"{place} has no workers: the batch waits until some join it", stacklevel=2)
        elif self._in_vain * PATIENCE >= NO_WORKER:
            raise OSError(
                None, "no worker process stays alive: free memory, or use fewer workers", "this machine"
            )


@contextmanager
def _single_threaded() -> Iterator[None]:
    """Processes that are started within have BLAS and OpenMP use one thread: each has a mesh of its own.

    The nannies put these variables, and more, into the environment of this process, too.
    """
    before = dict(os.environ)
    os.environ.update(dict.fromkeys(THREADS, "1"))
    warned = before.get("PYTHONWARNINGS")  # if this process is killed, multiprocessing cleans up: in silence
    os.environ["PYTHONWARNINGS"] = ",".join(filter(None, (warned, "ignore:resource_tracker:UserWarning")))
    try:
        yield
    finally:
        for name in set(os.environ) - set(before):
            del os.environ[name]
        os.environ.update(before)
