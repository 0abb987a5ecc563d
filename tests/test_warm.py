"""The process that holds the imports of the commands under test."""

from __future__ import annotations

import subprocess

import pytest
from conftest import Run


def test_a_command_that_takes_too_long_takes_no_other_with_it(hf: Run) -> None:
    with pytest.raises(subprocess.TimeoutExpired):
        hf("fit", "-", timeout=1e-6)
    assert hf("--version").returncode == 0
