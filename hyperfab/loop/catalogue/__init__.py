"""What a model may lack, one missing effect a file, one folder a domain.

A module of a domain's folder has ``entry(context) -> Effect``; ``not_sought`` says why where it has no meaning for the
model or the data.
"""

from __future__ import annotations

import importlib
import pkgutil
from typing import Any

from hyperfab.loop.problem import Effect


def catalogue(domain: str, context: Any) -> tuple[Effect, ...]:
    """Return the entries of a domain, scaled to the data in ``context``."""
    folder = importlib.import_module(f"{__name__}.{domain}")
    found = []
    for module in sorted(pkgutil.iter_modules(folder.__path__), key=lambda module: module.name):
        found.append(importlib.import_module(f"{folder.__name__}.{module.name}").entry(context))
    return tuple(found)
