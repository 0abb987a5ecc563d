"""What a model may lack, one missing effect a file, one folder a domain.

A module of a domain's folder has ``entry(scene) -> Effect | None``; None where the effect has no meaning for the model.
"""

from __future__ import annotations

import importlib
import pkgutil
from typing import Any

from hyperfab.loop.problem import Effect


def catalogue(domain: str, scene: Any) -> tuple[Effect, ...]:
    """Return the entries of a domain, scaled to the data in ``scene``."""
    folder = importlib.import_module(f"{__name__}.{domain}")
    found = []
    for module in sorted(pkgutil.iter_modules(folder.__path__), key=lambda module: module.name):
        if module.name == "scene":
            continue
        effect = importlib.import_module(f"{folder.__name__}.{module.name}").entry(scene)
        if effect is not None:
            found.append(effect)
    return tuple(found)
