"""A copy of the program and its tests in which defects are planted, with what numba has compiled kept beside it."""

from __future__ import annotations

import importlib
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import NoReturn

ROOT = Path(__file__).resolve().parents[2]
#: Every file of the copy is of this time, and a planted defect of a later one: compiled code of neither passes for
#: the other's.
EPOCH = 1_700_000_000

_START = """import os

if "HF_REACH_TOLD" in os.environ:
    from trials.mutants import reach

    reach.watch()
"""


def copy(tree: Path) -> None:
    """Make ``tree`` hold the files of this checkout as they are now; what was compiled for unchanged ones stays."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        check=True,
    )
    names = {name for name in listed.stdout.decode().splitlines() if (ROOT / name).is_file()}
    for old in tree.rglob("*"):
        inside = old.relative_to(tree).as_posix()
        if old.is_file() and "__pycache__" not in inside and inside not in names and inside != "sitecustomize.py":
            old.unlink()
    changed = False
    for name in sorted(names):
        target = tree / name
        content = (ROOT / name).read_bytes()
        if target.exists() and target.read_bytes() == content:
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, target)
        os.utime(target, (EPOCH, EPOCH))
        changed = changed or name.startswith("hyperfab/")
    if changed:  # a kernel holds what it calls in other files: all of it is compiled anew
        for folder in tree.glob("hyperfab/**/__pycache__"):
            shutil.rmtree(folder)
    (tree / "sitecustomize.py").write_text(_START, encoding="utf-8")


def _environment(tree: Path) -> dict[str, str]:
    data = os.environ.get("HYPERFAB_DATA", str(ROOT.parent / "shared" / "data"))
    return {
        "PYTHONPATH": str(tree),
        "HYPERFAB_DATA": data,
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_NUM_THREADS": "1",
    }


def started(tree: Path, arguments: list[str], environment: dict[str, str], **more: object) -> subprocess.Popen[bytes]:
    """Start the tests named, in the copy, one process, in a group of their own."""
    command = [sys.executable, "-m", "pytest", "-p", "no:xdist", "-p", "no:cacheprovider", *arguments]
    own = {**os.environ, **_environment(tree), **environment}
    return subprocess.Popen(command, cwd=tree, env=own, start_new_session=True, **more)  # type: ignore[call-overload]


def forked(tree: Path, arguments: list[str], seconds: int) -> tuple[int | None, str]:
    """Run the tests named, in the copy, in a fork of this process, and return its status (None: no end) and output.

    What others wrote (numpy, scipy, numba, pytest) is imported once for all: half of what a quick test takes.
    """
    _warm(tree)
    said = tree.parent / "said"
    child = os.fork()
    if child == 0:
        _asked(tree, arguments, seconds, said)
    end = time.monotonic() + 10.0 * seconds
    while True:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status), said.read_text(encoding="utf-8", errors="replace")
        if time.monotonic() > end:
            os.killpg(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return None, ""
        time.sleep(0.02)


def _warm(tree: Path) -> None:
    os.environ.update(_environment(tree))
    for name in ("numpy", "scipy.sparse.linalg", "scipy.optimize", "scipy.interpolate", "scipy.spatial", "scipy.stats",
                 "scipy.integrate", "numba", "pydantic", "pytest", "hypothesis.strategies", "typer"):  # fmt: skip
        importlib.import_module(name)


def _asked(tree: Path, arguments: list[str], seconds: int, said: Path) -> NoReturn:
    """What the fork does; never returns."""
    status = 3
    try:
        os.setsid()
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        out = os.open(said, os.O_CREAT | os.O_TRUNC | os.O_WRONLY)
        os.dup2(out, 1)
        os.dup2(out, 2)
        os.chdir(tree)
        os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
        sys.dont_write_bytecode = True
        sys.path[:] = [str(tree), *(place for place in sys.path if place not in ("", str(ROOT)))]
        import pytest

        status = int(pytest.main(["-p", "no:xdist", "-p", "no:cacheprovider", *arguments]))
        sys.stdout.flush()
    finally:
        os._exit(status)
