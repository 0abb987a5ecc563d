"""What the dwell does to the sandwich: how warm its middle becomes, at every place and against time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.job import Job
from hyperfab.chapters.press_contact.laws import note_temperature
from hyperfab.chapters.press_contact.model import Model
from hyperfab.documents.foam import FoamDocument
from hyperfab.documents.press import WarmingPart
from hyperfab.documents.quantity import TableFile
from hyperfab.errors import InputError, NotConverged
from hyperfab.io.csv_table import read_table
from hyperfab.io.inputs import Inputs
from hyperfab.pressing.closing import Closed, close_press, press_again
from hyperfab.pressing.curved import barycentric
from hyperfab.pressing.warming import Column

#: Times of the dwell that are told, close together at its beginning, where the most happens.
_TIMES = 16
#: The temperature at which the foam's law is read has settled when it moves by less [K]; it takes two to five rounds.
SETTLED, MOST_ROUNDS = 1e-7, 40
#: A layer is never pressed thinner than this [mm]: where the molds interfere there is no sandwich.
_THINNEST = 1e-3
#: Air: conductivity [W/m/K] against temperature [degC] (Incropera and DeWitt, Fundamentals of Heat and Mass Transfer,
#: table A.4).
_AIR = (
    (-23.15, 26.85, 76.85, 126.85, 176.85, 226.85, 276.85),
    (0.0223, 0.0263, 0.0300, 0.0338, 0.0373, 0.0407, 0.0439),
)


@dataclass(frozen=True)
class Warmed:
    """The sandwich at the male's front after ``dwell`` [s] between the molds.

    ``column`` tells its temperature at any time and depth; ``middle`` (n,) [degC] is that of the foam's middle at the
    end, ``over_time`` rows of time [s] and its least, mean and greatest over the molding surface; ``target`` [degC] is
    passed at ``reached`` (n,) [s], NaN where it is not.
    """

    column: Column
    dwell: float
    middle: Array
    over_time: Array
    target: float | None
    reached: Array | None


def warmed(job: Job, model: Model, closed: Closed) -> Warmed | None:
    """Return how warm the sandwich becomes; None where no dwell is asked for."""
    dwell, target = model.case.dwell, model.case.target
    if dwell is None:
        return None
    column = column_of(job, model, closed)
    area = closed.front.molding_areas
    times = dwell * (np.arange(1, _TIMES + 1) / _TIMES) ** 2
    middle = column.at(times)
    over = middle[:, area > 0.0]
    rows = np.stack([times, over.min(axis=1), np.average(middle, axis=1, weights=area), over.max(axis=1)], axis=1)
    reached = None if target is None else column.reaches(target, dwell)
    return Warmed(column, dwell, middle[-1], rows, target, reached)


def by_place(model: Model) -> bool:
    """Return whether the foam's law is read at the temperature of each place, and not at that of the molds."""
    even = all(grown.celsius is None for grown in model.grown)
    return len(model.files.law.laws) > 1 and (model.case.dwell is not None or not even)


def settled(job: Job, model: Model) -> Closed:
    """Close the press with the foam's law at the temperature of each place.

    With a dwell that is the foam's middle at its end, else the mean of both molds there. Temperature and pressing
    depend on each other through contact, thickness and position: both are repeated until neither moves.
    """
    closed, laws = close_press(model.closing), model.files.law
    if not by_place(model):
        return closed
    before: Array | None = None
    for _ in range(MOST_ROUNDS):
        there = foam_temperature(job, model, closed)
        if before is not None and np.abs(there - before).max() <= SETTLED:
            break
        # Beside the front nothing is pressed: any temperature will do there.
        celsius = np.full(len(model.closing.male.vertices), there.mean())
        celsius[closed.front.of_mold] = there
        sandwich = replace(model.closing.sandwich, law=laws.at(celsius))
        closed, before = press_again(closed, sandwich), there
    else:
        raise NotConverged(
            "the foam's temperature and its pressing do not settle on each other",
            remedy="set the position with --gap, or give the foam one law",
        )
    note_temperature(job, model.case.foam, model.files.document, there)
    return closed


def foam_temperature(job: Job, model: Model, closed: Closed) -> Array:
    """Temperature (n,) [degC] of the foam at the front, at which its law is read."""
    if model.case.dwell is None:
        return np.asarray(0.5 * sum(_on_molds(model, closed)))
    return np.asarray(column_of(job, model, closed).at([model.case.dwell])[-1])


def column_of(job: Job, model: Model, closed: Closed) -> Column:
    """Return the column of heat at every place of the front: layers as they are pressed there, molds as hot as there.

    The sandwich lies on the male; where it is not touched, the air up to the female conducts. A table of contact
    conductance is read at the pressure.
    """
    name, document, layers = model.case.foam, model.files.document, model.files.fabrics
    sandwich, gap = closed.press.sandwich, closed.contact.gap
    foam, fabric = (np.maximum(part, _THINNEST) for part in sandwich.pressed(gap))
    of_fabric = document.fabric
    share = np.array([layers.below, layers.above]) / max(layers.thickness, 1e-300)
    pressed = np.stack([share[0] * fabric, foam, share[1] * fabric])
    # What is there to be heated is the same however it is pressed or has shrunk; stretched, it covers more.
    spread = 1.0 if model.files.thinned is None else model.files.thinned[0][closed.front.of_mold]
    uneven = np.broadcast_to(np.asarray(model.files.uneven, dtype=float), len(model.closing.male.vertices))
    laid = np.stack([np.full(len(gap), layers.below), document.thickness * uneven[closed.front.of_mold],
                     np.full(len(gap), layers.above)]) * spread  # fmt: skip
    conductivity, heat, density = (
        np.array([_known(document, key, name) if own is None else own, _known(document, key, name)])[[0, 1, 0]][:, None]
        for key, own in (
            ("conductivity", of_fabric.conductivity),
            ("specific_heat", of_fabric.specific_heat),
            ("density", of_fabric.density),
        )
    )
    male, female = _on_molds(model, closed)
    open_gap = np.maximum(gap - sandwich.thickness, 0.0)
    air = np.interp(0.5 * (male + female), *_AIR)
    contact = np.stack([_contact(job, document, name, closed.contact.pressure)] * 2)
    contact[1] += 1e-3 * open_gap / air
    start = document.expansion.reference if document.temperature is None else document.temperature
    return Column(start, male, female, contact, 1e-3 * pressed / conductivity, 1e-3 * laid * density * heat)


def part_of(warm: Warmed, closed: Closed, places: Array) -> WarmingPart:
    """Return what the document tells; ``places`` (n, 3) [mm] are the front's vertices as they are drawn."""
    area = closed.front.molding_areas
    there = np.flatnonzero(area > 0.0)
    coldest = int(there[np.argmin(warm.middle[there])])
    _, least, mean, most = (float(value) for value in warm.over_time[-1])
    found = WarmingPart(
        dwell_s=warm.dwell,
        start_degC=warm.column.start,
        middle_min_degC=least,
        middle_mean_degC=mean,
        middle_max_degC=most,
        middle_spread_K=most - least,
        middle_sd_K=float(np.sqrt(np.average((warm.middle - mean) ** 2, weights=area))),
        coldest_at_mm=(float(places[coldest, 0]), float(places[coldest, 1]), float(places[coldest, 2])),
        over_time=[(float(t), float(a), float(b), float(c)) for t, a, b, c in warm.over_time],
        target_degC=warm.target,
    )
    if warm.reached is not None:
        in_time = np.isfinite(warm.reached) & (area > 0.0)
        found.reached_fraction = float(area[in_time].sum() / area.sum())
        if in_time.any():
            found.reached_first_s = float(warm.reached[in_time].min())
        if in_time[there].all():
            found.reached_last_s = float(warm.reached[there].max())
    return found


def left_out(document: FoamDocument) -> list[str]:
    """What the temperature of the sandwich does not contain."""
    found = [
        "heat of reaction and of melting in the sandwich",
        "cooling of the molds by the sandwich",
        "heat along the sandwich, and radiation across open gaps",
    ]
    if document.contact_conductance is None:
        found.append("resistance between molds and sandwich where they touch: no contact_conductance is given")
    return found


def _known(document: FoamDocument, key: str, name: str) -> float:
    value = getattr(document, key)
    if value is None:
        examples = {"conductivity": "0.023 W/m/K", "specific_heat": "1045 J/kg/K", "density": "30 kg/m^3"}
        raise InputError(
            "--dwell tells the temperature of the sandwich, which needs it",
            file=name,
            key=key,
            remedy=f'give the foam\'s, as {key} = "{examples[key]}"',
        )
    return float(value)


def _contact(job: Job, document: FoamDocument, name: str, pressure: Array) -> Array:
    """Resistance (n,) [m^2 K/W] of each side's contact at a pressure [MPa]."""
    given = document.contact_conductance
    if given is None:
        return np.zeros(len(pressure))
    if not isinstance(given, TableFile):
        return np.full(len(pressure), 1.0 / given)
    path = Inputs.beside(name, given.table)
    columns = {"pressure": "stress", "conductance": "film-coefficient"}
    table = read_table(job.inputs.read(path), path, columns, increasing="pressure")
    table.refuse(
        table["conductance"] <= 0.0,
        "a conductance is above 0",
        column="conductance",
        remedy="leave out what does not touch: air conducts there by itself",
    )
    then = "its end rows hold there"
    job.ranges.used("contact_conductance", pressure, known=table["pressure"], source=name, unit="MPa", then=then)
    return np.asarray(1.0 / np.interp(pressure, table["pressure"], table["conductance"]))


def _on_molds(model: Model, closed: Closed) -> tuple[Array, Array]:
    """Temperature (n,) [degC] of the male at the front, and of the female at the place nearest to it."""
    male, female = model.grown
    feet = closed.front.vertices - closed.contact.gap[:, None] * closed.contact.direction
    corners = closed.female.faces[closed.contact.face]
    weights = barycentric(closed.female.surface, closed.contact.face, feet)
    # A foot on the smooth surface may lie beside its facet.
    weights /= weights.sum(axis=1, keepdims=True)
    at_vertices = female.surface(closed.case.female.vertices)
    return male.surface(closed.cold), np.asarray((weights * at_vertices[corners]).sum(axis=1))
