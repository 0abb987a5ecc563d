"""What differs between operating systems: flags of files, the alarm, syncing of folders. POSIX and Windows."""

from __future__ import annotations

import errno
import os
import signal
import sys
from pathlib import Path
from typing import Any

# Attributes that one system has and another lacks are asked for by name, so that every system takes the same way here.
#: For ``os.open``: bytes as they are (Windows would turn LF into CR LF), and no child process inherits the file.
BINARY: int = getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
#: For ``os.open``: do not wait for somebody to write to a named pipe. Windows has none among its files.
AT_ONCE: int = getattr(os, "O_NONBLOCK", 0)
#: The signal of ``alarm``; None where the system has no timer that signals.
ALARM: int | None = getattr(signal, "SIGALRM", None)
_set_timer: Any = getattr(signal, "setitimer", None)
_set_blocking: Any = getattr(os, "set_blocking", None)


def alarm(seconds: float) -> None:
    """Send ``ALARM`` to this process after so many seconds, 0 for never; nothing where the system has no alarm."""
    if _set_timer is not None:
        _set_timer(0, seconds)  # 0: ITIMER_REAL, the wall clock


def wait_for_bytes(descriptor: int) -> None:
    """Let reads from a file opened with ``AT_ONCE`` wait for what comes."""
    if AT_ONCE and _set_blocking is not None:
        _set_blocking(descriptor, True)


def sync_folder(folder: Path) -> None:
    """Write a folder's entries to disk; Windows keeps them by itself.

    Raises OSError where the disk fails.
    """
    flag: int = getattr(os, "O_DIRECTORY", 0)
    if not flag:
        return
    descriptor = os.open(folder, os.O_RDONLY | flag | BINARY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):  # file systems that cannot sync a folder
            raise
    finally:
        os.close(descriptor)


def die_with_parent() -> None:
    """Ask the system to end this process when its parent ends, however that happens; Linux alone can."""
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(1, signal.SIGKILL)
        if os.getppid() == 1:
            os._exit(1)
