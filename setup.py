"""The build of the package: beside what pyproject.toml says, kernels are compiled ahead (hyperfab/ahead.py)."""

from __future__ import annotations

import os
import subprocess
import sys

from setuptools import setup
from setuptools.command.build_py import build_py


class BuildWithKernels(build_py):
    """Copies the modules, and compiles the kernels that commands are known to call into the copy.

    Not where the package stays in its source folder, nor with HYPERFAB_AHEAD=0. What cannot be compiled here is
    compiled when it is first called.
    """

    def run(self) -> None:
        """Copy and compile."""
        super().run()
        if self.editable_mode or os.environ.get("HYPERFAB_AHEAD") == "0":
            return
        paths = [os.path.abspath(self.build_lib), *(path for path in sys.path if path)]
        done = subprocess.run(
            [sys.executable, "-m", "hyperfab.ahead"],
            env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
            cwd=self.build_lib,
            check=False,
        )
        if done.returncode != 0:
            self.warn("no kernels were compiled ahead: the first runs will compile them")


setup(cmdclass={"build_py": BuildWithKernels})
