"""Kernels that the build compiles ahead, and which compiled kernel holds for which code."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest

from hyperfab.ahead import all_kernels, listed, read, written
from hyperfab.numerics import jit, kernels
from trials.kernels import FILES, LINES, ends

ROOT = Path(__file__).resolve().parents[1]


class Uniform(NamedTuple):
    one: np.ndarray
    two: np.ndarray


class Mixed(NamedTuple):
    number: float
    inner: Uniform
    rest: tuple[np.ndarray, int]


def python(folder: Path, text: str, *words: str, **env: str) -> subprocess.CompletedProcess[str]:
    """Run a script with a cache of its own in ``folder``."""
    return subprocess.run(
        [sys.executable, "-c", text, *words],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": f"{ROOT}{os.pathsep}{folder}", "NUMBA_CACHE_DIR": str(folder / "cache")} | env,
        capture_output=True,
        text=True,
        check=False,
    )


def test_every_kernel_is_listed_with_its_types() -> None:
    # A kernel that Python calls and that the build leaves out would be compiled in the first run of a command.
    have = listed()
    assert sorted(have) == sorted(all_kernels())
    assert [name for name, forms in have.items() if not forms] == []
    for name, made in all_kernels().items():
        for form in have[name]:
            assert len(form) == made.function.__code__.co_argcount, f"{name}: make kernels"
            assert [written(read(kind)) for kind in form] == form


def test_every_kernel_that_is_listed_is_found_by_a_build(tmp_path: Path) -> None:
    # In a process of its own: here the tests have imported what a build must find by itself.
    done = python(tmp_path, "from hyperfab.ahead import all_kernels; print(*all_kernels())")
    assert done.stdout.split() == sorted(listed())


@pytest.mark.skipif(not jit.AHEAD.is_dir(), reason="the kernels of the build are not here: make .venv/dev")
def test_the_build_has_compiled_every_kernel_that_is_listed() -> None:
    compiled = {path.name.partition(".py3")[0] for path in jit.AHEAD.glob("*.nbi")}
    assert [name for name in listed() if name.removeprefix("hyperfab.") not in compiled] == []


@pytest.mark.parametrize(
    "value",
    [
        1.0,
        True,
        np.zeros((2, 3)),
        np.zeros((2, 3)).T,
        np.zeros((4, 4), np.float32)[::2],
        np.zeros(3, np.uint8),
        np.zeros(3, bool),
        np.zeros(2, complex),
        np.broadcast_to(np.zeros(3), (2, 3)),
        (np.zeros(2), np.zeros(2)),
        (np.zeros(2), 1),
        Uniform(np.zeros(2), np.zeros(2)),
        Mixed(1.0, Uniform(np.zeros(2), np.zeros(2)), (np.zeros(2), 3)),
    ],
)
def test_types_are_read_as_they_were_written(value: object) -> None:
    kind = numba.typeof(value)
    assert read(written(kind)) == kind


USES = """
from hyperfab.numerics.kernels import kernel
from called import called, FACTOR
@kernel
def caller(x):
    return FACTOR * called(x)
"""
CALLED = """
from hyperfab.numerics.kernels import part
FACTOR = {factor}
@part
def called(x):
    return x + {added}
"""
ASKS = "from uses import caller; print(caller(1.0))"


@pytest.mark.slow
def test_a_kernel_is_compiled_anew_when_what_it_calls_changes(tmp_path: Path) -> None:
    # The caller's own file stays: by it alone the old code, with the old callee inside, would be taken.
    (tmp_path / "uses.py").write_text(USES)
    for factor, added, answer in ((1.0, 1.0, 2.0), (1.0, 2.0, 3.0), (2.0, 2.0, 6.0), (2.0, 2.0, 6.0)):
        (tmp_path / "called.py").write_text(CALLED.format(factor=factor, added=added))
        done = python(tmp_path, ASKS, PYTHONDONTWRITEBYTECODE="1")
        assert done.stdout == f"{answer}\n", done.stderr


def test_so_it_is_when_what_it_calls_stands_below_it(tmp_path: Path) -> None:
    # While its own lines are read, what stands below is not there: it cannot be known by that then.
    below = CALLED.split("\n", 2)[2].format(factor=1.0, added="{added}")
    for added, answer in ((1.0, 2.0), (2.0, 3.0)):
        text = USES.replace("from called import called, FACTOR\n", "from hyperfab.numerics.kernels import part\n")
        (tmp_path / "uses.py").write_text(text + below.format(added=added))
        done = python(tmp_path, ASKS, PYTHONDONTWRITEBYTECODE="1")
        assert done.stdout == f"{answer}\n", done.stderr


def test_a_kernel_is_known_by_its_code_alone(tmp_path: Path) -> None:
    (tmp_path / "called.py").write_text(CALLED.format(factor=1.0, added=1.0))
    says = "from uses import caller; print(caller.made._cache.digest)"
    digests = []
    for text in (USES, "\n\n# moved\n" + USES, USES.replace("FACTOR *", "FACTOR +")):
        (tmp_path / "uses.py").write_text(text)
        done = python(tmp_path, says, PYTHONDONTWRITEBYTECODE="1")
        assert done.returncode == 0, done.stderr
        digests.append(done.stdout)
    assert digests[0] == digests[1] != digests[2]


def test_a_kernel_is_known_by_what_it_puts_in_as_machine_code() -> None:
    digests = []
    for text in ("fadd", "fsub"):

        def code(context: object, x: object, text: str = text) -> object:
            return x(x), lambda _, builder, __, given: getattr(builder, text)(given[0], given[0])

        twice = numba.extending.intrinsic(code)

        def uses(x: float) -> float:
            return twice(x)  # noqa: B023

        digests.append(kernels.kernel(uses).made._cache.digest)
    assert digests[0] != digests[1]


def test_a_kernel_that_names_what_nobody_watches_is_refused() -> None:
    table = {"a": 1.0}

    def reads(x: float) -> float:
        return x + table["a"]

    with pytest.raises(TypeError, match="whose change nothing would notice"):
        kernels.kernel(reads)(1.0)


BUILDS = """
import sys
from pathlib import Path
from hyperfab.numerics import jit, kernels
jit.AHEAD = Path("ahead")
jit.AHEAD.mkdir(exist_ok=True)
kernels.building = sys.argv[1] == "build"
kernels.announced_by(lambda: print("compiling"))
from hyperfab.ahead import compile_some
if kernels.building:
    compile_some(["hyperfab.cloth.linear._products"])
else:
    import numpy as np
    from hyperfab.cloth.linear import dot  # the kernel that it calls
    print(dot(np.full((3, 3, 3), 2.0), np.ones((3, 3, 3))))
"""


@pytest.mark.slow
def test_a_kernel_of_the_build_is_taken_where_it_is_whole_and_for_this_processor(tmp_path: Path) -> None:
    def used(cache: str, **env: str) -> str:
        done = python(tmp_path, BUILDS, "use", NUMBA_CACHE_DIR=str(tmp_path / cache), **env)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert used("before") == "compiling\n54.0\n"
    assert python(tmp_path, BUILDS, "build").returncode == 0
    assert used("empty") == "54.0\n"
    assert used("other", NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES="") == "compiling\n54.0\n"
    for path in (tmp_path / "ahead").glob("*.nbc"):
        path.unlink()
    assert used("damaged") == "compiling\n54.0\n"


def test_where_nothing_may_be_written_kernels_are_compiled_each_time(tmp_path: Path) -> None:
    nowhere = (
        "from numba.core.caching import CacheImpl; CacheImpl._locator_classes = []\n"
        "import hyperfab.numerics.kernels as k\n"
        "@k.kernel\ndef twice(x):\n    return 2.0 * x\n"
        "print(twice(2.0))"
    )
    done = python(tmp_path, nowhere)
    assert done.stdout == "4.0\n", done.stderr


#: Runs commands one after another, and says after each how it ended and which kernels were called and are not listed.
CALLS = """
import json, sys
from hyperfab.ahead import all_kernels, listed, written
from hyperfab.cli import main
have, kernels, seen = listed(), all_kernels(), set()
for line in json.loads(sys.argv[1]):
    sys.argv = ["hf", *line.split()]
    try:
        main()
    except SystemExit as end:
        status = int(end.code or 0)
    called = {(name, json.dumps([written(kind) for kind in kinds]))
              for name, made in kernels.items() for kinds in made.made.signatures}
    missing = [one for one in sorted(called - seen) if json.loads(one[1]) not in have.get(one[0], [])]
    seen |= called
    print("\\n" + json.dumps([line, status, missing]), flush=True)
assert seen
"""


@pytest.mark.slow
def test_what_every_command_calls_is_listed(tmp_path: Path) -> None:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    lines = ["sample .", *LINES]
    done = subprocess.run(
        [sys.executable, "-c", CALLS, json.dumps(lines)],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    told = [json.loads(text) for text in done.stdout.splitlines() if text.startswith("[")]
    assert [line for line, _, _ in told] == lines
    for line, status, missing in told:
        assert status in ends(line), (line, done.stderr)
        assert missing == [], line
