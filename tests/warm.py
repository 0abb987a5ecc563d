"""``hf`` without the wait for its imports: a process that has them, and its kernels, forks for each command.

Two thirds of most tests of the command line would be Python loading scipy and numba. The fork goes on as ``python -m
hyperfab`` does once these are loaded: its own arguments, folder, environment and streams, its own end. What the start
itself does is tested on processes that begin from nothing (tests/cli/test_doors.py, tests/cli/test_bad_input.py,
tests/faults).

Run as a program, it serves the commands that come over the socket whose number it is given.
"""

from __future__ import annotations

import atexit
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import NoReturn

ROOT = Path(__file__).resolve().parent.parent


class Ended(subprocess.CompletedProcess[bytes]):
    """How a command ended, and the seconds of the processor it took."""

    cpu_s: float


class Warm:
    """Processes that run ``hf`` at once; one command at a time."""

    def __init__(self) -> None:
        self._ours, theirs = socket.socketpair()
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        with theirs:
            self._server = subprocess.Popen(
                [sys.executable, __file__, str(theirs.fileno())], pass_fds=[theirs.fileno()], env=environment
            )
        self._answers = self._ours.makefile("r")

    @cached_property
    def imports_s(self) -> float:
        """The seconds of the processor until all is loaded: how quick this machine is at present."""
        return float(self._answers.readline())

    def run(self, words: list[str], stdin: bytes, cwd: Path | str, timeout: float) -> Ended:
        """Run one command; raises TimeoutExpired as ``subprocess.run`` does."""
        assert self.imports_s > 0.0  # the first answer, ahead of those to commands
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as said:
            reading, writing = os.pipe()
            # A pipe holds 64 KiB; what is longer comes from a process of its own.
            source = subprocess.Popen(["cat"], stdin=subprocess.PIPE, stdout=writing) if len(stdin) > 60_000 else None
            if source is None:
                os.write(writing, stdin)
            os.close(writing)
            task = {"words": words, "cwd": str(cwd), "environment": {**os.environ, "PYTHONPATH": str(ROOT)}}
            message = json.dumps(task).encode()
            files = [reading, out.fileno(), said.fileno()]
            socket.send_fds(self._ours, [len(message).to_bytes(4, "big")], files)
            self._ours.sendall(message)
            os.close(reading)
            if source is not None:
                source.communicate(stdin)
            pid = int(self._answers.readline())
            self._ours.settimeout(timeout)
            try:
                status, cpu = self._answers.readline().split()
            except TimeoutError:
                os.kill(pid, signal.SIGKILL)
                # A file whose socket has timed out reads no more; the next command is answered in a new one.
                self._ours.settimeout(None)
                self._answers = self._ours.makefile("r")
                self._answers.readline()
                raise subprocess.TimeoutExpired(words, timeout) from None
            finally:
                self._ours.settimeout(None)
            out.seek(0)
            said.seek(0)
            ended = Ended(words, int(status), out.read(), said.read())
            ended.cpu_s = float(cpu)
            return ended

    def close(self) -> None:
        """End the process that holds the imports."""
        self._answers.close()
        self._ours.close()
        self._server.wait()


def _imported() -> None:
    """Load what the commands load."""
    import importlib
    import pkgutil

    import hyperfab

    for module in pkgutil.walk_packages(hyperfab.__path__, "hyperfab."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    import meshio  # noqa: F401 - loaded where a file is written
    import PIL.Image
    import pydantic.type_adapter  # noqa: F401
    import trimesh  # noqa: F401
    from meshio import _cxml  # noqa: F401

    PIL.Image.init()


def _compiled() -> None:
    """Load the kernels that are kept compiled; one that is not, is compiled where it is called."""
    from hyperfab.ahead import all_kernels, listed, read

    for name, one in all_kernels().items():
        made = one.made
        for kinds in listed()[name] if hasattr(made, "targetctx") else ():
            signature = tuple(read(kind) for kind in kinds)
            kept = made._cache.load_overload(signature, made.targetctx)
            if kept is not None:
                made.targetctx.insert_user_function(kept.entry_point, kept.fndesc, [kept.library])
                made.add_overload(kept)


def _serve(number: int) -> None:
    """Fork for each command that comes; returns in the forks, and where none will come any more does not return."""
    link = socket.socket(fileno=number)
    link.sendall(b"%f\n" % time.process_time())
    while True:
        head, files, _flags, _address = socket.recv_fds(link, 4, 3)
        if not head:
            os._exit(0)
        message, size = b"", int.from_bytes(head, "big")
        while len(message) < size:
            message += link.recv(size - len(message))
        pid = os.fork()
        if pid == 0:
            link.close()
            task = json.loads(message)
            for stream, file in enumerate(files):
                os.dup2(file, stream)
                os.close(file)
            os.environ.clear()
            os.environ.update(task["environment"])
            os.chdir(task["cwd"])
            sys.argv[1:] = task["words"]
            return
        for file in files:
            os.close(file)
        link.sendall(b"%d\n" % pid)
        _pid, status, used = os.wait4(pid, 0)
        link.sendall(b"%d %f\n" % (os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime))


def _end(run: Callable[[], None]) -> NoReturn:
    """Run the command and end as Python does, but for letting go of all that is loaded.

    The fork shares that with the process it comes from, and would copy it to mark it as free: four fifths of the time
    that a refused command takes.
    """
    try:
        run()
        status = 0
    except SystemExit as ended:
        status = ended.code or 0
    threading._shutdown()  # type: ignore[attr-defined]
    atexit._run_exitfuncs()
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except OSError:
        status = 120
    os._exit(status)  # what is neither a number nor None is an error of the program


if __name__ == "__main__":
    import gc

    from pictures import blanked

    sys.path[0] = str(ROOT)
    from hyperfab import __main__ as program

    _imported()
    _compiled()
    blanked()
    gc.freeze()
    sys.argv[0] = str(program.__file__)
    _serve(int(sys.argv[1]))
    _end(program.main)
