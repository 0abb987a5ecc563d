"""The sheet's law from a material document: its directions, its temperature, its effects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from hyperfab.chapters.job import Job
from hyperfab.documents.base import read_document
from hyperfab.documents.material import MaterialDocument
from hyperfab.errors import InputError
from hyperfab.materials import Material, bind
from hyperfab.materials.effects import thermal_softening
from hyperfab.materials.richer import richer
from hyperfab.membrane.orthotropic import fibre_sheet, orthotropic_sheet
from hyperfab.membrane.tension_field import IsotropicSheet, SheetLaw

#: Effects of the test, not of the fabric: there is nothing in a sheet to obey them.
_OF_THE_TEST = ("grip-slack", "load-offset")
#: Forms of history that leave the first pull as it is, which is all that a punch going in does to the sheet.
_SPARES_THE_FIRST_PULL = {
    "mullins": ("pseudo-elastic", "strain"),
    "hysteresis": ("pseudo-elastic", "returning", "bent"),
    "permanent-set": ("returned", "next-pull"),
}
_WHY_NOT = {
    "hysteresis": "friction between the yarns takes part in the first pull too",
    "rate": "the sheet is pressed slowly, at its relaxed stress",
    "mullins": "damage on the first pull is not followed in two directions",
    "permanent-set": "set on the first pull is not followed in two directions",
    "compressibility": "the law keeps the volume in plane stress",
    "anisotropy": "only the form that gives warp and weft constants of their own is obeyed",
}


@dataclass(frozen=True)
class Fabric:
    """A sheet's law as read from a material document, in words too."""

    name: str
    model: str
    law: SheetLaw
    words: str
    thickness: float | None
    left_out: list[str]
    obeyed: list[str] = field(default_factory=list)
    temperature: float | None = None


def read_fabric(job: Job, name: str, degrees: float | None = None) -> Fabric:
    """Read a material document and make a sheet's law of it, at a temperature [degC] where given.

    Raises InputError where the document is wrong, or says nothing of temperature.
    """
    document = read_document(job.inputs, name, MaterialDocument)
    maker = _Maker(document, name, degrees)
    fabric = _of_directions(maker)
    obeyed, left_out = _judged(document, degrees)
    shown = degrees if degrees is not None else document.temperature_degC
    return replace(fabric, obeyed=obeyed, left_out=fabric.left_out + left_out, temperature=shown)


def _of_directions(maker: _Maker) -> Fabric:
    document, name = maker.document, maker.name
    thickness = document.thickness_mm
    two = {"warp", "weft"} <= set(document.directions or {})
    warp = maker.material("warp" if two else None)
    if not warp.law.isotropic:
        weft = maker.material("weft") if two else warp.turned()
        ground = min(_ground(warp), _ground(weft), key=lambda one: one.c[0])
        law: SheetLaw = fibre_sheet(ground, warp, weft)
        words = "orthotropic: the law's ground, and its fibres along warp (x) and weft (y)"
        return Fabric(name, document.model, law, words, thickness, [])
    if not two:
        return Fabric(name, document.model, IsotropicSheet(warp), "isotropic", thickness, [])
    sheet = orthotropic_sheet(warp, maker.material("weft"))
    words = (
        "orthotropic: a ground mixed of both directions' laws, and along warp (x) and weft (y) what each law has "
        "beyond it in uniaxial tension"
    )
    unknown = (
        "shear and biaxial stiffness of the fabric, beyond a mixture of both directions' laws: not measured"
    )
    return Fabric(name, document.model, sheet, words, thickness, [unknown])


def _ground(fibres: Material) -> Material:
    """Return what is left of a law of fibres without them."""
    return bind("neo-hookean", {"C10_MPa": fibres.parameters["C10_MPa"]})


@dataclass(frozen=True)
class _Maker:
    """Makes the material of a direction, with the effects that change the law itself."""

    document: MaterialDocument
    name: str
    degrees: float | None

    def material(self, direction: str | None) -> Material:
        softening = self._softening()
        at = None if softening is not None else self.degrees
        constants = self.document.constants(direction, at)
        if at is not None and not self._table(direction):
            raise InputError(
                "says nothing of temperature: it has neither constants at several temperatures nor the effect "
                "thermal-softening",
                file=self.name,
                key="temperatures",
                remedy="fit tests at several temperatures, or leave --temperature out",
            )
        key = "parameters" if direction is None else f"directions.{direction}.parameters"
        material = self._bound(constants, key)
        for index, effect in enumerate(self.document.effects or []):
            if effect.get("id") == "elastic-law" and not effect.get("told_by"):
                material = self._richer(material, effect, f"effects.{index}")
        if softening is None or self.degrees is None:
            return material
        factor = self._factor(softening)
        return replace(material, c=tuple(factor * value for value in material.c))

    def _table(self, direction: str | None) -> object:
        of = self.document.directions
        return self.document.temperatures if of is None or direction is None else of[direction].temperatures

    def _softening(self) -> tuple[str, Mapping[str, Any]] | None:
        for index, effect in enumerate(self.document.effects or []):
            if effect.get("id") == "thermal-softening":
                return f"effects.{index}", effect
        return None

    def _factor(self, softening: tuple[str, Mapping[str, Any]]) -> float:
        key, effect = softening
        values = effect.get("parameters") or {}
        reference = effect.get("reference_degC", self.document.temperature_degC)
        try:
            one, two = float(values["softening_1_K"]), float(values.get("softening_1_K2", 0.0))
            return float(thermal_softening.factor(self.degrees, float(reference), one, two))  # type: ignore[arg-type]
        except (KeyError, TypeError, ValueError):
            raise InputError(
                "thermal-softening needs softening_1_K and reference_degC", file=self.name, key=key
            ) from None

    def _bound(self, constants: dict[str, float], key: str) -> Material:
        try:
            return bind(self.document.model, constants, anisotropic=True)
        except InputError as error:
            place = f"{key}.{error.key}" if error.key in constants else error.key or key
            raise InputError(error.message, file=self.name, key=place, remedy=error.remedy) from None

    def _richer(self, material: Material, effect: Mapping[str, Any], key: str) -> Material:
        try:
            return richer(material, str(effect.get("form")), effect.get("parameters") or {})
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(
                f"elastic-law of form {effect.get('form')!r} is not known or lacks {error}",
                file=self.name,
                key=key,
                remedy="remove it, or see docs/close-loop.md",
            ) from None


def _judged(document: MaterialDocument, degrees: float | None) -> tuple[list[str], list[str]]:
    """Say which effects the sheet obeys, and which it does not and why."""
    obeyed, left_out = [], []
    for effect in document.effects or []:
        kind, form = str(effect.get("id", "?")), str(effect.get("form", ""))
        if effect.get("diagonal_softness"):
            left_out.append(
                "anisotropy: the softness half-way between warp and weft; a sheet needs its energy"
            )
        if kind == "thermal-softening":
            obeyed.append(kind)
            if degrees is None:
                left_out.append("thermal-softening: no --temperature was given; the constants' own is taken")
        elif effect.get("told_by") or kind == "elastic-law":
            obeyed.append(kind)
        elif kind in _OF_THE_TEST:
            obeyed.append(f"{kind} (of the test, not of the fabric)")
        elif form.startswith(_SPARES_THE_FIRST_PULL.get(kind, ("\0",))):
            obeyed.append(f"{kind} (a first pull shows nothing of it)")
        else:
            left_out.append(f"{kind}: {_WHY_NOT.get(kind, 'unknown here')}")
    return obeyed, left_out
