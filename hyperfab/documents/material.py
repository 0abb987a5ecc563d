"""The material document: a strain-energy law, its constants, and how far they can be trusted."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from hyperfab.documents.base import Document, Part, optional
from hyperfab.documents.certainty import FitUncertainty, Replicates
from hyperfab.errors import UsageError

#: Constants are numbers: a number in quotes is a mistake of another program, not to be read over.
Parameters = dict[str, Annotated[float, Field(strict=True)]]


class TestFigures(Part):
    """How well the constants carry one test."""

    __test__ = False  # no test class for pytest

    E2: float = Field(description="sum of (1 - model/measured)^2 over the rows whose stress is not zero")
    relative_rms: float = Field(description="root of the mean of (1 - model/measured)^2")
    nrmse: float = Field(description="root-mean-square error of the stress over the largest measured stress")
    points: int = Field(description="rows")
    stretch_min: float | None = optional("smallest stretch of the test, or 1")
    stretch_max: float | None = optional("largest stretch of the test, or 1")
    predicted: bool | None = optional("true where the test took no part in the fit")


class OutlierReading(Part):
    """A reading that does not belong to the others."""

    source: str
    line: int | None = None
    test: str
    stretch: float
    stress_MPa: float
    studentised: float = Field(description="residual over its standard deviation with the reading left out")
    leverage: float = Field(description="share of the reading in its own prediction")


class FitFigures(Part):
    """How well the constants carry the tests, and how sure they are. The totals are over the rows fitted."""

    E2: float
    relative_rms: float
    nrmse: float
    points: int
    parameters_sd: Parameters | None = optional(
        "standard deviation of each constant, in its unit: by how specimens scatter where there are "
        "replicates, else of the readings alone (as it is stated of them, or by what the law misses)"
    )
    uncertainty: FitUncertainty | None = None
    condition_number: float | None = optional(
        "of the Jacobian with columns of length one: 1 where constants are independent"
    )
    correlation: list[list[float]] | None = optional("of the constants, in the order of parameters")
    outliers: list[OutlierReading] | None = optional("readings far from where all others say they should be")
    tests: dict[str, TestFigures | Unpredicted] = Field(
        default_factory=dict, description="the same figures for each test"
    )


class Unpredicted(Part):
    """A test that the constants cannot speak of: its stretches lie beyond the law's limit."""

    points: int
    predicted: bool | None = None
    status: str


class StableRange(Part):
    """The stretches of a mode over which the constants are Drucker-stable."""

    stretch_min: float
    stretch_max: float
    ended_by: Literal["instability", "limit", "scan"] = Field(
        description="what ends the range above: instability, the limiting stretch of the law, or the scan"
    )
    first_unstable_stretch: float | None = None
    stable_over_data: bool | None = optional("whether the range covers the stretches of the test; absent without one")


class StablePlane(Part):
    """Drucker stability over all pairs of in-plane stretches between two bounds."""

    stretch_min: float
    stretch_max: float
    stable_fraction: float = Field(description="share of the pairs, within the law's limit, that are stable")
    first_unstable_stretches: list[float] | None = optional("the unstable pair nearest to rest")


class Tested(Part):
    """How far the tests of one mode went."""

    stretch: tuple[float, float] = Field(description="smallest and largest stretch, rest among them")
    temperature_degC: tuple[float, float] | None = optional(
        "lowest and highest temperature; absent where the tests state none"
    )


class AtTemperature(Part):
    """The constants at one temperature."""

    temperature_degC: float
    parameters: Parameters
    fit: FitFigures | None = None


class Direction(Part):
    """The constants of one direction of the fabric."""

    parameters: Parameters
    fit: FitFigures | None = None
    stability: dict[str, StableRange] | None = None
    stability_plane: StablePlane | None = None
    stable: bool | None = None
    temperatures: list[AtTemperature] | None = None
    tested: dict[str, Tested] | None = optional("by test: the range of the data behind the constants")


class Undetermined(Part):
    """A constant that no test at hand speaks of."""

    constant: str
    value: float = Field(description="what it is taken as: where it has no effect, or the usual")
    test: str = Field(description="the test that would tell it")


class ModelRow(Part):
    """One law in the table of all: a row without constants says in ``status`` why there are none."""

    model: str
    E2: float | None = None
    relative_rms: float | None = None
    parameters: Parameters | None = None
    fit: FitFigures | None = None
    stability: dict[str, StableRange] | None = None
    carry_over: float | None = optional(
        "relative rms expected for tests the constants have not seen, up to the I1 tested; ranks the table"
    )
    stable: bool | None = None
    accepted: bool | None = None
    status: str | None = None


#: What is true of the sheet and its tests whatever the constants are; every other key speaks of the constants at hand.
_OF_THE_SHEET = frozenset(
    ("model", "parameters", "thickness_mm", "thickness_nominal", "temperature_degC", "directions", "temperatures",
     "bulk_modulus_MPa", "effects", "tested")
)  # fmt: skip
_OF_A_DIRECTION = frozenset(("parameters", "temperatures", "tested"))
_OF_A_ROW = frozenset(("temperature_degC", "parameters"))


class MaterialDocument(Document):
    """What ``hf fit`` writes and every later command takes; a short one can be written by hand.

    ``model`` and ``parameters`` are enough for a forward command.
    """

    KIND: ClassVar[str] = "material"

    model: str = Field(description="name of the strain-energy law")
    parameters: Parameters = Field(
        description="constants of the law in its usual notation, names ending in their unit; "
        "of both directions together where directions are given"
    )
    thickness_mm: float | None = Field(default=None, gt=0.0, description="undeformed thickness")
    thickness_nominal: bool | None = optional(
        "true where no thickness is known: 1 mm is taken, and constants in MPa are N/mm of width"
    )
    temperature_degC: float | None = optional("temperature at which parameters hold, where the tests state theirs")
    directions: dict[str, Direction] | None = optional(
        "warp and weft, each with its own constants, where tests were cut both ways"
    )
    temperatures: list[AtTemperature] | None = optional("constants against temperature, to be interpolated linearly")
    fit: FitFigures | None = None
    stability: dict[str, StableRange] | None = None
    stability_plane: StablePlane | None = None
    stable: bool | None = optional("Drucker-stable over the stretches of the tests")
    accepted: bool | None = optional("whether the fit is within --accept")
    carry_over: float | None = optional(
        "relative rms expected for tests the constants have not seen, up to the I1 tested"
    )
    accepted_by: str | None = optional(
        "the figure that --accept bounds: relative_rms (orthotropic: a stress below a tenth of the peak "
        "counts as that); nrmse in an absolute fit and of a foam, which minimise it"
    )
    objective: str | None = optional("relative or absolute least squares")
    fit_on: list[str] | None = optional("tests that took part in the fit")
    left_out: dict[str, int] | None = optional("rows left out, by reason")
    preparation: list[str] | None = optional("what was done to the data before the fit")
    replicates: list[Replicates] | None = optional("scatter between specimens")
    bulk_modulus_MPa: float | None = Field(default=None, gt=0.0, description="from the volumetric test")
    warnings: list[str] | None = None
    models: list[ModelRow] | None = optional("all laws, best first (--model all)")
    undetermined: list[Undetermined] | None = optional("constants that the tests leave open (orthotropic)")
    effects: list[dict[str, Any]] | None = optional(
        "physical terms beyond the law, as hf close-loop adds them; tentative: beside it something is left"
    )
    joint_uncertainty: FitUncertainty | None = optional(
        "how sure the constants of an extended model are, those of its effects too, all together; by their "
        "places in the document"
    )
    tested: dict[str, Tested] | None = optional("by test: the range of the data behind the constants")

    def tested_stretch(self, direction: str | None = None, test: str | None = None) -> tuple[float, float] | None:
        """Return the smallest and the largest stretch of the tests behind the constants; None where nothing says.

        Of one ``test`` where there are such, else of all; of a ``direction`` where it has constants of its own.

        >>> tests = {"uniaxial": {"stretch": [1.0, 1.8]}, "biaxial": {"stretch": [1.0, 1.4]}}
        >>> fabric = MaterialDocument(model="neo-hookean", parameters={"C10_MPa": 0.2}, tested=tests)
        >>> fabric.tested_stretch(), fabric.tested_stretch(test="biaxial")
        ((1.0, 1.8), (1.0, 1.4))
        """
        own = (self.directions or {}).get(direction or "")
        part: MaterialDocument | Direction = own or self
        known = {name: one.stretch for name, one in (part.tested or {}).items()}
        if not known and part.fit is not None:  # documents of before ``tested``
            for name, one in part.fit.tests.items():
                if isinstance(one, TestFigures) and not one.predicted and one.stretch_max is not None:
                    known[name] = (one.stretch_min or 1.0, one.stretch_max)
        ranges = [one for name, one in known.items() if name == test] or list(known.values())
        return (min(low for low, _ in ranges), max(high for _, high in ranges)) if ranges else None

    def tested_degC(self, direction: str | None = None) -> tuple[float, float] | None:
        """Return the lowest and the highest temperature [degC] of the tests behind the constants, of a ``direction``
        where it has constants of its own; None where nothing says."""
        part: MaterialDocument | Direction = (self.directions or {}).get(direction or "") or self
        known = [one.temperature_degC for one in (part.tested or {}).values() if one.temperature_degC is not None]
        return (min(low for low, _ in known), max(high for _, high in known)) if known else None

    def refitted(self) -> MaterialDocument:
        """Return a copy for other constants: without what was said of those it has, the fit's figures above all.

        >>> fabric = MaterialDocument(model="neo-hookean", parameters={"C10_MPa": 0.2}, accepted=True, thickness_mm=0.6)
        >>> other = fabric.refitted()
        >>> other.accepted is None, other.thickness_mm
        (True, 0.6)
        """
        result = self.model_copy(deep=True)
        parts: list[tuple[Any, frozenset[str]]] = [(result, _OF_THE_SHEET)]
        for direction in (result.directions or {}).values():
            parts += [
                (direction, _OF_A_DIRECTION),
                *((row, _OF_A_ROW) for row in direction.temperatures or []),
            ]
        parts += [(row, _OF_A_ROW) for row in result.temperatures or []]
        for part, kept in parts:
            for name, field in type(part).model_fields.items():
                if name not in kept:
                    setattr(part, name, field.get_default(call_default_factory=True))
        for effect in result.effects or []:
            effect.pop("parameters_sd", None)
        result.format = result.format_name()
        return result

    def every_constant(self) -> Iterator[tuple[str, Parameters]]:
        """Yield the place of each set of constants in the document, and the set itself."""
        parts: list[tuple[str, MaterialDocument | Direction]] = [("", self)]
        parts += [(f"directions.{way}.", one) for way, one in (self.directions or {}).items()]
        for place, part in parts:
            yield f"{place}parameters", part.parameters
            for index, row in enumerate(part.temperatures or ()):
                yield f"{place}temperatures.{index}.parameters", row.parameters

    def constants(self, direction: str | None = None, temperature_degC: float | None = None) -> Parameters:
        """Return the constants to compute with.

        ``direction`` is ``warp`` or ``weft``; where the document has no directions, or without one, those of the
        whole fabric. ``temperature_degC`` interpolates linearly between the temperatures of the tests and keeps
        the nearest beyond them; where the document has none, or without one, those of its own temperature.

        >>> cold = {"temperature_degC": 20.0, "parameters": {"C10_MPa": 0.2}}
        >>> hot = {"temperature_degC": 80.0, "parameters": {"C10_MPa": 0.1}}
        >>> fabric = MaterialDocument(model="neo-hookean", parameters={"C10_MPa": 0.2}, temperatures=[cold, hot])
        >>> round(fabric.constants(temperature_degC=50.0)["C10_MPa"], 12)
        0.15
        """
        if self.directions is None or direction is None:
            own, table = self.parameters, self.temperatures
        elif direction in self.directions:
            own, table = self.directions[direction].parameters, self.directions[direction].temperatures
        else:
            raise UsageError(f"the material has no direction {direction}; it has {', '.join(self.directions)}")
        if temperature_degC is None or not table:
            return dict(own)
        return interpolated(table, temperature_degC)


def interpolated(table: list[AtTemperature], temperature_degC: float) -> Parameters:
    """Return the constants at a temperature, such that stresses go linearly between the two nearest; beyond: the ends'.

    >>> rows = [(20.0, 0.4, 0.8), (80.0, 0.2, 0.2)]
    >>> table = [AtTemperature(temperature_degC=t, parameters={"mu_MPa": mu, "f": f, "nu": 0.4}) for t, mu, f in rows]
    >>> found = interpolated(table, 50.0)  # mu f is 0.32 and 0.04 MPa
    >>> round(found["mu_MPa"], 12), round(found["mu_MPa"] * found["f"], 12)
    (0.3, 0.18)
    """
    table = sorted(table, key=lambda row: row.temperature_degC)
    if temperature_degC <= table[0].temperature_degC:
        return dict(table[0].parameters)
    for low, high in pairwise(table):
        if temperature_degC <= high.temperature_degC:
            span = high.temperature_degC - low.temperature_degC
            share = (temperature_degC - low.temperature_degC) / span
            found = {name: value + share * (high.parameters[name] - value) for name, value in low.parameters.items()}
            if "f" in found:  # the share of mu that the first of two brackets has: of that goes mu f linearly
                first, last = (row.parameters["mu_MPa"] * row.parameters["f"] for row in (low, high))
                found["f"] = (first + share * (last - first)) / found["mu_MPa"]
            return found
    return dict(table[-1].parameters)


FitFigures.model_rebuild()
