"""The compression laws of a sandwich: of its foam at a temperature, and of its fabrics across."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hyperfab.chapters.fabric import FabricDocument
from hyperfab.chapters.job import Job
from hyperfab.documents.base import read_document
from hyperfab.documents.foam import (
    FoamDocument,
    HyperfoamLaw,
    Law,
    LinearLaw,
    MaterialLaw,
    PlateauLaw,
    TableLaw,
)
from hyperfab.documents.material import MaterialDocument
from hyperfab.errors import InputError, placed
from hyperfab.io.csv_table import read_table
from hyperfab.io.inputs import Inputs
from hyperfab.materials.hyperfoam import ORDERS, Hyperfoam
from hyperfab.numerics.monotone import never_falling
from hyperfab.pressing import foam_law
from hyperfab.pressing.foam_law import FoamLaw, Tempered
from hyperfab.pressing.series import together

#: Strain and stress of a foam test that go back by less than this share of their largest value only jitter.
_JITTER = 0.02
#: Poisson's ratio of stretched foam where nothing tells it: flexible polyurethane has 0.3 to 0.4 in tension,
#: 0.5 to 0 in compression (R. D. Widdle, A. K. Bajaj, P. Davies, Int. J. Eng. Sci. 46 (2008) 31).
USUAL_POISSON = 0.3


@dataclass(frozen=True)
class Fabrics:
    """The fabrics ``below`` (on the male) and ``above`` the foam [mm], and how both together give way across, None
    where they are rigid."""

    below: float
    above: float
    law: FoamLaw | None

    @property
    def thickness(self) -> float:
        """Of both [mm]."""
        return self.above + self.below


def compression_law(
    job: Job, name: str, document: FoamDocument, temperature: float, dwell: float | None
) -> tuple[Tempered, float]:
    """Return the law by temperature at the end of the dwell, and the share of stress relaxed by then.

    ``temperature`` [degC] is that of the molds: a material document's law is asked for there.
    """
    left = 1.0
    dwell = dwell or document.relaxation.dwell or document.shrinkage.dwell
    if dwell is not None:
        left = foam_law.relaxed(document.relaxation.share, document.relaxation.time, dwell)
    laws = document.laws
    if len(laws) == 1 and laws[0].temperature is None:
        found = _by_temperature(job, name, laws[0], temperature)
    else:
        rows = [0.0 if law.temperature is None else law.temperature for law in laws]
        found = Tempered(
            tuple(rows), tuple(_by_temperature(job, name, law, temperature).at(temperature) for law in laws)
        )
    return Tempered(found.temperatures, tuple(law.scaled(left) for law in found.laws)), 1.0 - left


def materials(inputs: Inputs, name: str, document: FoamDocument, temperature: float) -> dict[str, float]:
    """Return the material documents whose laws a sandwich takes, by name the temperature [degC] it takes them at."""
    given = document.fabric
    found = {}
    for law in (*document.laws, given.compression):
        if isinstance(law, MaterialLaw):
            own = temperature if law.temperature is None else law.temperature
            found[Inputs.beside(name, law.material)] = own
    layers = () if given.compression is not None else (given.above, given.below)
    for path in dict.fromkeys(Inputs.beside(name, layer) for layer in layers if isinstance(layer, str)):
        if read_document(inputs, path, MaterialDocument).model in ORDERS:
            found[path] = temperature
    return found


def note_temperature(job: Job, name: str, document: FoamDocument, celsius: np.ndarray | float) -> None:
    """Note the temperatures [degC] at which the laws of ``foam.toml`` are read, beside those they were measured at."""
    known = [law.temperature for law in document.laws if law.temperature is not None]
    if known:
        then = "the law of the nearest is taken"
        job.ranges.used("compression", celsius, known=known, source=name, unit="degC", then=then)
    elif isinstance(document.laws[0], MaterialLaw):
        path = Inputs.beside(name, document.laws[0].material)
        _note_tests(job, path, read_document(job.inputs, path, MaterialDocument), celsius)


def thinning(law: FoamLaw, document: FoamDocument, name: str, fabric: np.ndarray) -> tuple[np.ndarray, str]:
    """Return how much thinner the foam is (n,) where a drape thins the fabric by ``fabric`` (n,), and by which rule.

    The fabric is incompressible: its area is stretched by as much as it has become thinner, and the foam's with it.
    """
    given = document.poisson.foam
    ratio = USUAL_POISSON if given is None and law.free is None else given
    with placed(name, "compression", "give poisson = 0.3, the foam's Poisson's ratio"):
        found = law.thinning(1.0 / fabric, ratio)
    if ratio is None:
        return found, "plane stress of the foam's law"
    return (
        found,
        f"Poisson's ratio {ratio:g}, {'as is usual: none is given' if given is None else 'as given'}",
    )


def _by_temperature(job: Job, name: str, given: Law, temperature: float) -> Tempered:
    """Return a law by temperature: of a material document those of its tests, of any other the one it is."""
    if isinstance(given, MaterialLaw):
        own = temperature if given.temperature is None else given.temperature
        found = _fitted_law(job, Inputs.beside(name, given.material), own)
        if given.temperature is not None:
            found = Tempered((own,), (found.at(own),))
    else:
        found = Tempered((temperature,), (_plain_law(job, name, given),))
    return Tempered(found.temperatures, tuple(law.scaled(given.factor) for law in found.laws))


def _plain_law(job: Job, name: str, given: Law) -> FoamLaw:
    if isinstance(given, LinearLaw):
        return foam_law.linear(given.modulus)
    if isinstance(given, PlateauLaw):
        return foam_law.plateau(given.plateau, given.modulus, given.densification, given.power)
    if isinstance(given, HyperfoamLaw):
        return foam_law.hyperfoam(given.mu, given.alpha, given.nu)
    assert isinstance(given, TableLaw)
    return _table_law(job, Inputs.beside(name, given.table))


def _fitted_law(job: Job, path: str, temperature: float) -> Tempered:
    """Return the laws of a material document by the temperatures of its tests; ``temperature`` [degC] is asked for.

    Not the constants are read between tests but the stresses: the terms of two fits need not stand in one order.
    """
    document = read_document(job.inputs, path, MaterialDocument)
    foams = FabricDocument(document, path).foams()
    beside = [str(one.get("id", "?")) for one in document.effects or [] if not one.get("told_by")]
    if beside:
        job.console.warn(f"{path}: its elastic law alone is taken, without the effects {', '.join(beside)}")
    _note_tests(job, path, document, temperature)
    rows = tuple(temperature if known is None else known for known, _ in foams)
    return Tempered(rows, tuple(_held(path, law) for _, law in foams))


def _note_tests(job: Job, path: str, document: MaterialDocument, celsius: np.ndarray | float) -> None:
    """Note the temperatures [degC] at which a material document is read, beside those of its tests."""
    known = [row.temperature_degC for row in document.temperatures or []]
    if not known and document.temperature_degC is not None:
        known = [document.temperature_degC]
    then = "the constants of the nearest test are taken" if known else "its tests state no temperature"
    job.ranges.used("temperature_degC", celsius, known=known or None, source=path, then=then)


def _held(path: str, law: Hyperfoam) -> FoamLaw:
    """Return the law between plates; InputError where its stress falls."""
    found = foam_law.hyperfoam(law.mu, law.alpha, law.nu)
    strain = np.linspace(0.0, found.limit, 400)
    falling = np.flatnonzero(np.diff(found.raw_stress(strain)) < 0.0)
    if len(falling):
        raise InputError(
            f"its stress between plates falls from a strain of {strain[falling[0]]:.2g} on",
            file=path,
            key="parameters",
            remedy="fit with fewer terms, or give a confined compression test too",
        )
    return found


def fabrics(job: Job, name: str, document: FoamDocument, temperature: float) -> Fabrics:
    """Return both fabric layers; a material document gives its own thickness, and a foam's how it gives way across."""
    given = document.fabric
    pressed = given.compression
    across = None if pressed is None else _by_temperature(job, name, pressed, temperature).at(temperature)
    thickness: dict[str, float] = {}
    layers: list[tuple[float, FoamLaw | None]] = []
    for side, layer in (("above", given.above), ("below", given.below)):
        law = across
        if isinstance(layer, str):
            path = Inputs.beside(name, layer)
            material = read_document(job.inputs, path, MaterialDocument)
            if material.thickness_mm is None or material.thickness_nominal:
                raise InputError(
                    f"the material document {layer} states no thickness",
                    file=name,
                    key=f"fabric.{side}",
                    remedy='write the thickness itself, as "0.5 mm"',
                )
            thickness[side] = material.thickness_mm
            if law is None and material.model in ORDERS:
                law = _fitted_law(job, path, temperature).at(temperature)
        else:
            thickness[side] = layer
        layers.append((thickness[side], law))
    return Fabrics(thickness["below"], thickness["above"], together(layers))


def _without_jitter(stress: np.ndarray) -> np.ndarray:
    """Return the never falling stress (n,) nearest to one that falls by no more than jitter; another one as it is."""
    if (np.maximum.accumulate(stress) - stress).max() > _JITTER * stress.max():
        return stress
    return never_falling(stress)


def _table_law(job: Job, path: str) -> FoamLaw:
    table = read_table(job.inputs.read(path), path, {"strain": "dimensionless", "stress": "stress"})
    strain, stress = table["strain"], table["stress"]
    # A test as the machine wrote it: the way down to the largest strain is the law, rows that only jitter are left out.
    down = slice(0, int(np.argmax(strain)) + 1)
    highest = np.maximum.accumulate(strain[down])
    back = highest - strain[down]
    if (back > _JITTER * highest[-1]).any():
        row = int(np.argmax(back > _JITTER * highest[-1]))
        raise InputError(
            f"the strain goes back from {highest[row]:g} to {strain[row]:g} before its largest value, {highest[-1]:g}",
            file=path,
            line=int(table.lines[row]),
            column="strain",
            remedy="keep one loading of one specimen, in the order in which it was measured",
        )
    rising = np.flatnonzero(np.diff(highest, prepend=-np.inf) > 0.0)
    # Before the plates touch the foam, strain and stress jitter about zero.
    rising = rising[strain[rising] >= (0.0 if strain[0] < 0.0 and strain[0] > -_JITTER * highest[-1] else -np.inf)]
    lines = table.lines[rising]
    strain, stress = strain[rising], _without_jitter(stress[rising])
    stress = np.where((stress < 0.0) & (stress > -_JITTER * stress.max()), 0.0, stress)
    if len(rising) < len(table["strain"]):
        job.console.note(
            f"{path}: {len(rising)} rows of the loading are the law; {len(table['strain']) - down.stop} of the way "
            f"back and {down.stop - len(rising)} in which the strain does not rise are left out"
        )

    def refuse(row: int, message: str, remedy: str, column: str = "strain") -> None:
        raise InputError(message, file=path, line=int(lines[row]), column=column, remedy=remedy)

    if len(strain) < 2:
        refuse(0, "one row is no curve", "give at least two rows")
    if strain[0] < 0.0:
        refuse(0, "compression strain is negative", "give compression as positive strain and stress")
    if strain[-1] >= 1.0:
        refuse(len(strain) - 1, "foam cannot be compressed by 100 % or more", "give strain as a fraction below 1")
    if stress[0] < 0.0:
        refuse(0, "compression stress is negative", "give compression as positive strain and stress", "stress")
    falling = np.flatnonzero(np.diff(stress) < 0.0)
    if len(falling):
        message = f"stress falls from {stress[falling[0]]:g} to {stress[falling[0] + 1]:g} MPa"
        refuse(int(falling[0]) + 1, message, "smooth the curve so that stress never falls", "stress")
    if stress[-1] <= 0.0:
        refuse(len(strain) - 1, "the foam bears nothing", "check the column and its unit", "stress")
    return foam_law.table(strain, stress)
