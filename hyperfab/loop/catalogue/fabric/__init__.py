"""What a strain-energy law lacks on tests of a fabric."""

from __future__ import annotations

from hyperfab.loop.catalogue.fabric import history, mounting, relaxation, response
from hyperfab.loop.catalogue.fabric.context import DataContext as DataContext
from hyperfab.loop.problem import Effect


def entries(context: DataContext) -> tuple[Effect, ...]:
    """Return what may lack, scaled to the data."""
    found = (one for module in (response, history, relaxation, mounting) for one in module.entries(context))
    return tuple(sorted(found, key=lambda effect: effect.id))
