"""What was read in a press, how the press was set, and what terms change of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import prod
from typing import Any, Literal

import numpy as np
from scipy.special import ndtr, ndtri

from hyperfab.arrays import Array, Ints
from hyperfab.loop.scatter import Guess, guess_of_cloud, guess_of_curve, usual_noise
from hyperfab.loop.thresholds import FEWEST
from hyperfab.pressing.foam_law import FoamLaw
from hyperfab.pressing.sandwich import Sandwich

Kind = Literal["pressure", "contact", "thickness", "force", "formed", "fabric", "mounting"]

#: Units the readings are told in.
UNITS: dict[str, str] = {
    "pressure": "MPa",
    "contact": "-",
    "thickness": "mm",
    "force": "N",
    "formed": "mm",
    "fabric": "mm",
    "mounting": "mm",
}
#: Kinds that are read at places of the male.
THERE = ("pressure", "contact", "thickness", "formed")
#: A place reads half contact half open over this much of a gap [mm]: a film's or a paste's own thickness.
CONTACT_BLUR = 0.05
#: Gaps [mm] that an edge of contact may be read over; the most of places that are taken for the other kind anywhere;
#: and the share of contact beyond which a place is as good as far from the edge.
_WIDTHS, _ASTRAY, _FAR = CONTACT_BLUR * 2.0 ** np.arange(0.0, 5.1, 0.5), 0.01, 1e-15
#: What a dial gauge is off by [mm].
_GAUGE = 0.01


@dataclass(frozen=True)
class Warmth:
    """The press at another ``temperature`` [degC] than the model's: strains (2,) by which male and female have
    ``grown`` beyond it, and the foam's ``law`` there, None where the model has one for all temperatures. ``share`` of
    a strain that heat has made at the model's temperature is there at this one."""

    temperature: float
    grown: tuple[float, float]
    law: FoamLaw | None = None
    share: float = 1.0


@dataclass(frozen=True)
class Reading:
    """One file: ``kind`` and values (m,); at places of the male (``corners`` (m, 3) of the table of the places with
    their ``weights``) or at machine ``stroke`` (m,) [mm]; ``time_s`` since the foam was first
    pressed; ``index`` is where the rows stand in the file. ``formed`` is thickness when the press has opened,
    ``fabric`` that of the fabrics alone under a ``load`` (m,) [MPa], ``mounting`` how much further (less their mean)
    the female's mounting face stands from the male at ``places`` (m, 3) of the press frame. The molds are at
    ``temperature`` [degC], with what that makes of the press in ``warmth``; None: as the model has them. ``sd`` (m,) is
    what the file states of its values, ``below`` (m,) [MPa] what may press where a film reads nothing, 0 elsewhere.
    """

    name: str
    kind: Kind
    values: Array
    corners: Ints | None = None
    weights: Array | None = None
    places: Array | None = None
    stroke: Array | None = None
    time_s: Array | None = None
    index: Ints | None = None
    load: Array | None = None
    temperature: float | None = None
    warmth: Warmth | None = None
    sd: Array | None = None
    below: Array | None = None

    @property
    def along(self) -> Array | None:
        """What the readings (m,) were taken along: the stroke, or the load; None of those at places."""
        return self.load if self.stroke is None else self.stroke

    @property
    def least(self) -> float:
        """The pressure [MPa] at which a film begins to show: the least that was read where other places read nothing
        and so many up to twice as much that none below it would be chance; 0 where nothing says so."""
        shown = self.values[self.values > 0.0]
        if self.kind != "pressure" or len(shown) == 0 or np.min(self.values) != 0.0:
            return 0.0
        least = float(np.min(shown))
        return least if np.count_nonzero(shown <= 2.0 * least) > FEWEST else 0.0

    def guess(self, predicted: Array) -> Guess:
        """Return how loud the readings seem, by what neighbours differ by, or by that less a prediction (m,)."""
        if self.along is not None:
            return guess_of_curve(self.values, self.along, self.time_s)
        if self.kind == "mounting":
            return Guess(_GAUGE, 2.0, "a dial gauge")
        assert self.places is not None
        return _cloud(self.kind, self.places, self.values, predicted)

    def there(self, values: Array) -> Array:
        """Return ``values`` (n,) of the vertices at the places (m,)."""
        assert self.corners is not None
        assert self.weights is not None
        return np.asarray(np.sum(values[self.corners] * self.weights, axis=1))

    def shown(self, sandwich: Sandwich, gap: Array) -> Array:
        """Return what is read (m,) at places of the closed press, of a ``sandwich`` in the gap (n,) at the vertices:
        for contact that along the normal, else the nearest one."""
        here, opening = sandwich.at(self.there), self.there(gap)
        if self.kind == "contact":
            return np.asarray(ndtr((here.thickness - opening) / CONTACT_BLUR))
        if self.kind == "pressure":
            return np.asarray(here.pressure(opening))
        pressed, fabric = here.pressed(opening)
        return np.asarray(fabric + pressed)

    def rows(self, chosen: Ints) -> Reading:
        """Return some of the rows, in that order."""
        parts: dict[str, Any] = {
            key: None if value is None else value[chosen]
            for key, value in vars(self).items()
            if key not in ("name", "kind", "temperature", "warmth")
        }
        return replace(self, **parts)


def _cloud(kind: str, places: Array, values: Array, predicted: Array) -> Guess:
    """Return the noise of scattered readings: what neighbours differ by, less what the model says they do.

    Where nothing presses a film reads nothing, to the last digit: only where it reads is it as loud as it is.
    """
    if kind == "pressure" and np.min(values) == 0.0 < np.max(values):
        places, predicted, values = (one[values > 0.0] for one in (places, predicted, values))
    plain = guess_of_cloud(places, values)
    if kind == "contact":
        return _edge(values, predicted, plain)
    less = guess_of_cloud(places, values - predicted, np.abs(values))
    guess = min(plain, less, key=lambda guess: guess.size)
    # Of so few neighbours are as far off each other by what presses there: by them no instrument is louder than usual.
    few = usual_noise(np.abs(values))
    return few if len(values) < 2 * FEWEST and guess.size > few.size else guess


def _edge(values: Array, predicted: Array, plain: Guess) -> Guess:
    """Return the noise of ones and zeros (n,): those of a draw whose chance falls off about the edge that the model
    has, over as much of a gap as suits them best.

    What neighbours differ by would not tell: how far places lie apart makes that, and noise is at the edge alone.

    >>> gap, z = np.linspace(-1.0, 1.0, 401), np.random.default_rng(1).standard_normal(401)
    >>> read = (gap + 0.2 * z < 0.0).astype(float)
    >>> guess = _edge(read, ndtr(-gap / CONTACT_BLUR), Guess(0.3, 200.0, ""))
    >>> [round(float(guess.rows[row]), 1) for row in (0, 200, 400)]
    [0.1, 0.5, 0.1]
    """
    inside = CONTACT_BLUR * ndtri(np.clip(predicted, _FAR, 1.0 - _FAR))
    # Of many places, none of them astray, fewer are than of a few.
    astray = {_ASTRAY, min(_ASTRAY, 1.0 / len(values))}
    shares = [one + (1.0 - 2.0 * one) * ndtr(inside / width) for width in _WIDTHS for one in sorted(astray)]
    share = max(shares, key=lambda one: float(np.sum(np.log(np.where(values > 0.5, one, 1.0 - one)))))
    rows = np.sqrt(share * (1.0 - share) + (share - predicted) ** 2)
    return Guess(float(np.sqrt(np.mean(rows**2))), plain.dof, plain.source, rows=rows)


@dataclass(frozen=True)
class Setting:
    """How the press was set: the opening [mm] without a yielding frame, or the force [N]; ``compliance`` [mm/N] of
    the frame the model has already; ``zero_rate`` (2,) is what resetting the clearance hot gives back per strain of
    male and female [mm]; a ``floating`` female turns until nothing has a moment about its joint, whatever lies between.
    Terms of the foam's thickness are shares of ``thickness`` [mm]. ``fabric`` (below, above) [mm] are the layers,
    ``tilt`` (2,) [rad] is what the model has, ``half_mm`` half the male's width. The molds are at ``temperature``
    [degC]; ``cold`` is the press as it was drawn, where that is another.
    """

    opening: float
    force: float | None = None
    compliance: float = 0.0
    zero_rate: tuple[float, float] = (0.0, 0.0)
    floating: bool = False
    thickness: float | None = None
    fabric: tuple[float, float] = (0.0, 0.0)
    tilt: tuple[float, float] = (0.0, 0.0)
    half_mm: float = 1.0
    temperature: float = 20.0
    cold: Warmth | None = None


@dataclass(frozen=True)
class Frame:
    """How far [mm] a frame opens under the force [N]: its ``compliance`` [mm/N], and ``play`` [mm] beside it that is
    taken up as the force passes ``taken_up`` [N].

    >>> [round(float(Frame(0.001, 0.2, 10.0).opens(force)), 3) for force in (0.0, 10.0, 100.0)]
    [0.0, 0.136, 0.3]
    """

    compliance: float = 0.0
    play: float = 0.0
    taken_up: float = 1.0

    @property
    def rigid(self) -> bool:
        """Whether it opens under no force."""
        return self.compliance == 0.0 and self.play == 0.0

    def opens(self, force: Array | float) -> Array | float:
        """Return how far [mm] it opens."""
        if self.play == 0.0:
            return self.compliance * force
        return self.compliance * force - self.play * np.expm1(-np.maximum(force, 0.0) / self.taken_up)


@dataclass
class Changes:
    """What terms change of a press, each adding its own to what the model has.

    tilt        (2,) [rad] of a guided female about the two axes across, and its ``offset`` (2,) [mm] along them
    strain      (2,) of male and female
    lost        each tells the share of the foam's thickness that is lost when a reading is taken: one, or one a row
    uneven      relative thickness over the plan: coefficients by their terms, as ``xxy``
    frame       how far the frame opens, beyond what it does in the model
    across      how both fabrics give way across, None where they are rigid
    stays       share of the foam's strain that stays, and what it has more at a strain of 1, (2,)
    left        each tells the share of the foam's pressure that is left when a reading is taken: one, or one a row
    """

    tilt: Array = field(default_factory=lambda: np.zeros(2))
    offset: Array = field(default_factory=lambda: np.zeros(2))
    strain: Array = field(default_factory=lambda: np.zeros(2))
    lost: list[Callable[[Reading], Array | float]] = field(default_factory=list)
    uneven: dict[str, float] = field(default_factory=dict)
    frame: Frame = Frame()
    across: FoamLaw | None = None
    stays: Array = field(default_factory=lambda: np.zeros(2))
    left: list[Callable[[Reading], Array | float]] = field(default_factory=list)

    @classmethod
    def of(cls, amounts: Mapping[str, float]) -> Changes:
        """Return what amounts at places change: those of ``Problem.amounts``."""

        def at(*places: str) -> Array:
            return np.array([amounts.get(place, 0.0) for place in places])

        return cls(
            tilt=np.radians(at("tilt_x_deg", "tilt_y_deg")),
            offset=at("offset_x_mm", "offset_y_mm"),
            strain=at("strain_male", "strain_female"),
            uneven={name.removeprefix("uneven."): v for name, v in amounts.items() if name.startswith("uneven.")},
            stays=at("stays", "stays_more"),
        )

    @property
    def settings(self) -> Array:
        """How both molds stand: tilts, strains and offsets (6,), as ``PressTable.moved`` takes them."""
        return np.concatenate([self.tilt, self.strain, self.offset])

    def factor(self, reading: Reading) -> Array | float:
        """Return the share of the foam's pressure that is left when a reading is taken."""
        return prod(one(reading) for one in self.left)

    def thickness(self, reading: Reading) -> Array | float:
        """Return the share of the foam's thickness that is left when a reading is taken."""
        return prod(1.0 - one(reading) for one in self.lost)


def variation(plan: Array, terms: Mapping[str, float]) -> Array | float:
    """Return the relative change (n,) of foam thickness over the plan (n, 2); 0 where there is no term.

    >>> variation(np.array([[0.5, -2.0]]), {"x": 0.1, "xyy": 0.02}).tolist()
    [0.09]
    """
    x, y = plan[:, 0], plan[:, 1]
    return sum(c * x ** name.count("x") * y ** name.count("y") for name, c in terms.items())
