"""The male that leaves the gap that is asked for, as an STL file, or the place where there is none."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hyperfab.documents.press import DesignPart
from hyperfab.errors import InputError
from hyperfab.io.stl_write import stl_bytes
from hyperfab.pressing.closing import Closed
from hyperfab.pressing.design import Design, DesignRefused, constant_gap, with_back
from hyperfab.pressing.growth import Growth, ungrown
from hyperfab.pressing.mold import PressFrame


def design_of(closed: Closed, frame: PressFrame, gap: float, growth: Growth) -> tuple[bytes, DesignPart]:
    """Return the STL of the cold male whose hot gap is constant; refused with the place where there is none."""
    found = place_of_design(frame, lambda: constant_gap(closed.female, gap), f"--design-gap {gap:g} mm")
    cold = ungrown(found.vertices, growth)
    vertices, faces = with_back(cold, found.faces, closed.case.male.mount)
    data = stl_bytes(frame.outward(vertices), faces)
    return data, DesignPart(gap_mm=gap, spread_mm=found.spread, facets=len(faces))


def place_of_design(frame: PressFrame, made: Callable[[], Design], asked: str = "--compensate") -> Design:
    """Return what ``made`` gives; refused with the place in the drawing where there is none."""
    try:
        return made()
    except DesignRefused as error:
        at = ", ".join(f"{value:.1f}" for value in frame.outward(np.array(error.at)))
        raise InputError(
            f"{asked}: the surface {error.what} near ({at}) mm, on {error.faces} facets",
            remedy="ask for a smaller gap, or give the female a larger radius or more draft there",
        ) from None
