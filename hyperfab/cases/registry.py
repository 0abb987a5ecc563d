"""Which case a command has, and which a kind of document; imported only when asked for."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hyperfab.cases.case import Case

#: The module of ``hyperfab.cases`` and the class in it, by command.
CASES = {
    "fit": "fit:FitCase",
    "fabric-contact": "contact:ContactCase",
    "drape": "drape:DrapeCase",
    "mold-heat": "mold:MoldCase",
    "press-contact": "press:PressCase",
    "close-loop": "loop:LoopCase",
    "report": "about:ReportCase",
    "sweep": "sweep:SweepCase",
    "export": "about:ExportCase",
    "summary": "about:SummaryCase",
    "sample": "about:SampleCase",
    "schema": "about:SchemaCase",
}
#: The command that makes each kind of document.
MADE_BY = {
    "material": "fit",
    "contact": "fabric-contact",
    "drape": "drape",
    "heat": "mold-heat",
    "press": "press-contact",
    "loop": "close-loop",
    "sweep": "sweep",
}


def case_class(command: str) -> type[Case]:
    """Return the class of the cases of a command."""
    module, name = CASES[command].split(":")
    return getattr(importlib.import_module(f"hyperfab.cases.{module}"), name)
