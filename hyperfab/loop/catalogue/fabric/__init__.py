"""What a strain-energy law lacks on tests of a fabric."""

from __future__ import annotations

from hyperfab.loop.catalogue.fabric.context import DataContext as DataContext
from hyperfab.loop.catalogue.fabric.history import hysteresis, mullins, permanent_set
from hyperfab.loop.catalogue.fabric.mounting import grip_slack, load_offset
from hyperfab.loop.catalogue.fabric.relaxation import rate
from hyperfab.loop.catalogue.fabric.response import anisotropy, compressibility, elastic_law, thermal_softening
from hyperfab.loop.problem import Effect


def entries(context: DataContext) -> tuple[Effect, ...]:
    """Return what may lack, scaled to the data."""
    return (
        anisotropy(context),
        compressibility(context),
        elastic_law(context),
        grip_slack(context),
        hysteresis(context),
        load_offset(context),
        mullins(context),
        permanent_set(context),
        rate(context),
        thermal_softening(context),
    )
