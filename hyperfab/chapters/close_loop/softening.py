"""A material document with other constants: factors on those it has, and constants at other temperatures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.fabric import ORTHOTROPIC
from hyperfab.curve import TestCurve
from hyperfab.documents.material import AtTemperature, MaterialDocument
from hyperfab.materials.effects.fabric import Fabric
from hyperfab.materials.effects.path import Path, uniaxial_pull
from hyperfab.materials.effects.thermal_softening import LAWS
from hyperfab.materials.hyperfoam import HyperfoamLaw
from hyperfab.materials.identification.design import Problem as LawProblem
from hyperfab.materials.identification.fit import fit_law
from hyperfab.materials.identification.hyperfoam import nearest_foam
from hyperfab.materials.identification.rows import Rows
from hyperfab.materials.law import Law, scaled
from hyperfab.materials.orthotropic.linear import GROUND, THREADS, shares_of_threads, sheet_times
from hyperfab.materials.registry import bind, law_of


def linear_of(material: MaterialDocument) -> tuple[tuple[str, ...], tuple[bool, ...]]:
    """Return the names of the constants that are refitted, and whether each scales stress where all of them do.

    A fabric of two directions has one stiffness along each, one law of the whole sheet its ground's and its threads'.
    """
    if material.model == ORTHOTROPIC:
        names = (GROUND, *(name for name in THREADS if material.parameters.get(name, 0.0) > 0.0))
        return names, (True,) * len(names)
    if set(material.directions or {}) >= {"warp", "weft"}:
        return ("warp", "weft"), (True, True)
    law = bind(material.model, material.parameters).law
    return tuple(law.names), tuple(name in law.stresses for name in law.names)


def widths(model: str, parameters: Mapping[str, float], names: Sequence[str]) -> Array:
    """Return by how much of itself each constant (n,) changes where what a strip along it bears changes by a share."""
    return shares_of_threads(parameters, names) if model == ORTHOTROPIC else np.ones(len(names))


def scaled_material(material: MaterialDocument, factors: Mapping[str, float]) -> MaterialDocument:
    """Return the document with its constants times ``factors``, at every temperature it knows.

    ``factors`` are keyed by a constant, or by ``warp`` and ``weft``, whose stiffness they multiply, or by ``ground``,
    that of a whole sheet's law. What was said of the constants it had is taken out.
    """
    result = material.refitted()

    def times(parameters: Mapping[str, float], way: str) -> dict[str, float]:
        if material.model == ORTHOTROPIC:
            return sheet_times(parameters, factors, turned=way == "weft")
        whole = scaled(parameters, factors.get(way, 1.0))
        return {key: value * factors.get(key, 1.0) for key, value in whole.items()}

    place: Any
    for place, way in ((result, "warp"), *((one, way) for way, one in (result.directions or {}).items())):
        place.parameters = times(place.parameters, way)
        place.temperatures = [
            row.model_copy(update={"parameters": times(row.parameters, way)}) for row in place.temperatures or []
        ] or None
    return result


def soften(
    result: MaterialDocument,
    values: Sequence[float],
    reference_degC: float,
    met: Iterable[float],
    form: str,
) -> None:
    """Write softening with temperature as constants at each temperature ``met``, which every command interpolates.

    ``values`` are those of the effect ``thermal-softening`` in its ``form``; the constants at hand hold at
    ``reference_degC``.
    """
    law = law_of(result.model, result.parameters, anisotropic=True, foam=True)
    near = np.unique(np.round(2.0 * np.fromiter(met, dtype=np.float64)) / 2.0)
    degrees = sorted({float(reference_degC), *(float(v) for v in near)})
    place: Any
    for place in (result, *(result.directions or {}).values()):
        place.temperatures = [
            AtTemperature(
                temperature_degC=one,
                parameters=_at(law, place.parameters, form, values, one - reference_degC, reference_degC),
            )
            for one in degrees
        ]
    result.temperature_degC = reference_degC


def _at(
    law: Law, own: Mapping[str, float], form: str, values: Sequence[float], rise: float, reference: float
) -> dict[str, float]:
    """Return the constants some degrees above the ``reference``: scaled, or those that come nearest.

    Nearest, over the tests' reach, to what a law says that softens otherwise at each strain.
    """
    if form in LAWS:
        return scaled(own, float(LAWS[form](np.array(reference + rise), reference, *map(float, values))))
    reach = np.linspace(0.0, values[0], 41)[1:]
    pull = replace(uniaxial_pull(1.0 + reach), temperature_degC=np.full_like(reach, reference + rise))
    return nearest(law, pull, own, {"thermal-softening": (form, np.array(values))}, reference)


def nearest(
    law: Law,
    pull: Path,
    own: Mapping[str, float],
    terms: Mapping[str, tuple[str, Array]],
    reference_degC: float = 0.0,
) -> dict[str, float]:
    """Return the constants with which the law alone comes nearest, over a uniaxial pull, to the law with ``terms``."""
    constants = np.array([own[name] for name in law.names])
    stress = Fabric(law, pull, reference_degC).stress(constants, None, terms)
    weight = np.full_like(stress, 1.0 / float(np.max(np.abs(stress))))
    tests = [TestCurve("uniaxial", pull.stretch, stress, weight)]
    if isinstance(law, HyperfoamLaw):
        return nearest_foam(own, tests)
    near = fit_law(LawProblem(law, Rows.of(tests)))
    return dict(own) if near is None else {name: near.material.parameters[name] for name in law.names}
