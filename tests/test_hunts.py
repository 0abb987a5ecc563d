"""The hunts of ``make hunt`` go with the program: each builds all of its cases."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
HUNTS = sorted(path.stem for path in (ROOT / "trials").glob("hunt_*.py"))


@pytest.mark.parametrize("hunt", HUNTS)
def test_a_hunt_that_is_asked_for_no_case_builds_them_all(hunt: str) -> None:
    path = os.pathsep.join((str(ROOT), str(ROOT / "tests")))
    call = [sys.executable, "-m", f"trials.{hunt}", "a case of no such name"]
    done = subprocess.run(call, cwd=ROOT, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("0 inputs of ")
