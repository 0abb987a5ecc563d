"""Kernels compiled when the package is built, so that the first run of a command need not.

    python -m hyperfab.ahead           compile what ``ahead.json`` lists, into hyperfab/compiled
    python -m hyperfab.ahead --list    add to ``ahead.json`` what this machine has compiled and kept

``ahead.json`` holds, by kernel, the types it is called with: ``float64 2C`` is an array of two axes in C order, a
list a tuple, and ``{name: list}`` a named tuple. ``python -m trials.kernels`` makes it anew.
"""

from __future__ import annotations

import json
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from pathlib import Path
from typing import Any

LIST = Path(__file__).with_suffix(".json")


def all_kernels() -> dict[str, Any]:
    """Return the kernels of the package that Python calls, by module and name."""
    from hyperfab.numerics.kernels import KERNELS

    root = Path(__file__).parent
    for path in sorted(root.rglob("*.py")):
        if b"\nfrom hyperfab.numerics.kernels import" in path.read_bytes():
            import_module(".".join(("hyperfab", *path.relative_to(root).with_suffix("").parts)))
    return {name: one for name, one in sorted(KERNELS.items()) if name.startswith("hyperfab.")}


def listed() -> dict[str, list[list[Any]]]:
    """Return the argument types, as they are listed, that each kernel is compiled for."""
    found: dict[str, list[list[Any]]] = json.loads(LIST.read_text(encoding="utf-8"))
    return found


def written(kind: Any) -> Any:
    """Return how a numba type is listed.

    >>> import numba
    >>> written(numba.types.UniTuple(numba.float64[:, ::1], 2))
    ['float64 2C', 'float64 2C']
    """
    types: Any = import_module("numba").types
    if isinstance(kind, types.Array):
        return f"{kind.dtype} {kind.ndim}{kind.layout}{'' if kind.mutable else ' fixed'}"
    if isinstance(kind, types.BaseNamedTuple):
        made = kind.instance_class
        return {f"{made.__module__}.{made.__qualname__}": [written(one) for one in kind.types]}
    if isinstance(kind, types.BaseTuple):
        return [written(one) for one in kind.types]
    return str(kind)


def read(text: Any) -> Any:
    """Return the numba type that is listed.

    >>> kind = read(["float64 2C", "int64", "bool"])
    >>> kind[0].ndim, kind[0].layout, kind[0].dtype
    (2, 'C', float64)
    """
    types: Any = import_module("numba").types
    if isinstance(text, dict):
        ((name, members),) = text.items()
        module, _, name = name.rpartition(".")
        made = getattr(import_module(module), name)
        kinds = [read(one) for one in members]
        if len(set(kinds)) == 1:
            return types.NamedUniTuple(kinds[0], len(kinds), made)
        return types.NamedTuple(kinds, made)
    if isinstance(text, list):
        return types.Tuple([read(one) for one in text])
    number, *shape = text.split()
    scalar = types.boolean if number == "bool" else getattr(types, number)
    if not shape:
        return scalar
    return types.Array(scalar, int(shape[0][:-1]), shape[0][-1], readonly="fixed" in shape)


def compile_some(names: list[str]) -> int:
    """Compile the listed forms of some kernels into the package, and return how many there are."""
    from hyperfab.numerics import kernels

    kernels.building = True
    every, count = all_kernels(), 0
    for name in names:
        for kinds in listed()[name]:
            every[name].made.compile(tuple(read(kind) for kind in kinds))
            count += 1
    return count


def compile_all() -> int:
    """Compile all that is listed, on the cores there are, and return how many forms of kernels there are.

    What is in the folder already and holds is left.
    """
    from hyperfab.numerics.jit import AHEAD
    from hyperfab.numerics.threads import threads

    AHEAD.mkdir(exist_ok=True)
    names = sorted(listed())
    # A module's kernels call each other, and are compiled together.
    modules = sorted({name.rpartition(".")[0] for name in names})
    groups = [[name for name in names if name.rpartition(".")[0] == module] for module in modules]
    with ProcessPoolExecutor(min(threads(), len(groups))) as pool:
        return sum(pool.map(compile_some, sorted(groups, key=len, reverse=True)))


def add_to_list() -> None:
    """Add all that this machine has compiled to the list; forms with another number of arguments go."""
    known = listed() if LIST.exists() else {}
    have: dict[str, list[list[Any]]] = {}
    for name, one in all_kernels().items():
        takes = one.function.__code__.co_argcount
        forms = {json.dumps(form): form for form in known.get(name, []) if len(form) == takes}
        for kinds in one.made._cache.signatures():
            form = [written(kind) for kind in kinds]
            forms.setdefault(json.dumps(form), form)
        have[name] = [forms[key] for key in sorted(forms)]
    lines = []
    for name, forms_ in sorted(have.items()):
        rows = ",\n".join("  " + json.dumps(form) for form in forms_)
        lines.append(f'"{name}": [\n{rows}\n]' if rows else f'"{name}": []')
    LIST.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if sys.argv[1:] == ["--list"]:
        add_to_list()
    else:
        print(f"{compile_all()} forms of kernels compiled")
