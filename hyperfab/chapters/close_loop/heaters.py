"""What the heaters of a mold drew, where a log of its thermocouples tells that too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hyperfab.arrays import Array
from hyperfab.documents.mold import MoldDocument
from hyperfab.io.headings import Heading, is_of
from hyperfab.io.layout import Layout, filled_in
from hyperfab.thermal.reduced import ReducedMold
from hyperfab.thermal.tables import Table


class Drawn(NamedTuple):
    """What some heaters of a mold, by their numbers, drew together (t,) [W], and what those ``beside`` them did too."""

    heaters: tuple[int, ...]
    power: Array
    beside: tuple[int, ...] = ()


def ruled(document: MoldDocument) -> list[int]:
    """Return the numbers of the heaters that have a thermostat."""
    return [number for number, heater in enumerate(document.heater) if heater.control is not None]


def own_power(number: int) -> str:
    """Return what the power of one heater is called."""
    return f"heater.{number}.power"


def ratings(document: MoldDocument) -> dict[str, float | None]:
    """Return the powers a log may tell, that of all heaters first, and what each is rated at [W]."""
    own = {own_power(number): heater.power for number, heater in enumerate(document.heater)}
    powers = [power for power in own.values() if power]
    alike = len(ruled(document)) in (0, len(own)) and len(powers) == len(own)
    return {"power": sum(powers) if alike else None, **own}


def read_powers(document: MoldDocument, powers: Mapping[str, Array]) -> list[Drawn]:
    """Return what the heaters of a mold drew, by the ``powers`` (t,) [W] of a log.

    What is told of all together is what those with a thermostat drew and the others, which do as the document says;
    where none has one, what all drew.
    """
    numbers = range(len(document.heater))
    found = [Drawn((number,), powers[name]) for number in numbers if (name := own_power(number)) in powers]
    left = [number for number in numbers if own_power(number) not in powers]
    if "power" in powers and left:
        heaters = tuple(number for number in ruled(document) if number in left) or tuple(left)
        rest = powers["power"] - sum((one.power for one in found), np.zeros_like(powers["power"]))
        found.append(Drawn(heaters, rest, tuple(number for number in left if number not in heaters)))
    return found


def heated_by(mold: ReducedMold, drawn: Drawn, times: Array, power: Array) -> ReducedMold:
    """Return the mold with a ``power`` (t,) [W] that heaters drew at ``times`` [s], shared as their ratings are."""
    rest = power - sum((mold.heaters[number][1](times) for number in drawn.beside), np.zeros(len(times)))
    rated = {number: float(np.max(mold.heaters[number][1].y)) for number in drawn.heaters}
    whole = sum(rated.values())
    heaters = list(mold.heaters)
    for number, own in rated.items():
        share = own / whole if whole else 1.0 / len(rated)
        heaters[number] = (heaters[number][0], Table(times, rest * share))
    step = np.abs(np.diff(rest)) > 0.02 * float(np.max(np.abs(rest)))
    turns = times[:-1][step].tolist() + times[1:][step].tolist()
    return replace(mold, heaters=heaters, corners=tuple(sorted({*mold.corners, *turns})))


def as_power(unread: Sequence[Heading], rated: Mapping[str, float | None], layout: Layout) -> str:
    """Return the options that take columns that nothing was read from as the power: all in its unit together, or those
    in per cent as shares of what is ``rated`` [W], where they can be told."""
    told = [one.entry for one in layout.columns]
    whole, own = rated["power"], {name: power for name, power in rated.items() if name != "power"}
    drawn = [one for one in unread if is_of(one.unit or "", "power")]
    if drawn:
        names = [*own] if len(drawn) == len(own) else ["power"] * len(drawn)
        each = [(one.title, f"{name} [{one.unit}]") for one, name in zip(drawn, names, strict=True)]
        return f"; if {', '.join(one.title for one in drawn)} is what they drew, {filled_in([*told, *each])}"
    titles = [one.title for one in unread if one.unit == "%"]
    if len(titles) == 1 and whole is not None:
        return (
            f"; if {titles[0]} is the share of {whole:g} W that was on, {filled_in([*told, (titles[0], 'power [%]')])}"
        )
    if len(titles) == len(own) and all(own.values()):
        each = [(title, f"{name} [%]") for title, name in zip(titles, own, strict=True)]
        return f"; if they are shares of what each heater is rated at, say whose, as in {filled_in([*told, *each])}"
    return ""
