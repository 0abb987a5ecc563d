"""The mesher's process, which can be begun before its mesh is asked for: it works while the command imports."""

from __future__ import annotations

import contextlib
import importlib.util
import subprocess
import sys
import threading
from typing import IO

#: The process that was begun, and the job that it was given: none yet where that is empty.
_begun: list[tuple[subprocess.Popen[bytes], bytes]] = []


def present() -> bool:
    """Whether the mesher is installed; some machines have no wheel of it."""
    return importlib.util.find_spec("netgen") is not None


def begin(job: bytes = b"") -> None:
    """Begin the process of the next mesh: it goes to work on its ``job``, or waits for one."""
    if present():
        _begun.append((taken(job), job))


def end() -> None:
    """End a process that was begun and not taken."""
    while _begun:
        _ended(_begun.pop()[0])


def taken(job: bytes) -> subprocess.Popen[bytes]:
    """Return a process that works on ``job``: the one that was begun, or a new one."""
    process, work = _begun.pop() if _begun else (_started(), b"")
    if work and work == job:
        return process
    if work or process.poll() is not None:
        _ended(process)
        process = _started()
    if job:
        # A thread feeds the job: communicate() forgets the rest of its input when asked again after a timeout.
        threading.Thread(target=_feed, args=(process.stdin, job), daemon=True).start()
        process.stdin = None  # the thread's to close
    return process


def _feed(stream: IO[bytes], job: bytes) -> None:
    """Write the job and close the pipe; a worker that ended early has closed its side."""
    with contextlib.suppress(BrokenPipeError), stream:
        stream.write(job)


def _ended(process: subprocess.Popen[bytes]) -> None:
    with process:
        process.kill()


def _started() -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "hyperfab.thermal.netgen_worker"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # Ctrl-C reaches the parent alone, which then stops the worker
    )
