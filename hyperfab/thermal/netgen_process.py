"""The mesher's process, which can be begun before there is anything to mesh: it imports while the command does."""

from __future__ import annotations

import importlib.util
import subprocess
import sys

_begun: list[subprocess.Popen[bytes]] = []


def present() -> bool:
    """Whether the mesher is installed; some machines have no wheel of it."""
    return importlib.util.find_spec("netgen") is not None


def begin() -> None:
    """Begin the process of the next mesh; it waits for its job."""
    if not _begun and present():
        _begun.append(_started())


def end() -> None:
    """End a process that was begun and not taken."""
    while _begun:
        with _begun.pop() as process:
            process.kill()


def taken() -> subprocess.Popen[bytes]:
    """Return a process that waits for its job: the one that was begun, or a new one."""
    while _begun:
        process = _begun.pop()
        if process.poll() is None:
            return process
    return _started()


def _started() -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "hyperfab.thermal.netgen_worker"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # Ctrl-C reaches the parent alone, which then stops the worker
    )
