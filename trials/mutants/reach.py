"""Which function of the program each test reaches: a pytest plugin, and the same in every ``hf`` that a test starts.

Only the first call of a function in a test is told, by a trace function that asks for no lines: the suite takes about
a fifth longer. What a fixture of a file or session calls counts for every test that asks for it.
"""

from __future__ import annotations

import fcntl
import json
import os
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

#: Environment: the folder whose functions are told, the file they are told in, and for whom.
TREE, TOLD, WHO = "HF_REACH_TREE", "HF_REACH_TOLD", "HF_REACH_WHO"

_seen: dict[int, CodeType] = {}


def watch() -> None:
    """Tell every function of the program that is called from now on, if the environment asks for it."""
    if TOLD not in os.environ:
        return
    prefix = os.environ[TREE].rstrip("/") + "/hyperfab/"
    seen, write = _seen, os.write  # as they are now: tests put a full disk in the place of the system's own
    low = os.open(os.environ[TOLD], os.O_APPEND | os.O_CREAT | os.O_WRONLY)
    # High up: some tests start `hf` without a standard output, whose number it must not take.
    told = fcntl.fcntl(low, fcntl.F_DUPFD_CLOEXEC, 100)
    os.close(low)

    def trace(frame: FrameType, _event: str, _argument: Any) -> None:
        code = frame.f_code
        if seen is None or id(code) in seen:  # None: the interpreter is being taken down
            return
        seen[id(code)] = code  # held, so that no other code gets its number
        if code.co_filename.startswith(prefix):
            path = "hyperfab/" + code.co_filename[len(prefix) :]
            who = os.environ.get(WHO, "").encode("unicode_escape")
            write(told, who + f"\t{path}\t{code.co_qualname}\n".encode())

    sys.settrace(trace)
    threading.settrace(trace)


def _now(who: str) -> None:
    os.environ[WHO] = who
    _seen.clear()


try:
    import pytest
except ImportError:  # in an `hf` process of an environment without the tests' tools
    pass
else:

    @pytest.hookimpl(hookwrapper=True)
    def pytest_fixture_setup(fixturedef: Any) -> Iterator[None]:
        before = os.environ.get(WHO, "")
        if fixturedef.scope != "function":
            _now(f"fixture {fixturedef.baseid} {fixturedef.argname}")
        yield
        if fixturedef.scope != "function":
            _now(before)

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(item: Any) -> Iterator[None]:
        _now(item.nodeid)
        start = time.process_time() + sum(os.times()[2:4])
        yield
        seconds = time.process_time() + sum(os.times()[2:4]) - start
        fixtures = [
            f"fixture {definition.baseid} {definition.argname}"
            for name in item.fixturenames
            for definition in item.session._fixturemanager.getfixturedefs(name, item) or ()
        ]
        with open(os.environ[TOLD] + ".tests", "a", encoding="utf-8") as stream:
            stream.write(json.dumps([item.nodeid, seconds, fixtures]) + "\n")
        _now("")

    def pytest_runtest_logreport(report: Any) -> None:
        if report.failed or report.skipped:
            with open(os.environ[TOLD] + ".not-passed", "a", encoding="utf-8") as stream:
                stream.write(f"{report.nodeid}\n")


def read(told: Path) -> dict[str, dict[str, Any]]:
    """What the files say: by test its CPU ``seconds`` and the functions it ``reaches`` ("path qualname"), sorted."""
    functions: dict[str, set[str]] = {}
    if not Path(f"{told}.tests").exists():  # a file that is skipped as a whole
        return {}
    for line in told.read_text(encoding="utf-8").splitlines():
        who, path, name = line.split("\t")
        functions.setdefault(who.encode().decode("unicode_escape"), set()).add(f"{path} {name}")
    beside = Path(f"{told}.not-passed")
    not_passed = set(beside.read_text(encoding="utf-8").splitlines()) if beside.exists() else set()
    tests: dict[str, dict[str, Any]] = {}
    for line in Path(f"{told}.tests").read_text(encoding="utf-8").splitlines():
        test, seconds, fixtures = json.loads(line)
        if test not in not_passed:
            reached = functions.get(test, set()).union(*(functions.get(name, set()) for name in fixtures))
            tests[test] = {"seconds": round(seconds, 3), "reaches": sorted(reached)}
    return tests
