"""Files that appear whole or not at all, whatever kills the program."""

from __future__ import annotations

import contextlib
import errno
import os
import signal
import stat
import threading
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

from hyperfab.errors import OutputError
from hyperfab.system import ALARM, BINARY, sync_folder

#: Bytes between two looks at whether the user pressed Ctrl-C.
CHUNK = 2**20

_REMEDIES = {
    getattr(errno, "EDQUOT", errno.ENOSPC): "free some of your quota or choose another folder",
    errno.ENOSPC: "free some space or choose another folder",
    errno.EFBIG: "raise the file size limit or choose another folder",
    errno.EROFS: "choose a folder that can be written",
    errno.EACCES: "choose a folder you may write to",
    errno.EPERM: "choose a folder you may write to",
    errno.ENOENT: "make the folder first",
    errno.ENAMETOOLONG: "choose a shorter name",
}


def write_files(files: Iterable[tuple[str | Path, bytes]]) -> None:
    """Write all of ``files``, (path, contents) each, or none.

    Every file is first written under a hidden name in its own folder and forced to disk; only when all are there do
    they take their places, in the order given (put the document that lists the others last). A process killed at any
    moment leaves under each name the old file or the new one, whole. Where anything fails, what was there before is
    put back, nothing new stays, and OutputError names the file and the reason. An existing link is followed.

    SIGINT and SIGTERM are obeyed up to the moment the files take their places, and then again right after it.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_files([(Path(folder) / "a.csv", b"1"), (Path(folder) / "a.json", b"{}")])
    ...     sorted(os.listdir(folder))
    ['a.csv', 'a.json']
    """
    with _signals_held() as check:
        batch = _Batch()
        try:
            for name, data in files:
                batch.stage(Path(name), data, check)
            check()
            batch.commit()
        except BaseException:
            batch.undo()
            raise
        batch.forget()


class _Batch:
    """The files of one call: staged under hidden names, then moved into place, or taken back."""

    def __init__(self) -> None:
        self._staged: list[tuple[Path, Path, Path]] = []  # (name to show, target, temporary)
        self._backups: dict[Path, Path] = {}
        self._placed: list[Path] = []

    def stage(self, name: Path, data: bytes, check: Any) -> None:
        with _told(name):
            target = _target(name)
            if any(target == other for _, other, _ in self._staged):
                raise ValueError(f"{name} stands twice among the files to write")
            descriptor, temporary = _create_hidden(target)
            self._staged.append((name, target, temporary))
            try:
                view = memoryview(data)
                while view:
                    check()
                    view = view[os.write(descriptor, view[:CHUNK]) :]
                os.fsync(descriptor)
            finally:
                os.close(descriptor)

    def commit(self) -> None:
        for name, target, _ in self._staged:
            with _told(name):
                self._keep_old(target)
        for name, target, temporary in self._staged:
            with _told(name):
                os.replace(temporary, target)
                self._placed.append(target)
        for folder in sorted({target.parent for _, target, _ in self._staged}):
            with _told(folder):
                sync_folder(folder)

    def _keep_old(self, target: Path) -> None:
        """Give the file that will be replaced a second, hidden name, to put it back should a later file fail."""
        if not target.exists():
            return
        for backup in _hidden_names(target, "old"):
            try:
                os.link(target, backup)
            except FileExistsError:
                continue
            except OSError:  # no hard links here (FAT, some network shares): copy
                self._backups[target] = backup
                backup.write_bytes(target.read_bytes())
            self._backups[target] = backup
            return

    def undo(self) -> None:
        for target in self._placed:
            with contextlib.suppress(OSError):
                if target in self._backups:
                    os.replace(self._backups.pop(target), target)
                else:
                    os.unlink(target)
        self.forget()

    def forget(self) -> None:
        """Remove the hidden names. A file that took its place has none left."""
        for path in [temporary for _, _, temporary in self._staged] + list(self._backups.values()):
            with contextlib.suppress(OSError):
                os.unlink(path)


def _target(name: Path) -> Path:
    target = Path(os.path.realpath(name))
    with contextlib.suppress(FileNotFoundError):
        if not stat.S_ISREG(target.stat().st_mode):
            raise OutputError(f"{name}: is no ordinary file and is not overwritten; choose another name")
    return target


def _create_hidden(target: Path) -> tuple[int, Path]:
    """Create a file of a name nobody has, in the target's folder; the umask decides its mode."""
    for path in _hidden_names(target, "tmp"):
        with contextlib.suppress(FileExistsError):
            return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | BINARY, 0o666), path
    raise OSError(errno.EEXIST, "too many temporary files were left in the folder")


def _hidden_names(target: Path, ending: str) -> Iterator[Path]:
    for attempt in range(1000):
        yield target.with_name(f".{target.name[:50]}.{os.getpid()}-{attempt}.{ending}")


@contextlib.contextmanager
def _told(name: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        remedy = _REMEDIES.get(error.errno or 0, "check the disk")
        reason = error.strerror or str(error)
        raise OutputError(
            f"{name}: {reason}; nothing was written, what was there before is unchanged; {remedy}"
        ) from error


@contextlib.contextmanager
def _signals_held() -> Iterator[Any]:
    """Collect SIGINT and SIGTERM; the ``check`` handed out lets a collected one act.

    An exception raised by a signal handler between two renames would leave a half-replaced set of files.
    """
    if threading.current_thread() is not threading.main_thread():
        yield lambda: None
        return
    pending: list[tuple[int, FrameType | None]] = []
    previous: dict[int, Any] = {}

    def check() -> None:
        if pending:
            number, frame = pending.pop(0)
            previous[number](number, frame)

    for number in (int(signal.SIGINT), int(signal.SIGTERM), *(() if ALARM is None else (ALARM,))):
        if callable(signal.getsignal(number)):
            previous[number] = signal.signal(number, lambda signum, frame: pending.append((signum, frame)))
    try:
        yield check
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
    check()
