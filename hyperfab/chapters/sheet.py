"""The sheet's law from a material document: its directions, its temperature, its effects."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from hyperfab.chapters.fabric import FabricDocument, read_fabric_document
from hyperfab.chapters.job import Job
from hyperfab.documents.material import MaterialDocument
from hyperfab.materials import Material, bind
from hyperfab.materials.effects.fabric import SPARES_FIRST_PULL
from hyperfab.membrane.orthotropic import fibre_sheet, orthotropic_sheet
from hyperfab.membrane.relaxed import RelaxedSheet
from hyperfab.membrane.tension_field import IsotropicSheet, SheetLaw

#: Effects of the test, not of the fabric: there is nothing in a sheet to obey them.
_OF_THE_TEST = ("grip-slack", "load-offset")
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
    """A sheet's law as read from a material document, in words too.

    ``tested`` are the smallest and the largest stretch of the tests behind it, along the direction tested less;
    ``per_width`` says that its thickness is nominal, and its stresses in MPa are N/mm of width.
    """

    name: str
    model: str
    law: SheetLaw
    words: str
    thickness: float | None
    left_out: list[str]
    obeyed: list[str] = field(default_factory=list)
    temperature: float | None = None
    held_at: float | None = None
    tested: tuple[float, float] | None = None
    per_width: bool = False

    def strip_stress(self, stretch: float) -> float:
        """Return the nominal stress [MPa] of a strip at a stretch, along warp or weft, whichever bears more."""
        # So narrow that it bears nothing across.
        narrow = np.array([[stretch**2, stretch**-4, 0.0], [stretch**-4, stretch**2, 0.0]])
        return float(self.law.principal(narrow).nominal.max())


def read_fabric(job: Job, name: str, degrees: float | None = None, thickness: float | None = None) -> Fabric:
    """Read a material document and make a sheet's law of it, at a temperature [degC] where given.

    ``thickness`` [mm] is the sheet's where that is known. Raises InputError where the document is wrong.
    """
    read = read_fabric_document(job, name, degrees, thickness)
    read.used_at(job)
    warn_of_effects(job, read, "the sheet does")
    return sheet_of(read)


def warn_of_effects(job: Job, read: FabricDocument, who: str) -> None:
    """Warn of the effects in a document that a sheet does not obey; ``left_out`` has the reasons."""
    names = [one.partition(":")[0] for one in judged(read.document, read.asked)[1]]
    names = [name for name in dict.fromkeys(names) if name != "thermal-softening"]
    if names:
        job.console.warn(f"{read.name}: {who} not act on {', '.join(names)} (left_out says why)")


def sheet_of(read: FabricDocument) -> Fabric:
    """Return the sheet's law of a material document; InputError where it is wrong."""
    fabric = _of_directions(read)
    obeyed, left_out = judged(read.document, read.asked)
    ways = ("warp", "weft") if read.two_directions else (None,)
    known = [read.document.tested_stretch(way) for way in ways]
    lows, highs = zip(*(one for one in known if one is not None), strict=True) if all(known) else ((), ())
    return replace(
        fabric,
        obeyed=obeyed,
        left_out=fabric.left_out + left_out,
        temperature=read.temperature,
        held_at=read.held_at,
        tested=(max(lows), min(highs)) if highs else None,
        per_width=bool(read.document.thickness_nominal),
    )


def _of_directions(read: FabricDocument) -> Fabric:
    document, name = read.document, read.name
    thickness = document.thickness_mm
    whole = read.sheet()
    if whole is not None:
        words = "orthotropic: one energy for the sheet; the warp runs along x"
        left_out = [
            f"{one.constant}: not told by the tests behind the law (it takes {one.test})"
            for one in document.undetermined or []
        ]
        return Fabric(name, document.model, RelaxedSheet(whole), words, thickness, left_out)
    two = read.two_directions
    warp = read.material("warp" if two else None)
    if not warp.law.isotropic:
        weft = read.material("weft") if two else warp.turned()
        ground = min(_ground(warp), _ground(weft), key=lambda one: one.c[0])
        law: SheetLaw = fibre_sheet(ground, warp, weft)
        words = "orthotropic: the law's ground, and its fibres along warp (x) and weft (y)"
        return Fabric(name, document.model, law, words, thickness, [])
    if not two:
        return Fabric(name, document.model, IsotropicSheet(warp), "isotropic", thickness, [])
    sheet = orthotropic_sheet(warp, read.material("weft"))
    words = (
        "orthotropic: a ground mixed of both directions' laws, and along warp (x) and weft (y) what each law has "
        "beyond it in uniaxial tension"
    )
    unknown = "shear and biaxial stiffness of the fabric, beyond a mixture of both directions' laws: not measured"
    return Fabric(name, document.model, sheet, words, thickness, [unknown])


def _ground(fibres: Material) -> Material:
    """Return what is left of a law of fibres without them."""
    return bind("neo-hookean", {"C10_MPa": fibres.parameters["C10_MPa"]})


def judged(document: MaterialDocument, degrees: float | None) -> tuple[list[str], list[str]]:
    """Say which effects the sheet obeys, and which it does not and why."""
    obeyed, left_out = [], []
    for effect in document.effects or []:
        kind, form = str(effect.get("id", "?")), str(effect.get("form", ""))
        if effect.get("diagonal_softness"):
            left_out.append("anisotropy: the softness half-way between warp and weft; a sheet needs its energy")
        if kind == "thermal-softening":
            obeyed.append(kind)
            if degrees is None:
                left_out.append("thermal-softening: no --temperature was given; the constants' own is taken")
        elif effect.get("told_by") or kind == "elastic-law":
            obeyed.append(kind)
        elif kind in _OF_THE_TEST:
            obeyed.append(f"{kind} (of the test, not of the fabric)")
        elif form in SPARES_FIRST_PULL.get(kind, ()):
            # That is all that a punch going in does to the sheet.
            obeyed.append(f"{kind} (a first pull shows nothing of it)")
        else:
            left_out.append(f"{kind}: {_WHY_NOT.get(kind, 'unknown here')}")
    return obeyed, left_out
