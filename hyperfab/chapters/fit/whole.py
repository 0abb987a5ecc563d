"""One energy for all tests of a material: what the fits of a whole sheet and of a foam have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.fit.describe import deviations, uncertainty
from hyperfab.chapters.fit.identify import Setting, compared, nearest, specimen_of
from hyperfab.chapters.fit.readings import Readings
from hyperfab.curve import TestCurve
from hyperfab.documents.material import (
    AtTemperature,
    FitFigures,
    MaterialDocument,
    Parameters,
    TestFigures,
    Undetermined,
    Unpredicted,
)
from hyperfab.errors import InputError
from hyperfab.materials.identification.quality import Certainty, Figures, figures

#: The stresses at the rows of a curve along both of its axes, and the stretch across of a uniaxial test.
Answer = tuple[Array, Array | None, Array | None]


EnergyT = TypeVar("EnergyT")


@dataclass(frozen=True)
class WholeFit(ABC, Generic[EnergyT]):
    """The law at each of ``temperatures`` (one, None, where the tests tell none), at ``reference`` in full.

    ``undetermined`` are the constants that no test here speaks of.
    """

    laws: tuple[EnergyT, ...]
    temperatures: tuple[float | None, ...]
    reference: int
    curves: Sequence[TestCurve]
    setting: Setting
    undetermined: list[Undetermined] = field(default_factory=list)

    @abstractmethod
    def predict(self, curve: TestCurve) -> Answer:
        """Return nominal stresses [MPa] along both axes, and the lateral stretch of a uniaxial test."""

    @property
    @abstractmethod
    def stable(self) -> bool:
        """Whether the law is stable over the stretches of the tests."""

    @abstractmethod
    def document(self, readings: Readings) -> MaterialDocument:
        """Return the material document."""

    @abstractmethod
    def ranges(self, document: MaterialDocument) -> Iterator[tuple[TestCurve, tuple[float, float] | None]]:
        """Return the curves that are judged by the range the constants were fitted over, and that range."""

    @abstractmethod
    def curves_csv(self) -> bytes:
        """Return every reading with what the law says beside it."""

    @abstractmethod
    def picture(self) -> bytes:
        """Return the PNG of the fit."""

    @property
    def law(self) -> EnergyT:
        """The law at the reference temperature."""
        return self.laws[self.reference]

    def law_at(self, temperature: float | None) -> EnergyT:
        """Return the law of the nearest temperature that was fitted."""
        return self.laws[nearest(self.temperatures, temperature, self.reference)]

    def constants(
        self,
        seen: Callable[[EnergyT], Parameters],
        figures: Callable[[int], FitFigures | None] = lambda number: None,
    ) -> list[AtTemperature] | None:
        """Return the constants at each temperature of the tests, where there are several, and their ``figures``."""
        if len([t for t in self.temperatures if t is not None]) < 2:
            return None
        return [
            AtTemperature(temperature_degC=t, parameters=seen(law), fit=figures(number))
            for number, (t, law) in enumerate(zip(self.temperatures, self.laws, strict=True))
            if t is not None
        ]

    def error(self, curves: Sequence[TestCurve]) -> Figures | None:
        """Return how far the law is from the readings, None where it has no state of rest there."""
        return figures(*compared((curve, *self.predict(curve)[:2]) for curve in curves)) if curves else None

    def figures_of(
        self,
        curves: Sequence[TestCurve],
        groups: Mapping[str, Sequence[TestCurve]],
        through: tuple[float, ...] = (),
    ) -> FitFigures:
        """Return the figures over those of ``curves`` that are fitted, and of each group of them.

        The range of a group holds the stretches ``through``. InputError where the law has no stress on these rows.
        """
        tests: dict[str, TestFigures | Unpredicted] = {}
        for name, own in groups.items():
            predicted = None if own[0].mode in self.setting.fit_on else True
            found = self.error(own)
            if found is None:
                status = "no equilibrium of the specimen at these stretches"
                points = sum(len(curve.stretch) for curve in own)
                tests[name] = Unpredicted(points=points, predicted=predicted, status=status)
                continue
            reach = np.concatenate([through, *(curve.stretch for curve in own)])
            low, high = float(reach.min()), float(reach.max())
            tests[name] = TestFigures(**vars(found), stretch_min=low, stretch_max=high, predicted=predicted)
        total = self.error(self.setting.used(curves))
        if total is None:
            raise InputError("the law has no finite stress on these rows", file=curves[0].source)
        return FitFigures(**vars(total), tests=tests)

    def fitted_at(self, number: int) -> list[TestCurve]:
        """Return the curves that were fitted at one of the temperatures."""
        return [c for c in self.setting.used(self.curves) if c.is_at(self.temperatures[number])]

    def at(self, number: int, sure: Certainty) -> FitFigures | None:
        """Return the figures at one of the temperatures, and how sure its constants are; None without a stress."""
        curves = self.fitted_at(number)
        total = self.error(curves)
        return None if total is None else with_certainty(FitFigures(**vars(total)), sure, curves)

    def refuse_unstable(self, name: str, instead: str) -> None:
        """InputError where a stable law was asked for and this one, ``name``, is not; ``instead`` is a way out."""
        if self.setting.stable and not self.stable:
            raise InputError(
                f"no constants of {name} could be shown to be stable over the data",
                file=self.curves[0].source,
                remedy=f"leave --stable out, or {instead}",
            )


def with_certainty(figures: FitFigures, sure: Certainty, curves: Sequence[TestCurve]) -> FitFigures:
    """Return the figures with how sure the constants are that ``curves`` told."""
    figures.parameters_sd = deviations(sure)
    figures.uncertainty = uncertainty(sure, len({specimen_of(curve) for curve in curves}))
    if np.isfinite(sure.correlation).all():
        figures.correlation = sure.correlation.tolist()
    if np.isfinite(sure.condition_number):
        figures.condition_number = sure.condition_number
    return figures
