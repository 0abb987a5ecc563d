"""Sections of ``foam.toml`` for what a real press adds to the drawing: tilt, a yielding frame, uneven or tired foam."""

from __future__ import annotations

import itertools
import math
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from hyperfab.documents.base import OrShort, Section
from hyperfab.documents.quantity import Angle, FoamRatio, MoldRatio, Shift, Stiffness, Time

#: A press further out of parallel is broken, or the angle is a slip of the pen.
MOST_TILT_DEG = 5.0


class Tilt(Section):
    """How the female is turned about the drawing's axes; none about the closing axis."""

    x: Angle = 0.0
    y: Angle = 0.0
    z: Angle = 0.0

    @model_validator(mode="after")
    def _small(self) -> Tilt:
        if math.hypot(self.x, self.y, self.z) > MOST_TILT_DEG:
            raise ValueError(f"a press does not tilt by more than {MOST_TILT_DEG:g} deg")
        return self


class Offset(Section):
    """How far the female is mounted off the male's axis, along the drawing's axes; none along the closing axis."""

    x: Shift = 0.0
    y: Shift = 0.0
    z: Shift = 0.0


class PressSection(Section):
    """The press: how far its platens are out of parallel, how far the female is mounted off the axis, and how stiff
    the frame is (left out: rigid)."""

    tilt: Tilt = Tilt()
    offset: Offset = Offset()
    stiffness: Stiffness | None = None


class PoissonRatios(Section):
    """Poisson's ratios: of the foam, for its thinning where a drape stretches it; of the molds, for their deformation
    by an uneven temperature. A number alone is the foam's."""

    foam: FoamRatio | None = None
    male: MoldRatio = 0.33
    female: MoldRatio = 0.33


def _of_foam(value: object) -> object:
    return {"foam": value} if isinstance(value, int | float | str) and not isinstance(value, bool) else value


Poisson = Annotated[PoissonRatios, BeforeValidator(_of_foam), OrShort("number", "string")]


def _list(value: object) -> object:
    return value if isinstance(value, list) else [value]


def _one_or_several(item: Any, shown: dict[str, Any]) -> Any:
    """Return a list of up to nine, of which one may stand without brackets; ``shown`` is what the schema says of it."""
    schema = {"anyOf": [shown, {"type": "array", "items": shown}]}
    return Annotated[list[item], BeforeValidator(_list), Field(min_length=1, max_length=9), WithJsonSchema(schema)]


Shares: Any = _one_or_several(Annotated[float, Field(ge=0.0, le=1.0)], {"type": "number", "minimum": 0, "maximum": 1})
Times: Any = _one_or_several(Time, {"type": "string", "examples": ["15 s"]})


class Relaxation(Section):
    """How the foam's pressure fades while it is held: by ``sum share (1 - exp(-dwell / time))`` of it."""

    share: Shares = Field(default=[0.0])
    time: Times = Field(default=[1.0])
    dwell: Time | None = None

    @model_validator(mode="after")
    def _terms_fit(self) -> Relaxation:
        if len(self.share) != len(self.time):
            raise ValueError("share and time need one value a term each")
        if sum(self.share) > 0.99:
            raise ValueError("the shares add up to more than 0.99: nothing would be left of the pressure")
        return self


class Variation(Section):
    """How the foam's thickness varies over the male's plan, as shares of it.

    Thickness times ``1 + x u + y v + xx u^2 + xy u v + yy v^2 + xxx u^3 + ...``: u and v are the drawing's
    coordinates across the closing axis, from the middle of the male's plan (0) to its ends (-1 and 1).
    """

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    xx: float = 0.0
    xy: float = 0.0
    yy: float = 0.0
    xz: float = 0.0
    yz: float = 0.0
    zz: float = 0.0
    xxx: float = 0.0
    xxy: float = 0.0
    xyy: float = 0.0
    yyy: float = 0.0
    xxz: float = 0.0
    xzz: float = 0.0
    zzz: float = 0.0
    yyz: float = 0.0
    yzz: float = 0.0
    xxxx: float = 0.0
    xxyy: float = 0.0
    yyyy: float = 0.0
    xxzz: float = 0.0
    yyzz: float = 0.0
    zzzz: float = 0.0

    @model_validator(mode="after")
    def _some_is_left(self) -> Variation:
        terms = self.terms()
        axes = sorted(set("".join(terms)))
        steps = [-1.0 + 0.1 * i for i in range(21)]
        for point in itertools.product(steps, repeat=len(axes)):
            place = dict(zip(axes, point, strict=True))
            left = 1.0 + sum(value * math.prod(place[axis] for axis in name) for name, value in terms.items())
            if left < 0.1 or left > 1.9:
                raise ValueError("the shares add up to more than 0.9: somewhere nothing would be left of the foam")
        return self

    def terms(self) -> dict[str, float]:
        """The terms that are not zero."""
        found: dict[str, Any] = self.model_dump()
        return {name: value for name, value in found.items() if value != 0.0}
