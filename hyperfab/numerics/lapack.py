"""LAPACK and BLAS inside compiled kernels: the routines of scipy's ``cython_lapack`` and ``cython_blas``, by address.

numba calls few of them itself, and what scipy offers to Python holds the interpreter while it works. An address is
handed to a kernel with its arguments, so that a compiled kernel can be kept: it holds none.
"""

from __future__ import annotations

import ctypes
from importlib import import_module
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from hyperfab.arrays import Ints


def addresses(*names: str) -> Ints:
    """Return where routines of double precision stand, such as ``dpotrf``.

    Each takes pointers alone, as Fortran does; integers have 32 bits.

    >>> len(addresses("dpotrf", "dsyrk"))
    2
    """
    found = []
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    name_of = ctypes.pythonapi.PyCapsule_GetName
    name_of.restype, name_of.argtypes = ctypes.c_char_p, [ctypes.py_object]
    for name in names:
        for module in ("scipy.linalg.cython_lapack", "scipy.linalg.cython_blas"):
            capsules: dict[str, Any] = import_module(module).__pyx_capi__
            if name in capsules:
                found.append(pointer(capsules[name], name_of(capsules[name])))
                break
        else:
            raise ValueError(f"scipy has no {name}")
    return np.array(found, np.int64)


def _call(context: Any, address: Any, places: Any) -> Any:
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = ir.IntType(8).as_pointer()
        count = signature.args[1].count
        kind = ir.FunctionType(ir.VoidType(), [pointer] * count)
        routine = builder.inttoptr(arguments[0], kind.as_pointer())
        given = [builder.inttoptr(builder.extract_value(arguments[1], k), pointer) for k in range(count)]
        builder.call(routine, given)
        return context.get_dummy_value()

    return types.void(address, places), code


#: In a kernel, ``call_routine(address, places)`` calls the routine with pointers to ``places``, a tuple of addresses of
#: numbers. The arrays they stand in must be arguments of the kernel: one made inside could be gone by then.
call_routine: Any = intrinsic(_call)
