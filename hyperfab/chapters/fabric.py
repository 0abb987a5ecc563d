"""A material document as laws: its directions, its temperature, the effects that change the law."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hyperfab.chapters.job import Job
from hyperfab.chapters.look import COLDEST, HOTTEST
from hyperfab.documents.base import read_document
from hyperfab.documents.material import Direction, MaterialDocument
from hyperfab.errors import InputError
from hyperfab.materials import Material, bind
from hyperfab.materials.effects import thermal_softening
from hyperfab.materials.effects.elastic_law import richer
from hyperfab.materials.hyperfoam import ORDERS, Hyperfoam
from hyperfab.materials.law import scaled, stresses
from hyperfab.materials.orthotropic import Orthotropic

#: The law that is the whole sheet's, not one direction's.
ORTHOTROPIC = Orthotropic.name
#: No constant [MPa] is larger: diamond has a modulus of 1.2e6, and those of high powers of small strains are larger.
STIFFEST = 1e12


@dataclass(frozen=True)
class FabricDocument:
    """A material document that was read as ``name``, and the temperature [degC] that was ``asked`` for, if any.

    Every command that computes with a fabric or a foam takes its laws from here.
    """

    document: MaterialDocument
    name: str
    asked: float | None = None

    @property
    def temperature(self) -> float | None:
        """The temperature [degC] that was asked for, or that the document's own constants hold at; None if unknown."""
        return self.asked if self.asked is not None else self.document.temperature_degC

    @property
    def two_directions(self) -> bool:
        """Whether warp and weft have constants of their own."""
        return {"warp", "weft"} <= set(self.document.directions or {})

    def constants(self, direction: str | None = None) -> dict[str, float]:
        """Return the law's constants at the temperature asked for; between those of two tests they go linearly.

        Beyond the tests the nearest hold (``held_at``). Where the document softens by the effect ``thermal-softening``,
        by that.
        """
        softening = self._softening()
        if softening is not None:
            own = self.document.constants(direction)
            factor = self._factor(*softening)
            if self.document.model == ORTHOTROPIC:
                return dict(self._orthotropic(own).scaled(factor).parameters)
            return scaled(own, factor)
        return self.document.constants(direction, self.asked)

    def follows(self, *temperatures: float) -> bool:
        """Whether the constants differ between ``temperatures`` [degC]."""
        ways = (None, *(self.document.directions or {}))
        told = [[replace(self, asked=asked).constants(way) for way in ways] for asked in temperatures]
        return any(one != told[0] for one in told)

    def material(self, direction: str | None = None, *, anisotropic: bool = True) -> Material:
        """Return the law along ``direction`` at the temperature asked for, with the terms of ``elastic-law``."""
        softening = self._softening()
        own = self.constants(direction) if softening is None else self.document.constants(direction)
        material = self._bound(own, direction, anisotropic)
        for index, effect in self.added:
            material = self._richer(material, effect, f"effects.{index}", direction == "weft")
        if softening is None:
            return material
        factor = self._factor(*softening)
        return replace(material, c=tuple(factor * value for value in material.c))

    @property
    def added(self) -> list[tuple[int, Mapping[str, Any]]]:
        """The terms of ``elastic-law`` that stand in no constants of the law, by their place among the effects."""
        every = enumerate(self.document.effects or [])
        return [(k, one) for k, one in every if one.get("id") == "elastic-law" and not one.get("told_by")]

    def law(self, direction: str | None = None) -> Material | Orthotropic | Hyperfoam:
        """Return the law as its constants alone tell it, at the temperature asked for: without the terms of effects."""
        constants = self.constants(direction)
        if self.document.model in ORDERS:
            return self._foam(constants)
        if self.document.model == ORTHOTROPIC:
            return self._orthotropic(constants)
        return self._bound(constants, direction, anisotropic=False)

    def foams(self) -> list[tuple[float | None, Hyperfoam]]:
        """Return the law of a foam at each temperature [degC] of its tests, rising; one, at None, without a table."""
        model = self.document.model
        if model not in ORDERS:
            raise InputError(
                f"{model} is no law of a foam",
                file=self.name,
                key="model",
                remedy=f"fit the foam's tests with --model {', '.join(ORDERS)}",
            )
        rows = sorted(self.document.temperatures or [], key=lambda row: row.temperature_degC)
        if not rows:
            return [(None, self._foam(self.document.constants()))]
        return [(row.temperature_degC, self._foam(row.parameters)) for row in rows]

    def _foam(self, constants: Mapping[str, float]) -> Hyperfoam:
        try:
            return Hyperfoam.of(constants)
        except (KeyError, ValueError) as error:
            raise InputError(
                f"no constants of {self.document.model}: {error}", file=self.name, key="parameters"
            ) from None

    def sheet(self) -> Orthotropic | None:
        """Return the law of the whole sheet at the temperature asked for; None where the law is of one direction."""
        return self._orthotropic(self.constants()) if self.document.model == ORTHOTROPIC else None

    def _orthotropic(self, constants: Mapping[str, float]) -> Orthotropic:
        try:
            return Orthotropic.of(constants)
        except InputError as error:
            key = f"parameters.{error.key}" if error.key else "parameters"
            raise InputError(error.message, file=self.name, key=key, remedy=error.remedy) from None

    def used_at(self, job: Job) -> None:
        """Note the temperature that is asked of the constants, and what is known of the fabric there."""
        if self.temperature is None:
            return
        known, then = self.known, "extrapolated"
        if not known and self._softening() is None:
            job.console.warn(
                f"{self.name} says nothing of temperature: its constants are taken as they stand at "
                f"{self.temperature:.4g} degC"
            )
        if self.held_at is not None:
            then = f"the constants of {self.held_at:.4g} degC are taken"
        job.ranges.used("temperature_degC", self.temperature, known=known or None, source=self.name, then=then)

    @property
    def held_at(self) -> float | None:
        """The temperature [degC] whose constants stand in for those asked for, which nobody measured; else None."""
        known = self.known
        if self.asked is None or not known or self._softening() is not None:
            return None
        nearest = min(max(self.asked, min(known)), max(known))
        if nearest == self.asked:
            return None
        own = self.document.temperature_degC
        # One set of constants for tests at several temperatures, as of a model that a loop closed, is that of its own.
        return own if own is not None and not self.follows(min(known), max(known)) else nearest

    @property
    def known(self) -> list[float]:
        """The temperatures [degC] that the document speaks of: of its constants, and of the tests behind them."""
        known = [] if self.document.temperature_degC is None else [self.document.temperature_degC]
        parts: list[MaterialDocument | Direction] = [
            self.document,
            *(self.document.directions or {}).values(),
        ]
        for part in parts:
            known += [row.temperature_degC for row in part.temperatures or ()]
            known += [t for test in (part.tested or {}).values() for t in test.temperature_degC or ()]
        return known

    def _softening(self) -> tuple[str, Mapping[str, Any]] | None:
        """Return the effect thermal-softening and its key, where a temperature is asked for."""
        if self.asked is None:
            return None
        for index, effect in enumerate(self.document.effects or []):
            if effect.get("id") == "thermal-softening":
                return f"effects.{index}", effect
        return None

    def _factor(self, key: str, effect: Mapping[str, Any]) -> float:
        values = effect.get("parameters") or {}
        reference = effect.get("reference_degC", self.document.temperature_degC)
        try:
            law = thermal_softening.LAWS[effect.get("form", "curved")]
            rest = [float(value) for name, value in values.items() if name != "softening_1_K"]
            return float(law(np.array(self.asked), float(reference), float(values["softening_1_K"]), *rest))
        except (KeyError, TypeError, ValueError):
            raise InputError(
                "thermal-softening needs softening_1_K and reference_degC", file=self.name, key=key
            ) from None

    def _bound(self, constants: Mapping[str, float], direction: str | None, anisotropic: bool = True) -> Material:
        key = "parameters" if direction is None else f"directions.{direction}.parameters"
        try:
            return bind(self.document.model, constants, anisotropic=anisotropic)
        except InputError as error:
            place = f"{key}.{error.key}" if error.key in constants else error.key or key
            raise InputError(error.message, file=self.name, key=place, remedy=error.remedy) from None

    def _richer(self, material: Material, effect: Mapping[str, Any], key: str, weft: bool) -> Material:
        try:
            return richer(material, str(effect.get("form")), effect.get("parameters") or {}, weft=weft)
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(
                f"elastic-law of form {effect.get('form')!r} is not known or lacks {error}",
                file=self.name,
                key=key,
                remedy="remove it, or see docs/close-loop.md",
            ) from None


def per_width(name: str) -> str:
    """Say that a material document is taken as it stands, its constants per width."""
    return f"{name} is per width: 1 mm is taken, and a stress in MPa is N/mm of width (--thickness sets it)"


def over(document: MaterialDocument, thickness_mm: float) -> MaterialDocument:
    """Return a copy whose constants are stresses over a thickness, where they are per width; else the document.

    How sure they are is not told anew.

    >>> per_width = {"parameters": {"C10_MPa": 0.2}, "thickness_mm": 1.0, "thickness_nominal": True}
    >>> knit = over(MaterialDocument(model="neo-hookean", **per_width), 0.5)
    >>> knit.parameters, knit.thickness_mm, knit.thickness_nominal
    ({'C10_MPa': 0.4}, 0.5, None)
    """
    if not document.thickness_nominal:
        return document
    share = (document.thickness_mm or 1.0) / thickness_mm
    result = document.model_copy(deep=True, update={"thickness_mm": thickness_mm, "thickness_nominal": None})
    for _, constants in result.every_constant():
        constants.update(scaled(constants, share))
    for effect in result.effects or []:
        given = effect.get("parameters") or {}
        numbers = {name: value for name, value in given.items() if isinstance(value, int | float)}
        effect["parameters"] = {**given, **scaled(numbers, share)}
    return result


def read_fabric_document(job: Job, name: str, asked: float | None, thickness: float | None = None) -> FabricDocument:
    """Read a material document for use at a temperature [degC], or at that of its own constants.

    ``thickness`` [mm] is the sheet's where that is known: constants per width become stresses over it.
    """
    document = read_document(job.inputs, name, MaterialDocument)
    for key, constants in document.every_constant():
        for one in stresses(constants):
            if abs(value := constants[one]) > STIFFEST:
                raise InputError(
                    f"{value:g} is no constant of a fabric", file=name, key=f"{key}.{one}", remedy="check its unit"
                )
    if thickness is not None:
        document = over(document, thickness)
    tentative = [str(one.get("id", "?")) for one in document.effects or [] if one.get("tentative")]
    if tentative:
        job.console.warn(
            f"{name}: hf close-loop left something unexplained beside {', '.join(tentative)}; what is computed from "
            "them holds at the tests they were found on"
        )
    if asked is not None and not COLDEST <= asked <= HOTTEST:
        job.console.warn(
            f"--temperature: {asked:.4g} degC is no temperature of a fabric ({COLDEST:g} to {HOTTEST:g} "
            "degC); is the unit right?"
        )
    return FabricDocument(document, name, asked)
