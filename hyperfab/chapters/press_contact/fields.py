"""What ``hf press-contact`` writes beside its document: the field on the male's surface, the curve, the pictures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.press_contact.formed import part_of as formed_part
from hyperfab.chapters.press_contact.nearby import ROOM
from hyperfab.chapters.press_contact.result import PressResult
from hyperfab.chapters.uncertainty.carry import Sure
from hyperfab.documents.press import PressDocument
from hyperfab.io import vtu
from hyperfab.report.bands import banded


def grid_of(told: PressResult, sure: Mapping[str, Array] = {}) -> bytes:
    """Return the male's front, where its drawing has it, with the gap and what the sandwich does, as .vtu.

    ``sure`` are standard deviations of fields, where they are known.
    """
    closed = told.closed
    front, contact, sandwich = closed.front, closed.contact, closed.press.sandwich
    final = told.final_thickness
    reached = None if told.warmed is None else told.warmed.reached
    return vtu.unstructured(
        told.frame.outward(closed.cold),
        {"triangle": front.faces},
        {
            "gap_mm": contact.gap,
            "gap_normal_mm": closed.normal,
            "gap_axial_mm": closed.axial,
            "sandwich_mm": np.broadcast_to(np.asarray(sandwich.thickness), contact.gap.shape),
            "compression": sandwich.strain(contact.gap),
            "pressure_MPa": contact.pressure,
            **({} if final is None else {"final_thickness_mm": final}),
            **({} if told.warmed is None else {"middle_degC": told.warmed.middle}),
            **({} if reached is None else {"target_s": reached}),
            **_formed_fields(told),
            "contact": (closed.touch < sandwich.thickness).astype(np.uint8),
            "at_border": closed.at_border.astype(np.uint8),
            "oblique": closed.oblique.astype(np.uint8),
            "state": sandwich.state(contact.gap).astype(np.uint8),
            "growth_mm": told.frame.outward(front.vertices - closed.cold),
            **_sure_fields(told, sure),
        },
        {"contact_share": closed.touching / front.areas, "flange": front.flange},
    )


def _sure_fields(told: PressResult, sure: Mapping[str, Array]) -> dict[str, Array]:
    if not sure:
        return {}
    from scipy.special import ndtr

    room, sd = told.closed.press.sandwich.thickness - told.closed.touch, sure[ROOM]
    never = np.where(sd > 0.0, sd, 1.0)
    touches = np.where(sd > 0.0, ndtr(room / never), (room > 0.0).astype(float))
    return {
        **{f"{name}_sd": sure[name] for name in ("gap_mm", "compression", "pressure_MPa")},
        "touch_probability": touches,
    }


def _formed_fields(told: PressResult) -> dict[str, Array]:
    if told.formed is None:
        return {}
    found = {"formed_thickness_mm": told.formed.thickness, "set": told.formed.share}
    found["springback_mm"] = told.formed.springback
    if told.wanted is not None:
        found["off_wanted_mm"] = told.formed.thickness - told.wanted.at(told.closed.cold)
    return found


def picture_of(told: PressResult, document: PressDocument, sure: Sure) -> bytes:
    """Return the picture: the spotted male, the gap's histogram, force over stroke, and how ``sure`` both are."""
    from hyperfab.report.figures_press import SpottedMold, spotting

    closed = told.closed
    front, sandwich = closed.front, closed.press.sandwich
    mold = SpottedMold(
        vertices=front.vertices,
        faces=front.faces,
        normals=front.normals,
        gap=closed.contact.gap,
        pressure=closed.contact.pressure,
        level=np.asarray(sandwich.thickness - closed.touch),
        areas=front.molding_areas,
        thickness=document.sandwich_mm,
        axes=told.frame.plan,
    )
    data = document.to_json()
    title = (
        f"touching {banded(data, 'contact_fraction', '%', 100.0, '.1f')} of the molding surface, gap "
        f"{document.gap_min_mm:.2f} to {document.gap_max_mm:.2f} mm, closing force "
        f"{banded(data, 'force_N', 'N', form='.3g')}"
    )
    return spotting(mold, told.curve[:, :2], title, (sure.interval("stroke_mm"), sure.interval("force_N")))


def formed_picture(told: PressResult) -> bytes:
    """Return the picture of what is formed, and of what it misses by."""
    from hyperfab.report.figures_press import FormedMold, formed_map

    assert told.formed is not None
    front = told.closed.front
    fields = _formed_fields(told)
    mold = FormedMold(
        vertices=front.vertices,
        faces=front.faces[~front.flange],
        thickness=fields["formed_thickness_mm"],
        off=fields.get("off_wanted_mm"),
        axes=told.frame.plan,
    )
    beside = "" if told.beside is None else f", off by {told.beside.worst_mm:+.2f} mm at most"
    part = formed_part(told.formed, told.closed, told.closed.cold)
    return formed_map(mold, f"formed thickness {part.thickness_min_mm:.2f} to {part.thickness_max_mm:.2f} mm{beside}")
