"""The fabric of ``hf drape``: spring laws along warp and weft from a material document."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hyperfab.chapters.job import Job
from hyperfab.cloth import SpringLaw
from hyperfab.cloth.fabric import spring_law
from hyperfab.cloth.law import Floats
from hyperfab.documents.base import read_document
from hyperfab.documents.drape import SpringUse
from hyperfab.documents.material import FitFigures, MaterialDocument
from hyperfab.errors import InputError, UsageError
from hyperfab.io import units
from hyperfab.materials import bind


@dataclass(frozen=True)
class Fabric:
    """Laws of the springs along warp and weft, and the sheet's thickness in mm."""

    model: str
    warp: SpringLaw
    weft: SpringLaw
    thickness: float
    tested: tuple[float | None, float | None]


def read_fabric(job: Job, name: str, thickness: str | None) -> Fabric:
    """Read a material document; ``thickness`` from the command line goes before the document's own."""
    document = read_document(job.inputs, name, MaterialDocument)
    if thickness is not None:
        thick = units.quantity(thickness, "length", option="--thickness")
        if thick <= 0.0:
            raise UsageError(f"--thickness {thickness}: must be more than 0mm")
    elif document.thickness_mm is None:
        thick = 1.0
        job.console.note(f"{name} states no thickness: 1 mm is taken (--thickness sets it)")
    else:
        thick = document.thickness_mm
    untold = [str(effect.get("id", "?")) for effect in document.effects or [] if not effect.get("told_by")]
    if untold:
        job.console.warn(
            f"{name}: the springs do not act on {', '.join(untold)}: they answer as on a first, slow pull"
        )
    laws, tested = [], []
    for direction in ("warp", "weft"):
        own = (document.directions or {}).get(direction)
        key = "parameters" if own is None else f"directions.{direction}.parameters"
        parameters = document.constants(direction if own is not None else None)
        laws.append(_law(document.model, parameters, name, key))
        tested.append(_tested(document.fit if own is None else own.fit))
    return Fabric(document.model, laws[0], laws[1], thick, (tested[0], tested[1]))


def _tested(fit: FitFigures | None) -> float | None:
    """Largest stretch of the uniaxial tests behind the constants, where the document states it."""
    ranges = [
        getattr(test, "stretch_max", None)
        for name, test in (fit.tests if fit else {}).items()
        if "uniaxial" in name
    ]
    known = [float(value) for value in ranges if isinstance(value, (int, float))]
    return max(known) if known else None


def _law(model: str, parameters: Mapping[str, float], name: str, key: str) -> SpringLaw:
    try:
        return spring_law(bind(model, parameters, anisotropic=True))
    except InputError as error:
        raise InputError(error.message, file=name, key=error.key, remedy=error.remedy) from None
    except ValueError as error:
        raise InputError(
            str(error), file=name, key=key, remedy="fit the fabric again with --stable"
        ) from None


def use_of(fabric: Fabric, stretch_warp: Floats, stretch_weft: Floats) -> tuple[SpringUse, SpringUse]:
    """How far each law was used, and whether it was tested and rising there."""
    uses = []
    for law, stretch, tested in zip(
        (fabric.warp, fabric.weft), (stretch_warp, stretch_weft), fabric.tested, strict=True
    ):
        largest = float(stretch.max())
        uses.append(
            SpringUse(
                model=fabric.model,
                stretch_max=largest,
                tested_stretch_max=tested,
                beyond_tested=0 if tested is None else int(np.count_nonzero(stretch > tested * (1.0 + 1e-9))),
                softens_at=law.softens if law.softens is not None and largest > law.softens else None,
            )
        )
    return uses[0], uses[1]
