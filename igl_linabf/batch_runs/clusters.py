"""Dask's cluster: one of our own on this machine, or the one at an address."""

import logging
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

import psutil

from .._runtime import undone_at_once

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
ROOM = 2**29  # bytes that a worker takes before a mesh is there, at most
PATIENCE = 30  # seconds until a scheduler answers
TERMINATE = 0.95  # of a worker's memory

SETTINGS = {
    # the largest part of a worker's memory is that of the mesh at hand: neither can go to disk
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.terminate": TERMINATE,
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
        with dask.config.set(SETTINGS):
            cluster = LocalCluster(
                n_workers=workers or CPU_COUNT,
                threads_per_worker=1,
                host="127.0.0.1",
                dashboard_address="127.0.0.1:0",
                memory_limit="auto" if memory is None else int((memory + ROOM) / TERMINATE),
                local_directory=folder,
                silence_logs=logging.CRITICAL,  # what becomes of a mesh is in its row
                preload=["igl_linabf.batch_runs.one_mesh"],
                scheduler_kwargs={"allowed_failures": 0},  # who was there when a worker died is tried alone
            )
        stack.enter_context(cluster)

        def end() -> None:
            for nanny in cluster.workers.values():
                nanny.close_gracefully()  # else it starts another process, which outlives this one
            killed = [psutil.Process(nanny.pid) for nanny in cluster.workers.values() if nanny.pid]
            for process in killed:
                with suppress(psutil.NoSuchProcess):
                    process.kill()
            psutil.wait_procs(killed, timeout=1)
            shutil.rmtree(folder, ignore_errors=True)

        stack.enter_context(undone_at_once(end))
        yield stack.enter_context(Client(cluster, set_as_default=False))


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
