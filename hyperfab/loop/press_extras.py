"""What could be read in a press next."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from hyperfab.loop.press_reading import Kind, Reading, Setting
from hyperfab.loop.press_table import PressTable

#: Readings at places: of which kind, and how they are taken.
_THERE: tuple[tuple[Kind, str], ...] = (
    ("pressure", "a pressure film over the whole male, 80 places"),
    ("thickness", "the thickness of the pressed sandwich at 80 places (clay or lead between the molds)"),
    ("contact", "spotting paste over the whole male, 80 places"),
)
#: What a reading is off by: a share of the largest pressure and force; thickness, fabrics and mounting face [mm], an
#: edge of contact [-].
_SHARE = {"pressure": 0.03, "force": 0.01}
_SIZE = {"thickness": 0.02, "contact": 0.3, "fabric": 0.01, "mounting": 0.01}


def menu(
    setting: Setting, summed: PressTable, places: PressTable, loudest: Mapping[str, float]
) -> Iterator[tuple[Reading, Mapping[str, Any], float]]:
    """Yield each reading, called by what to do, its details, and what it would be off by.

    ``loudest`` are the largest pressure [MPa] and force [N].
    """
    some = np.linspace(0, len(places.foam) - 1, 80).astype(np.int64)
    corners, weights = np.repeat(some[:, None], 3, axis=1), np.full((80, 3), 1.0 / 3.0)
    found = [Reading(text, kind, np.zeros(80), corners, weights) for kind, text in _THERE]
    travel = max(summed.first_touch - summed.openings[0] - 0.3, 0.1)
    text = "force over stroke, 40 readings from the first touch to the deepest"
    force = Reading(text, "force", np.zeros(40), stroke=np.linspace(0.02, travel, 40))
    found.append(force)
    if not setting.floating:
        text = "dial gauges at four sides of the female's mounting face"
        sides = setting.half_mm * np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
        found.append(Reading(text, "mounting", np.zeros(4), places=sides))
    if sum(setting.fabric) > 0.0:
        text = "the thickness of the fabrics alone under rising pressure (ISO 5084)"
        found.append(
            Reading(text, "fabric", np.zeros(10), load=loudest["pressure"] * np.linspace(0.1, 1.0, 10))
        )
    if setting.cold is not None:
        text = f"force over stroke with the molds at {setting.cold.temperature:g} degC"
        found.append(replace(force, name=text, temperature=setting.cold.temperature, warmth=setting.cold))
    for one in found:
        details = {"reading": one.kind} | (
            {} if one.temperature is None else {"temperature_degC": one.temperature}
        )
        yield one, details, _SIZE.get(one.kind) or _SHARE[one.kind] * max(loudest[one.kind], 1e-9)
