"""Functions that are compiled: what marks them, and who says that one is being compiled.

Neither loads numba, which takes a quarter of a second: the first kernel that is called does (``jit.py``).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, update_wrapper
from typing import Any

# Kept on disk. Division by zero gives inf, as numpy has it; nothing here is called from C. Threads run side by side
# in kernels (see threads.py).
_KERNEL: dict[str, Any] = {"error_model": "numpy", "no_cfunc_wrapper": True, "nogil": True}
_PART: dict[str, Any] = {**_KERNEL, "no_cpython_wrapper": True}
_INLINED: dict[str, Any] = {**_PART, "forceinline": True}
# Sums whose terms may be added in any order, several at once: nothing else is taken for exact that is not.
_SUMMED: dict[str, Any] = {**_PART, "fastmath": {"reassoc": True, "nsz": True, "contract": True}}

#: Whether the package is being built: what is compiled then is kept in it.
building = False
_announce: Callable[[], None] | None = None


class Kernel:
    """A ``function`` that is compiled, or what was is loaded, when it is first called."""

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        update_wrapper(self, function)
        self.function, self.options = function, options

    @cached_property
    def made(self) -> Any:
        """The dispatcher that numba makes of the function."""
        from hyperfab.numerics.jit import compiled  # a quarter of a second: commands that call no kernel spare it

        return compiled(self.function, self.options)

    def __call__(self, *given: Any) -> Any:
        """Call the compiled function."""
        return self.made(*given)


#: All that Python calls, by module and name.
KERNELS: dict[str, Kernel] = {}


def kernel(function: Any) -> Any:
    """Decorate a function called from Python.

    >>> import numpy as np
    >>> @kernel
    ... def double(values):
    ...     return 2.0 * values
    >>> double(np.array([1.0, 2.0]))
    array([2., 4.])
    """
    made = KERNELS[f"{function.__module__}.{function.__name__}"] = Kernel(function, _KERNEL)
    return made


def part(function: Any) -> Any:
    """Decorate a function called from kernels alone.

    Nothing is compiled for Python to call it by, which takes a tenth off the time to compile.
    """
    return Kernel(function, _PART)


def inlined(function: Any) -> Any:
    """Decorate a few lines called from the innermost loops of kernels, to become part of these."""
    return Kernel(function, _INLINED)


def summed(function: Any) -> Any:
    """Decorate a function called from kernels whose sums may be added up in any order: processors take four terms at
    once, by the same code on each of them."""
    return Kernel(function, _SUMMED)


def announced_by(announce: Callable[[], None] | None) -> None:
    """Let ``announce`` be called when a kernel that is kept nowhere is about to be compiled; once."""
    global _announce
    _announce = announce


def begins() -> None:
    """Say that a kernel is about to be compiled.

    >>> announced_by(lambda: print("compiling"))
    >>> begins()
    compiling
    >>> begins()
    """
    global _announce
    announce, _announce = _announce, None
    if announce is not None:
        announce()
