"""How kernels are compiled: those that Python calls, and those that only other kernels call."""

from __future__ import annotations

from typing import Any

from numba import njit

# Kept on disk. Division by zero gives inf, as numpy has it; nothing here is called from C. Threads run side by side
# in kernels (see threads.py).
_KERNEL: dict[str, Any] = {
    "cache": True,
    "error_model": "numpy",
    "no_cfunc_wrapper": True,
    "nogil": True,
}
_PART: dict[str, Any] = {**_KERNEL, "no_cpython_wrapper": True}
_INLINED: dict[str, Any] = {**_PART, "forceinline": True}

#: Decorates a function called from Python.
kernel: Any = njit(**_KERNEL)

#: Decorates a function called from kernels alone. Nothing is compiled for Python to call it by, which takes a tenth
#: off the first run.
part: Any = njit(**_PART)

#: Decorates a few lines called from the innermost loops of kernels, to become part of these.
inlined: Any = njit(**_INLINED)
