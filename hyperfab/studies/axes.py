"""The axes of a study, laid out: every value an axis takes, with its unit, and the cases they make together."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hyperfab.arrays import Array
from hyperfab.documents.study import AxisSection, Number, SamplingSection, StudyDocument, Value
from hyperfab.errors import InputError, placed
from hyperfab.io.units import is_unit

#: A number, and what may be its unit: 20x30 has none.
_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*((?!x\d)[A-Za-z%°µμ].*?|1/.*?)?\s*")
#: Values that come out of a formula are rounded to this many digits, so that 0.1 + 0.2 reads 0.3.
_DIGITS = 12


@dataclass(frozen=True)
class Level:
    """One value of an axis: as it is written into a command or document, and as a number where it is one."""

    text: str
    value: float | int | bool | str

    @property
    def number(self) -> float | int | None:
        """The number, without its unit; None where the value is a word."""
        return None if isinstance(self.value, (str, bool)) else self.value


@dataclass(frozen=True)
class Axis:
    """One axis: its name, the unit all of its values share ("" for none), and its levels."""

    name: str
    unit: str
    levels: tuple[Level, ...]
    drawn: bool

    @property
    def column(self) -> str:
        """Name of the column in the table: the name and the unit.

        >>> Axis("film", "W/m^2/K", (), False).column
        'film_W_m2_K'
        """
        unit = re.sub(r"[^A-Za-z0-9]+", "_", self.unit.replace("^", "").replace("%", "percent")).strip("_")
        return f"{self.name}_{unit}" if unit and not self.name.endswith(f"_{unit}") else self.name


class Layout:
    """The cases of a study: each combination of listed values, with each drawn sample.

    The last axis of the study runs fastest; drawn axes move together and run fastest of all.
    """

    def __init__(self, study: StudyDocument, file: str) -> None:
        sampling = study.sampling
        self.samples = sampling.count if sampling is not None else 1
        self.listed: list[Axis] = []
        self.drawn: list[Axis] = []
        names = [name for name, section in study.axis.items() if section.drawn]
        quantiles = _quantiles(sampling, len(names)) if sampling is not None else np.empty((1, 0))
        for name, section in study.axis.items():
            with placed(file, f"axis.{name}"):
                if section.drawn:
                    self.drawn.append(_draw(name, section, quantiles[:, names.index(name)]))
                else:
                    self.listed.append(_list(name, section))
        self.order = list(study.axis)

    @property
    def axes(self) -> list[Axis]:
        """All axes, in the order of the study."""
        return sorted([*self.listed, *self.drawn], key=lambda axis: self.order.index(axis.name))

    def __len__(self) -> int:
        return math.prod(len(axis.levels) for axis in self.listed) * self.samples

    def case(self, index: int) -> dict[str, Level]:
        """Return the level of each axis in case ``index``, in the order of the study."""
        index, sample = divmod(index, self.samples)
        found = {axis.name: axis.levels[sample] for axis in self.drawn}
        for axis in reversed(self.listed):
            index, place = divmod(index, len(axis.levels))
            found[axis.name] = axis.levels[place]
        return {name: found[name] for name in self.order}


def _list(name: str, section: AxisSection) -> Axis:
    span = section.range or section.log_range
    if span is None:
        levels = [_level(value) for value in section.values or []]
        units = {unit for _, unit in levels}
        if len(units) > 1:
            raise InputError(
                f"mixes units: {', '.join(sorted(repr(unit) for unit in units))}",
                remedy="write all values of an axis in one unit",
            )
        found = tuple(level for level, _ in levels)
        if len({level.value for level in found}) < len(found):
            raise InputError("a value stands twice", remedy="keep one of them")
        return Axis(name, units.pop(), found, drawn=False)
    (first, last), unit = _numbers((span.first, span.last))
    if section.log_range is not None:
        _positive((first, last))
        values = np.geomspace(first, last, span.count)
    else:
        values = np.linspace(first, last, span.count)
    if first == last:
        raise InputError("goes from a value to the same value", remedy="give values = [...]")
    return Axis(name, unit, tuple(_written(value, unit) for value in values), drawn=False)


def _draw(name: str, section: AxisSection, quantiles: Array) -> Axis:
    from scipy.stats import norm

    values: Array
    between = section.uniform or section.log_uniform
    if between is not None:
        (first, last), unit = _numbers((between.first, between.last))
        if section.log_uniform is not None:
            _positive((first, last))
            values = np.exp(np.log(first) + quantiles * (np.log(last) - np.log(first)))
        else:
            values = first + quantiles * (last - first)
    elif section.normal is not None:
        (mean, sd), unit = _numbers((section.normal.mean, section.normal.sd))
        if sd <= 0:
            raise InputError("sd must be greater than 0", remedy="correct it")
        values = mean + sd * norm.ppf(quantiles)
    else:
        law = section.lognormal
        assert law is not None  # one kind is given: the document's validator saw to it
        (median,), unit = _numbers((law.median,))
        _positive((median,))
        values = median * np.exp(math.log(law.factor) * norm.ppf(quantiles))
    return Axis(name, unit, tuple(_written(value, unit) for value in values), drawn=True)


def _quantiles(sampling: SamplingSection, axes: int) -> Array:
    """Draw the unit cube; the same seed gives the same points."""
    from scipy.stats import qmc

    if sampling.method == "random":
        points = np.random.default_rng(sampling.seed).random((sampling.count, axes))
    elif sampling.method == "latin-hypercube":
        points = qmc.LatinHypercube(axes, rng=sampling.seed).random(sampling.count)
    else:
        # A Sobol sequence is balanced in powers of two; the first `count` points of it are kept.
        points = qmc.Sobol(axes, rng=sampling.seed).random_base2(max(sampling.count - 1, 0).bit_length())
        points = points[: sampling.count]
    return np.clip(np.asarray(points, dtype=np.float64), 1e-12, 1.0 - 1e-12)


def _level(value: Value) -> tuple[Level, str]:
    if not isinstance(value, str):
        return Level(str(value).lower() if isinstance(value, bool) else repr(value), value), ""
    match = _QUANTITY.fullmatch(value)
    if match is None or (match[2] and not is_unit(match[2])):  # 10mm.stl is a file
        return Level(value, value), ""
    number = float(match[1])
    return Level(value.strip(), number), match[2] or ""


def _numbers(values: Sequence[Number]) -> tuple[list[float], str]:
    numbers, units = [], set()
    for value in values:
        level, unit = _level(value)
        if level.number is None:
            raise InputError(f"{value!r} is no number", remedy='write 8 or "8 W/m^2/K"')
        numbers.append(float(level.number))
        units.add(unit)
    if len(units) > 1:
        raise InputError("the two ends have different units", remedy="write both in one unit")
    return numbers, units.pop()


def _positive(values: Sequence[float]) -> None:
    if min(values) <= 0.0:
        raise InputError("must be greater than 0 here", remedy="correct it")


def _written(value: float, unit: str) -> Level:
    number = float(f"{value:.{_DIGITS}g}")
    return Level(f"{number!r} {unit}" if unit else repr(number), number)
