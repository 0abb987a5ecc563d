"""How kernels are compiled, and where the compiled ones are kept: what loads numba.

Kernels that commands are known to call are compiled when the package is built (``ahead.py``) and lie in
``hyperfab/compiled``. They serve where Python and numba are those of the build, on any processor of the same level;
everything else is compiled when it is first called, and kept where numba keeps such things. Either is known by a
digest of its own code and of all it calls: not by the time of a file.
"""

from __future__ import annotations

import hashlib
import platform
import sys
from collections.abc import Iterator
from functools import cached_property
from importlib import import_module
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import llvmlite.binding as llvm
import numpy as np
from numba import njit
from numba.core.typing.typeof import typeof_impl

from hyperfab.numerics import kernels

# Of any type: numba's own annotations reach only so far.
_caching: Any = import_module("numba.core.caching")
_runtime: Any = import_module("numba.core.runtime.nrt").rtsys
_config: Any = import_module("numba.core.config")
_intrinsic: Any = import_module("numba.core.extending")._Intrinsic

#: Where the kernels lie that were compiled at the build.
AHEAD = Path(__file__).resolve().parent.parent / "compiled"
#: What a processor of the level x86-64-v3 has: all but the oldest and smallest of the last ten years. What is compiled
#: for the level runs on each of them, bit for bit alike, as fast as what is compiled for the one at hand.
_LEVEL = "x86-64-v3"
_NEEDS = ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sse4.2", "xsave")


def compiled(function: Any, options: dict[str, Any]) -> Any:
    """Return what calls a function compiled, by the ``options`` of ``numba.njit``."""
    made = njit(**options)(function)
    if hasattr(made, "py_func"):  # not where NUMBA_DISABLE_JIT leaves the function as it is
        made._cache = Kept(function, options)
    return made


class Kept(_caching.FunctionCache):  # type: ignore[misc]
    """The compiled forms of one kernel: those of the build, which are looked for first, and those of this machine.

    While the package is built, ``kernels.building`` is set and what is compiled goes to the first.
    """

    def __init__(self, function: Any, options: dict[str, Any]) -> None:
        self._function, self._options = function, options
        self._from_python = not options.get("no_cpython_wrapper", False)
        try:
            super().__init__(function)
            del self._cache_file  # numba's is known by the time of the file: the next one asked for is not
        except RuntimeError:  # no folder at all that may be written: compiled anew each time
            self._enabled = False

    @cached_property
    def digest(self) -> str:
        """What tells this code from any other: asked for once all that it calls is there, if further down its file."""
        return _digest(self._function, self._options)

    @cached_property
    def _ahead(self) -> Any:
        function = self._function
        python = f"py{sys.version_info[0]}{sys.version_info[1]}{sys.abiflags if hasattr(sys, 'abiflags') else ''}"
        name = f"{function.__module__.removeprefix('hyperfab.')}.{function.__qualname__}.{python}"
        return _caching.IndexDataCacheFile(str(AHEAD), name, self.digest)

    @cached_property
    def _cache_file(self) -> Any:
        return _caching.IndexDataCacheFile(self._cache_path, self._impl.filename_base, self.digest)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return what is kept for a signature, None where it must be compiled."""
        found = self._ahead.load(self._index_key(sig, target_context.codegen()))
        if found is not None:
            # What has been compiled needs arrays to be counted, but nothing of what numba compiles by, which takes a
            # quarter of a second to load.
            _runtime.initialize(target_context)
            return _caching.CompileResultCacheImpl.rebuild(self, target_context, found)
        target_context.refresh()
        found = None if kernels.building else super().load_overload(sig, target_context)
        if found is None and self._from_python:
            kernels.begins()
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what has been compiled for a signature."""
        if not kernels.building:
            super().save_overload(sig, data)
        elif self._from_python and self._impl.check_cachable(data):
            self._ahead.save(self._index_key(sig, data.codegen), self._impl.reduce(data))

    def signatures(self) -> Iterator[Any]:
        """Give all signatures that this machine has compiled."""
        for sig, _, _ in self._cache_file._load_index():
            yield sig


def _digest(function: Any, options: dict[str, Any]) -> str:
    """Return what tells a kernel from any other: its code, its options, and all that it names.

    Raises TypeError where it names something whose change would go unnoticed.
    """
    digest = hashlib.sha256(repr((sorted(options.items()), function.__defaults__)).encode())

    def add(code: CodeType) -> None:
        digest.update(repr((code.co_code, code.co_names, code.co_varnames, code.co_freevars)).encode())
        for constant in code.co_consts:
            if isinstance(constant, CodeType):
                add(constant)
            else:
                digest.update(repr(constant).encode())
        for name in code.co_names:
            if name in function.__globals__:
                digest.update(_of(function.__globals__[name], code.co_names, f"{function.__module__}.{name}"))

    add(function.__code__)
    for cell in function.__closure__ or ():
        digest.update(_of(cell.cell_contents, (), function.__qualname__))
    return digest.hexdigest()


def _of(value: Any, names: tuple[str, ...], place: str) -> bytes:
    """Return the bytes that stand for something that a kernel names; ``names`` are all that it does."""
    if isinstance(value, kernels.Kernel):
        return bytes(value.made._cache.digest.encode())
    if isinstance(value, _intrinsic):
        return _digest(value._defn, {}).encode()
    if isinstance(value, ModuleType):
        if not value.__name__.startswith("hyperfab"):
            return value.__name__.encode()
        own = [name for name in names if hasattr(value, name)]
        return b"".join(_of(getattr(value, name), names, f"{value.__name__}.{name}") for name in own)
    if isinstance(value, type):
        return repr((value.__qualname__, getattr(value, "_fields", ()))).encode()
    if isinstance(value, np.ndarray):
        return repr((value.dtype, value.shape)).encode() + value.tobytes()
    if isinstance(value, (BuiltinFunctionType, np.ufunc)) or (
        isinstance(value, FunctionType) and not value.__module__.startswith("hyperfab")
    ):
        return repr(value.__name__).encode()
    if isinstance(value, (bool, int, float, complex, str, bytes, tuple, type(None))):
        return repr(value).encode()
    raise TypeError(f"{place}: a kernel names a {type(value).__name__}, whose change nothing would notice")


def _for_the_level() -> None:
    """Compile for all processors of a level rather than for this one, unless numba was told otherwise."""
    if _config.CPU_NAME is None and _config.CPU_FEATURES is None and platform.machine() in ("x86_64", "AMD64"):
        has = llvm.get_host_cpu_features()
        if all(has.get(feature, False) for feature in _NEEDS):
            _config.CPU_NAME, _config.CPU_FEATURES = _LEVEL, ""


@typeof_impl.register(kernels.Kernel)
def _typed(value: kernels.Kernel, context: Any) -> Any:
    """A kernel that calls another calls what that one is compiled to."""
    return typeof_impl(value.made, context)


_for_the_level()
