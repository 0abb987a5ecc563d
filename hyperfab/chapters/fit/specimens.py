"""Sizes of standard specimens, and what the shape of a specimen does to a test."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hyperfab.cases.reading import ReadingCase
from hyperfab.chapters.look import named
from hyperfab.errors import UsageError
from hyperfab.io.csv_tests import TestData
from hyperfab.io.specimen import Geometry

#: Gauge length and width [mm] of standard specimens, by ISO 527-2:2012, ISO 527-3:2018 (type 2, a strip of 10 to 25 mm:
#: its width is measured), ISO 37:2017, ASTM D412-16, ISO 13934-1:2013 and -2:2014. The thickness is always measured.
STANDARD: Mapping[str, Geometry] = {
    "iso-527-1a": Geometry(gauge_length=75.0, width=10.0),
    "iso-527-1b": Geometry(gauge_length=50.0, width=10.0),
    "iso-527-1ba": Geometry(gauge_length=25.0, width=5.0),
    "iso-527-1bb": Geometry(gauge_length=10.0, width=2.0),
    "iso-527-5a": Geometry(gauge_length=20.0, width=4.0),
    "iso-527-3-2": Geometry(gauge_length=50.0),
    "iso-37-1": Geometry(gauge_length=25.0, width=6.0),
    "iso-37-2": Geometry(gauge_length=20.0, width=4.0),
    "iso-37-3": Geometry(gauge_length=10.0, width=4.0),
    "iso-37-4": Geometry(gauge_length=10.0, width=2.0),
    "astm-d412-c": Geometry(gauge_length=25.0, width=6.0),
    "astm-d412-a": Geometry(gauge_length=50.0, width=12.0),
    "iso-13934-1": Geometry(gauge_length=200.0, width=50.0),
    "iso-13934-1-short": Geometry(gauge_length=100.0, width=50.0),
    "iso-13934-2-grab": Geometry(gauge_length=100.0, width=25.0),
}


#: How much stiffer a strip of an isotropic, incompressible sheet is at small strain whose ends keep their width, times
#: its length over its width: 0.067 at 2, 0.066 at 4, 0.065 at 8 by finite elements (plane stress).
HELD = 0.066


def geometry(case: ReadingCase) -> Geometry:
    """Return the sizes that a case asks for: those of a standard specimen, each replaced where it is given."""
    if case.specimen is not None and case.specimen not in STANDARD:
        raise UsageError(f"--specimen {case.specimen}: the known ones are {', '.join(STANDARD)}")
    base = STANDARD[case.specimen] if case.specimen is not None else Geometry()
    given = {name: getattr(case, name) for name in ("gauge_length", "width", "thickness", "diameter")}
    return replace(base, **{name: value for name, value in given.items() if value is not None})


def aspect_warnings(tests: Sequence[TestData]) -> list[str]:
    """Say which specimens are not as slender, or as wide, as their test takes for granted: once for all of a shape."""
    alike: dict[str, list[str]] = {}
    for test in tests:
        if test.gauge_length_mm is None or test.width_mm is None:
            continue
        ratio = test.gauge_length_mm / test.width_mm
        pulled = float(np.max(test.stretch)) - 1.0 > 1.0 - float(np.min(test.stretch))
        if test.mode == "uniaxial" and pulled and ratio < 9.5:
            text = (
                f"the specimen is {ratio:.2g} times as long as wide; below 10 its ends hinder the "
                f"contraction and it reads too stiff for uniaxial tension: about {100.0 * HELD / ratio:.2g} % at the "
                "first if it contracts as rubber does, less if less"
            )
            alike.setdefault(text, []).append(test.source)
        if test.mode == "shear" and not 3.9 <= 1.0 / ratio <= 10.1:
            text = f"the specimen is {1 / ratio:.2g} times as wide as long; planar tension takes 4 to 10"
            alike.setdefault(text, []).append(test.source)
    return [f"{named(sources)}: {text}" for text, sources in alike.items()]
