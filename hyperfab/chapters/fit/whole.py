"""One energy for all tests of a material: what the fits of a whole sheet and of a foam have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np

from hyperfab.arrays import Array
from hyperfab.chapters.fit.describe import document_of, with_certainty
from hyperfab.chapters.fit.identify import Setting, compared, kind_of, nearest, specimen_of, tested
from hyperfab.chapters.fit.readings import Readings
from hyperfab.chapters.fit.replicates import next_specimens, replicates
from hyperfab.curve import TestCurve
from hyperfab.documents.material import (
    AtTemperature,
    Direction,
    FitFigures,
    MaterialDocument,
    Parameters,
    StableRange,
    TestFigures,
    Undetermined,
    Unpredicted,
)
from hyperfab.errors import InputError
from hyperfab.materials.identification.quality import Certainty, Figures, figures, sure_of
from hyperfab.materials.identification.scatter import Weighed

if TYPE_CHECKING:  # to load them takes as long as a fit
    from hyperfab.materials.hyperfoam import Hyperfoam
    from hyperfab.materials.orthotropic import Orthotropic

#: The stresses at the rows of a curve along both of its axes, and the stretch across of a uniaxial test.
Answer = tuple[Array, Array | None, Array | None]


EnergyT = TypeVar("EnergyT", bound="Hyperfoam | Orthotropic")


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
    undetermined: list[Undetermined]

    @abstractmethod
    def predict(self, curve: TestCurve) -> Answer:
        """Return nominal stresses [MPa] along both axes, and the lateral stretch of a uniaxial test."""

    @abstractmethod
    def certainty(self, number: int) -> Certainty:
        """Return how sure the constants at one of the temperatures are."""

    @property
    @abstractmethod
    def figures(self) -> FitFigures:
        """The figures over all rows fitted, and of every test."""

    @property
    @abstractmethod
    def stability(self) -> dict[str, StableRange]:
        """The stretches of each test from rest over which the law is stable."""

    @property
    @abstractmethod
    def stable(self) -> bool:
        """Whether the law is stable over the stretches of the tests."""

    @property
    @abstractmethod
    def accepted(self) -> bool:
        """Whether the law carries the tests within the limit."""

    @abstractmethod
    def ranges(self, document: MaterialDocument) -> Iterator[tuple[TestCurve, tuple[float, float] | None]]:
        """Return the curves that are judged by the range the constants were fitted over, and that range."""

    @abstractmethod
    def curves_csv(self) -> bytes:
        """Return every reading with what the law says beside it."""

    @abstractmethod
    def picture(self) -> bytes:
        """Return the PNG of the fit."""

    def alike(self, curves: Sequence[TestCurve]) -> Sequence[TestCurve]:
        """Return the curves of which those of one kind are replicates."""
        return curves

    def along(self) -> dict[str, Direction]:
        """Return the law as seen along each direction by its name, where it has any."""
        return {}

    def document(self, readings: Readings) -> MaterialDocument:
        """Return the material document."""
        return document_of(
            readings,
            self.setting,
            model=self.law.name,
            parameters=dict(self.law.parameters),
            temperature_degC=self.temperatures[self.reference],
            directions=self.along() or None,
            temperatures=self.constants(lambda law: dict(law.parameters), self.certainty),
            fit=self.figures,
            stability=self.stability,
            stable=self.stable,
            accepted=self.accepted,
            replicates=replicates(self.alike(self.curves)) or None,
            undetermined=self.undetermined or None,
            tested=tested(self.curves, self.setting),
            warnings=readings.warnings or None,
        )

    @property
    def law(self) -> EnergyT:
        """The law at the reference temperature."""
        return self.laws[self.reference]

    def law_at(self, temperature: float | None) -> EnergyT:
        """Return the law of the nearest temperature that was fitted."""
        return self.laws[nearest(self.temperatures, temperature, self.reference)]

    def constants(
        self, seen: Callable[[EnergyT], Parameters], certainty: Callable[[int], Certainty]
    ) -> list[AtTemperature] | None:
        """Return the constants at each temperature of the tests, where there are several, and how sure they are."""
        if len([t for t in self.temperatures if t is not None]) < 2:
            return None
        return [
            AtTemperature(temperature_degC=t, parameters=seen(law), fit=self._at(number, certainty(number)))
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
        sure: Certainty,
        replicated: Sequence[TestCurve],
        through: tuple[float, ...] = (),
    ) -> FitFigures:
        """Return the figures over those of ``curves`` that are fitted, and of each group of them; how ``sure`` the
        constants are, and where one more specimen is to be expected beside those ``replicated``.

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
        return self._told(FitFigures(**vars(total), tests=tests), sure, self.reference, replicated)

    def sure_of(self, optimum: Weighed, names: Sequence[str], tests: Sequence[TestCurve]) -> Certainty:
        """Return how sure the constants ``names`` of an ``optimum`` are, by how specimens of the ``tests`` scatter."""
        specimens, kinds = [specimen_of(one) for one in tests], [kind_of(one) for one in tests]
        return sure_of(optimum, names, np.eye(len(names)), specimens, kinds)

    def fitted_at(self, number: int) -> list[TestCurve]:
        """Return the curves that were fitted at one of the temperatures."""
        return [c for c in self.setting.used(self.curves) if c.is_at(self.temperatures[number])]

    def _at(self, number: int, sure: Certainty) -> FitFigures | None:
        """Return the figures at one of the temperatures, and how sure its constants are; None without a stress."""
        total = self.error(self.fitted_at(number))
        return None if total is None else self._told(FitFigures(**vars(total)), sure, number)

    def _told(
        self, found: FitFigures, sure: Certainty, number: int, replicated: Sequence[TestCurve] = ()
    ) -> FitFigures:
        with_certainty(found, sure, len({specimen_of(curve) for curve in self.fitted_at(number)}))
        if found.uncertainty is not None:
            found.uncertainty.next_specimen = next_specimens(self.alike(replicated)) or None
        return found

    def refuse_unstable(self, instead: str) -> None:
        """InputError where a stable law was asked for and this one is not; ``instead`` is a way out."""
        if self.setting.stable and not self.stable:
            raise InputError(
                f"no constants of {self.law.name} could be shown to be stable over the data",
                file=self.curves[0].source,
                remedy=f"leave --stable out, or {instead}",
            )
