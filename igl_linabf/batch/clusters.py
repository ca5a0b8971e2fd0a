"""Start a local Dask cluster, or connect to the cluster of a running scheduler."""

import logging
import os
import secrets
import shutil
import tempfile
import threading
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

import psutil

from .._runtime import undo_at_interrupt
from .constants import PATIENCE

NO_WORKER_TIMEOUT = 600  # seconds without any worker until a local batch ends with an error
WORKER_CHECK_INTERVAL = 1000  # milliseconds between checks for dead workers
WORKER_MEMORY = 2**29  # memory of an idle worker, bytes
KILL_ROUNDS = 3  # how often workers are killed, because Dask may restart some of them in the meantime
TERMINATION_SHARE = 0.95  # Dask terminates a worker that uses this share of its memory limit (Dask's default)

THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")

DASK_SETTINGS = {
    # most memory of a worker belongs to its current mesh and cannot be spilled to disk
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,
    "distributed.worker.memory.terminate": TERMINATION_SHARE,
    "distributed.deploy.lost-worker-timeout": NO_WORKER_TIMEOUT,  # workers may start slowly
}


@contextmanager
def connect_client(scheduler: str) -> Iterator[Any]:
    """Connect to the Dask scheduler at an address."""
    from distributed import Client

    try:
        client = Client(scheduler, timeout=PATIENCE, set_as_default=False)
    except (OSError, TimeoutError) as error:
        raise OSError(None, f"no scheduler answers at this address: {error}", scheduler) from None
    with client:
        yield client


@contextmanager
def start_local_client(workers: int | None, memory: int | None, dashboard: bool) -> Iterator[Any]:
    """Start single-threaded workers on this machine; all of them listen on the loopback interface only."""
    import dask
    from dask.system import CPU_COUNT
    from distributed import Client, LocalCluster

    folder = os.path.join(tempfile.gettempdir(), f"igl_linabf-{secrets.token_hex(8)}")
    ending, clusters = threading.Event(), list[Any]()

    def close_cluster() -> None:
        ending.set()
        for cluster in clusters:  # empty while the workers start
            for nanny in cluster.workers.values():
                nanny.close_gracefully()  # otherwise the nanny starts a worker that outlives this process
        _kill_child_processes()
        shutil.rmtree(folder, ignore_errors=True)

    with ExitStack() as stack:
        stack.enter_context(undo_at_interrupt(close_cluster))
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        os.mkdir(folder, 0o700)
        stack.enter_context(_limit_to_one_thread())
        # this setting also applies to the scheduler, unlike LocalCluster's `local_directory`
        stack.enter_context(dask.config.set({**DASK_SETTINGS, "temporary-directory": folder}))
        cluster = LocalCluster(
            n_workers=workers or CPU_COUNT,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            memory_limit="auto" if memory is None else int((memory + WORKER_MEMORY) / TERMINATION_SHARE),
            silence_logs=logging.CRITICAL,  # errors are recorded in the table
            preload=["igl_linabf.batch.one_mesh"],
            scheduler_kwargs={
                "allowed_failures": 0,  # the batch itself retries the meshes of a dead worker
                "dashboard": dashboard,
            },
        )
        clusters.append(cluster)
        stack.enter_context(cluster)
        if not dashboard:  # a Dask scheduler starts an HTTP server even without a dashboard
            cluster.loop.add_callback(cluster.scheduler.http_server.stop)
        stack.enter_context(_replace_lost_workers(cluster, ending))
        yield stack.enter_context(Client(cluster, set_as_default=False))


def _kill_child_processes() -> None:
    """Kill all descendant processes except multiprocessing's resource tracker, which ends by itself."""
    for _ in range(KILL_ROUNDS):
        killed: list[psutil.Process] = []
        for child in psutil.Process().children():
            with suppress(psutil.NoSuchProcess):
                if not any("resource_tracker" in part for part in child.cmdline()):
                    child.suspend()  # so that it cannot start processes while its children are listed
                    killed += [child, *child.children(recursive=True)]
        if not killed:
            return
        for process in killed:
            with suppress(psutil.NoSuchProcess):
                process.kill()
        psutil.wait_procs(killed, timeout=1)


@contextmanager
def _replace_lost_workers(cluster: Any, ending: threading.Event) -> Iterator[None]:
    """Replace dead workers of a local cluster, until `ending` is set.

    This is necessary because Dask itself restarts a dead worker process only once.
    """
    from distributed import Status
    from tornado.ioloop import PeriodicCallback

    wanted = len(cluster.workers)

    def restart_lost_workers() -> None:
        for name, nanny in list(cluster.workers.items()):
            if nanny.status in (Status.closed, Status.failed) and not ending.is_set():
                del cluster.workers[name]
        if len(cluster.workers) < wanted and not ending.is_set():
            cluster.scale(wanted)

    mending = PeriodicCallback(restart_lost_workers, WORKER_CHECK_INTERVAL)
    cluster.loop.add_callback(mending.start)
    try:
        yield
    finally:
        ending.set()
        cluster.loop.add_callback(mending.stop)


class WorkerWatch:
    """A check that workers exist, so that a batch does not wait forever for results."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._checks_without_workers = 0

    def check_workers(self) -> None:
        """Warn if a remote cluster has no workers. Call this after each `PATIENCE` seconds without a result.

        Raises
        ------
        OSError
            A local cluster has been without workers for `NO_WORKER_TIMEOUT` seconds.
        """
        if self._client.nthreads():
            self._checks_without_workers = 0
            return
        self._checks_without_workers += 1
        if self._client.cluster is None:
            if self._checks_without_workers == 1:
                place = self._client.scheduler.address
                warnings.warn(f"{place} has no workers: the batch waits until some join it", stacklevel=2)
        elif self._checks_without_workers * PATIENCE >= NO_WORKER_TIMEOUT:
            raise OSError(
                None, "no worker process stays alive: free memory, or use fewer workers", "this machine"
            )


@contextmanager
def _limit_to_one_thread() -> Iterator[None]:
    """Limit BLAS and OpenMP to one thread in processes that are started within the `with` block.

    All environment variables are restored at the end, including the variables that Dask's nannies set.
    """
    before = dict(os.environ)
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    warned = before.get("PYTHONWARNINGS")  # multiprocessing would warn if this process is killed
    os.environ["PYTHONWARNINGS"] = ",".join(filter(None, (warned, "ignore:resource_tracker:UserWarning")))
    try:
        yield
    finally:
        for name in set(os.environ) - set(before):
            del os.environ[name]
        os.environ.update(before)
