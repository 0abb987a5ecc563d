"""What all tests share: the real ``hf`` process, measured data where it is there, and hypothesis profiles."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

# As in `hf` itself: the dense blocks here are too small for threads, which only wait for each other. Before numpy.
os.environ.update(dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1"))

import pytest
from hypothesis import HealthCheck, settings
from pictures import DRAWN, blanked, drawn
from warm import Warm

from hyperfab.numerics.threads import LIMIT, cores

ROOT = Path(__file__).resolve().parent.parent

# Of several workers each has its share of the cores: threads that wait for one another would wait for the others' too.
if "PYTEST_XDIST_WORKER_COUNT" in os.environ:
    share = cores() // int(os.environ["PYTEST_XDIST_WORKER_COUNT"])
    os.environ.setdefault(LIMIT, str(max(1, share)))

settings.register_profile(
    "default",
    deadline=None,
    derandomize=True,
    max_examples=60,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
settings.register_profile("fuzz", settings.get_profile("default"), derandomize=False, max_examples=5000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))

blanked()

# Nothing that the collection makes is let go of: to look for it would be a fifth of its time.
gc.disable()

Run = Callable[..., "subprocess.CompletedProcess[bytes]"]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the longest test, so that at the end no worker waits for it."""
    items.sort(key=lambda item: item.name != "test_shell_blocks_run[README.md]")


def pytest_collection_finish() -> None:
    """Look for what is let go of from now on, among what the tests make."""
    gc.enable()
    gc.freeze()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Draw the pictures of a test as it needs them."""
    how = drawn(item)
    if how is None:
        os.environ.pop(DRAWN, None)
    else:
        os.environ[DRAWN] = how


@pytest.fixture(scope="session")
def root() -> Path:
    """The checkout."""
    return ROOT


@pytest.fixture(scope="session")
def warm() -> Iterator[Warm]:
    """A process that has the imports of ``hf`` behind it and forks for each command."""
    server = Warm()
    yield server
    server.close()


@pytest.fixture(scope="session")
def hf(warm: Warm) -> Run:
    """Run the real command in a process of its own: ``hf("fit", ..., stdin=b"...", cwd=folder)``.

    With an environment of its own it begins from nothing; else it is forked where its imports are done.
    """

    def run(
        *arguments: object,
        stdin: bytes = b"",
        cwd: Path | str = ROOT,
        env: dict[str, str] | None = None,
        timeout: float = 120,
    ) -> subprocess.CompletedProcess[bytes]:
        words = [str(argument) for argument in arguments]
        if env is None:
            return warm.run(words, stdin, cwd, timeout)
        command = [sys.executable, "-m", "hyperfab", *words]
        environment = {**os.environ, "PYTHONPATH": str(ROOT), **env}
        return subprocess.run(
            command, input=stdin, capture_output=True, cwd=cwd, env=environment, timeout=timeout, check=False
        )

    return run


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of measured data, which is not part of the repository (HYPERFAB_DATA names it)."""
    folder = Path(os.environ.get("HYPERFAB_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip("measured data not here: set HYPERFAB_DATA to the folder that holds treloar-1944/ and others")
    return folder
