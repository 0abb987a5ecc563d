"""The workers: processes of this machine, or a cluster that is already there. Both are a Dask client."""

from __future__ import annotations

import contextlib
import logging
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hyperfab.errors import InputError, OutputError
from hyperfab.numerics.threads import LIMIT, cores
from hyperfab.studies.plan import program

#: How often a batch may lose its worker before it is handed back to the driver.
ALLOWED_DEATHS = 5
#: Folders of the workers' own; behind it the driver's number.
_SCRATCH = "hf-sweep-"


@contextlib.contextmanager
def local(jobs: int, plugin: Any) -> Iterator[Any]:
    """Run ``jobs`` worker processes on this machine, each set up by ``plugin``; yield their client.

    They talk over the loopback interface, and nothing else listens. At the end, however it comes, no process is left.
    """
    dask = _dask()
    import distributed

    # Dask's classes carry no types.
    start: Any = distributed.LocalCluster
    connect: Any = distributed.Client

    _sweep_scratch()
    settings = {
        "distributed.scheduler.allowed-failures": ALLOWED_DEATHS,
        "distributed.worker.daemon": False,
        "distributed.comm.timeouts.connect": "30s",
        "distributed.admin.log-length": 0,
    }
    with (
        dask.config.set(settings),
        tempfile.TemporaryDirectory(prefix=f"{_SCRATCH}{os.getpid()}-", ignore_cleanup_errors=True) as scratch,
    ):
        cluster = start(
            n_workers=0,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            # Any free port of the loopback, for the scheduler's own state; the usual one may be another study's.
            dashboard_address="127.0.0.1:0",
            worker_dashboard_address="127.0.0.1:0",
            memory_limit=0,
            env={LIMIT: str(max(1, cores() // jobs))},
            local_directory=scratch,
            silence_logs=logging.CRITICAL,
        )
        client = None
        try:
            client = connect(cluster, set_as_default=False)
            client.register_plugin(plugin)
            crew = _Crew(cluster, jobs)
            crew.wait(client)
            yield client
        finally:
            _end(cluster, client)


def _sweep_scratch() -> None:
    """Remove what killed drivers have left in the folder for temporary files."""
    import psutil

    for left in Path(tempfile.gettempdir()).glob(f"{_SCRATCH}*-*"):
        pid = left.name.removeprefix(_SCRATCH).partition("-")[0]
        if pid.isdecimal() and not psutil.pid_exists(int(pid)):
            shutil.rmtree(left, ignore_errors=True)


class _Crew:
    """Keeps as many workers as are wanted.

    Dask starts a killed worker anew, but gives up on one that is killed while it starts, or is slow to come back.
    """

    #: Seconds between two looks, and how many workers may fail to start, for each wanted, before the first has.
    EVERY_S, FAILURES = 1.0, 10

    def __init__(self, cluster: Any, jobs: int) -> None:
        from tornado.ioloop import PeriodicCallback

        self.cluster, self.jobs, self.failed = cluster, jobs, 0
        self._look = PeriodicCallback(self._mend, 1000.0 * self.EVERY_S)
        cluster.scale(jobs)
        cluster.loop.add_callback(self._look.start)

    def wait(self, client: Any) -> None:
        """Wait for the first worker; OutputError where none ever starts."""
        while not client.nthreads():
            if self.failed > self.FAILURES * self.jobs:
                raise OutputError("no worker process starts on this machine: is it out of memory or processes?")
            time.sleep(0.05)

    def _mend(self) -> None:
        """Replace workers that are gone for good. Runs in the cluster's own thread."""
        from distributed.core import Status

        if self.cluster.status != Status.running:
            self._look.stop()
            return
        for name, nanny in list(self.cluster.workers.items()):
            if nanny.status in (Status.failed, Status.closed):
                del self.cluster.workers[name]
                self.failed += 1
        if len(self.cluster.workers) < self.jobs:
            self.cluster.scale(self.jobs)


@contextlib.contextmanager
def remote(address: str, folder: Path, plugin: Any) -> Iterator[Any]:
    """Use the cluster whose scheduler is at ``address``, its workers set up by ``plugin``; yield its client.

    Certificates for ``tls://`` come from Dask's own configuration. Raises InputError where no scheduler or worker
    answers, or where a worker does not see ``folder``: results are put there by the workers themselves.
    """
    dask = _dask()
    import distributed

    if address.startswith("tls:") and not dask.config.get("distributed.comm.tls.ca-file", None):
        raise InputError(
            f"--scheduler {address}: no certificates are set for TLS",
            remedy="set Dask's comm.tls.ca-file, client.cert and client.key, see docs/sweep.md",
        )
    connect: Any = distributed.Client
    try:
        client = connect(address, set_as_default=False, timeout=10)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(
            f"--scheduler {address}: no scheduler answers ({error})",
            remedy="start one with dask scheduler, see docs/sweep.md",
        ) from None
    try:
        _check_shared(client, folder, address)
        client.register_plugin(plugin)
        yield client
    finally:
        client.close(timeout=1)


def _check_shared(client: Any, folder: Path, address: str) -> None:
    """Every worker must see the file that the driver puts into the folder, and know this version of hf."""
    if not client.nthreads():
        raise InputError(f"--scheduler {address}: it has no worker", remedy="start some with dask worker")
    probe = folder.absolute() / f".probe-{os.getpid()}"
    try:
        probe.write_text("here")
    except OSError as error:
        raise OutputError(f"{probe}: {error.strerror or error}") from error
    try:
        answers = client.run(_sees, str(probe))
    except Exception as error:  # noqa: BLE001 - whatever a foreign worker raises: it cannot do our work
        raise InputError(
            f"--scheduler {address}: a worker cannot load hyperfab ({type(error).__name__}: {error})",
            remedy="install the same version of hf on every worker",
        ) from None
    finally:
        probe.unlink(missing_ok=True)
    blind = sorted(worker for worker, (sees, _) in answers.items() if not sees)
    other = sorted({version for _, version in answers.values()} - {program()})
    if blind:
        raise InputError(
            f"--scheduler {address}: {len(blind)} of {len(answers)} workers do not see {folder}",
            remedy="put --out on a file system that driver and workers share, under the same path",
        )
    if other:
        raise InputError(
            f"--scheduler {address}: workers have hf {', '.join(other)}, this is {program()}",
            remedy="install the same version of hf on every worker",
        )


def _sees(path: str) -> tuple[bool, str]:
    return Path(path).is_file() and os.access(Path(path).parent, os.W_OK), program()


def _dask() -> Any:
    """Import Dask with its talk switched off: what a lost worker means is the engine's to say."""
    import dask

    dask.config.set({"logging": {"distributed": "critical", "tornado": "critical", "asyncio": "critical"}})
    import distributed  # noqa: F401 - its configuration is read at import

    for name in ("distributed", "tornado", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    return dask


def _end(cluster: Any, client: Any) -> None:
    """End the workers and all that they started, at once: nothing that they have not put in its place is kept."""
    interrupted = sys.exc_info()[0] is not None
    if interrupted:
        for nanny in list(cluster.workers.values()):
            nanny.auto_restart = False
        _kill_children()
    with contextlib.suppress(Exception):
        if client is not None:
            client.close(timeout=0.5 if interrupted else 10)
        cluster.close(timeout=0.5 if interrupted else 10)
    if interrupted:
        # Or Dask would wait ten seconds more at exit for a worker that was starting.
        cluster.shutdown_on_close = False
        _kill_children()  # one that was started meanwhile, before it finds its parent gone and says so


def _kill_children() -> None:
    """Kill what this process has started; a worker that is starting is known to no nanny yet, but is our child.

    What tracks semaphores ends by itself.
    """
    import psutil

    for process in psutil.Process().children(recursive=True):
        with contextlib.suppress(psutil.Error):
            if not any("resource_tracker" in word for word in process.cmdline()):
                process.kill()
