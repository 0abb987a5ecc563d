"""Material cards of finite-element programs, one file a format in ``hyperfab.materials.export.formats``."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

from hyperfab.errors import UsageError
from hyperfab.materials.export import formats as _folder
from hyperfab.materials.export.card import Format, NoCard, Settings

__all__ = ["Format", "NoCard", "Settings", "format_called", "formats"]


@cache
def formats() -> dict[str, Format]:
    """Return every card format by its name.

    >>> sorted(formats())
    ['abaqus', 'ansys', 'febio', 'ls-dyna']
    """
    found: dict[str, Format] = {}
    for module in pkgutil.iter_modules(_folder.__path__):
        one: Format = importlib.import_module(f"{_folder.__name__}.{module.name}").FORMAT
        found[one.name] = one
    return found


def format_called(name: str) -> Format:
    """Return the format called ``name``; UsageError with the known names where there is none."""
    if name not in formats():
        raise UsageError(f"no card format {name!r}; the formats are {', '.join(formats())}")
    return formats()[name]
