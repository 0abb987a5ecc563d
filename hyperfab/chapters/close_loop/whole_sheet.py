"""One energy of the whole sheet, as the loop reads it: the law of its ground, and the rest as terms of a document."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from typing import Any

import numpy as np

from hyperfab.chapters.fabric import FabricDocument
from hyperfab.curve import TestCurve
from hyperfab.documents.material import MaterialDocument
from hyperfab.materials.effects import anisotropy, compressibility
from hyperfab.materials.effects.anisotropy import REST
from hyperfab.materials.effects.threads import GROUND
from hyperfab.materials.orthotropic import ABSENT
from hyperfab.materials.orthotropic.determined import sought_by
from hyperfab.materials.registry import law as law_called

#: The laws that may be its ground.
_GROUNDS = ("yeoh-1", "yeoh-2", "yeoh-3", "yeoh-3-lni2")
#: What says how the threads are that a constant gives their stiffness.
_PART_OF = {
    "k2_warp": "k1_warp_MPa",
    "k2_weft": "k1_weft_MPa",
    "k2_bias": "k1_bias_MPa",
    "bias_deg": "k1_bias_MPa",
}


def in_terms(document: MaterialDocument, name: str, tests: Sequence[TestCurve]) -> MaterialDocument:
    """Return a document of one energy of the whole sheet as one that has its ground's law and the rest as effects.

    Constants at which nothing is there are left out, and stay so, unless those behind the document left them open and
    these ``tests`` tell them. Other documents are returned as they are.
    """
    sheet = FabricDocument(document, name).sheet()
    if sheet is None or any("ground" in item for item in document.effects or []):
        return document
    has = {key for key, value in sheet.parameters.items() if value != ABSENT[key]}
    law = next(law for law in map(law_called, _GROUNDS) if set(law.names) >= has & GROUND)
    ground = {key: sheet.parameters[key] for key in law.names}
    told = has | ({one.constant for one in document.undetermined or []} & {*sought_by(tests)[0]})
    own = [key for key in REST.names if _PART_OF.get(key, key) in told]
    found = document.model_copy()
    records: list[dict[str, Any]] = []
    if own:
        threads = {key: sheet.parameters[key] for key in own}
        record = {"id": "anisotropy", "form": "sheet", "parameters": threads, "told_by": REST.told_by}
        records.append({**record, "ground": ground, "law": law.name})
    else:  # a ground alone is the same along warp and weft
        found.model, found.parameters, found.directions = law.name, ground, None
    if "nu" in has:
        records.append({"id": "compressibility", "form": "uniform", "parameters": {"nu": sheet.parameters["nu"]}})
    found.effects = records + (document.effects or [])
    return found


def stays_away(kind: str, form: str, given: Container[str]) -> frozenset[str]:
    """Return the constants that a term has not among those ``given`` since nothing is there."""
    rest = kind == "anisotropy" and anisotropy.FORMS[form] is REST
    return frozenset(name for name in REST.names if rest and name not in given)


def poisson_of(record: Mapping[str, Any]) -> float | None:
    """Return Poisson's ratio of a sheet's ground, None of a term that is not told by one."""
    if record["id"] != "compressibility":
        return None
    return compressibility.FORMS[record["form"]].poisson(np.array(list(record["parameters"].values())))
