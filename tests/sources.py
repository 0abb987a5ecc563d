"""The modules of the package as trees of their syntax, each parsed once."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import hyperfab

PACKAGE = Path(hyperfab.__file__).parent


@cache
def parsed() -> dict[Path, ast.Module]:
    """Return the tree of every module, by its path in the package."""
    return {
        path.relative_to(PACKAGE): ast.parse(path.read_text(encoding="utf-8")) for path in sorted(PACKAGE.rglob("*.py"))
    }
