"""Which program this is: the version of hf, and what its sources hold."""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path

import hyperfab


@functools.cache
def program() -> str:
    """Return the version and, behind a +, the hash of all of the package's sources.

    In a tree that is worked on the sources change under the same version, and with them what a step would find.
    """
    whole = hashlib.sha256()
    root = Path(hyperfab.__file__).parent
    for path in sorted(root.rglob("*.py"), key=lambda path: path.relative_to(root).parts):
        data = path.read_bytes()
        whole.update(f"{path.relative_to(root).as_posix()} {len(data)}\n".encode())
        whole.update(data)
    return f"{hyperfab.__version__}+{whole.hexdigest()[:16]}"
