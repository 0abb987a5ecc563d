"""A material document with other constants: factors on those it has."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hyperfab.documents.material import MaterialDocument
from hyperfab.materials.registry import bind


def linear_of(material: MaterialDocument) -> tuple[tuple[str, ...], tuple[bool, ...]]:
    """Return the names of the constants that are refitted, and whether each scales stress where all of them do.

    A fabric of two directions has one stiffness along each.
    """
    if set(material.directions or {}) >= {"warp", "weft"}:
        return ("warp", "weft"), (True, True)
    law = bind(material.model, material.parameters).law
    return tuple(law.names), tuple(name in law.linear for name in law.names)


def scaled_material(material: MaterialDocument, factors: Mapping[str, float]) -> MaterialDocument:
    """Return the document with its constants times ``factors``, at every temperature it knows."""
    result = material.model_copy(deep=True)
    result.format = result.format_name()
    linear = bind(material.model, material.parameters).law.linear

    def scaled(parameters: Mapping[str, float], way: str | None) -> dict[str, float]:
        return {
            key: value * factors.get(key, factors.get(way or "", 1.0) if key in linear else 1.0)
            for key, value in parameters.items()
        }

    place: Any
    for place, way in ((result, "warp"), *((one, way) for way, one in (result.directions or {}).items())):
        place.parameters = scaled(place.parameters, way)
        place.temperatures = [
            row.model_copy(update={"parameters": scaled(row.parameters, way)})
            for row in place.temperatures or []
        ] or None
    return result
