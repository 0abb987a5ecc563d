"""The fabric of ``hf drape``: spring laws along warp and weft from a material document."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hyperfab.arrays import Array
from hyperfab.cases.drape import DrapeCase
from hyperfab.chapters.drape.curves import read_curve
from hyperfab.chapters.fabric import per_width, read_fabric_document
from hyperfab.chapters.job import Job
from hyperfab.chapters.sheet import Fabric as SheetFabric
from hyperfab.chapters.sheet import judged, sheet_of, warn_of_effects
from hyperfab.cloth import SpringLaw
from hyperfab.cloth.law import Pulled, spring_law
from hyperfab.documents.drape import SpringUse
from hyperfab.errors import InputError, UsageError, placed
from hyperfab.materials.orthotropic.specimen import Along

#: What a law straight from a test is called.
MEASURED = "measured"
#: Thickness in mm where nothing states one.
USUAL_THICKNESS = 1.0


@dataclass(frozen=True)
class Way:
    """The springs along one direction: their ``law``, what it is, the file it is from, the stretch to which the tests
    behind it went, and that at which a specimen failed."""

    model: str
    law: SpringLaw
    source: str
    tested: float | None
    fails: float | None = None


@dataclass(frozen=True)
class Fabric:
    """The springs along warp and weft, and the sheet's thickness in mm.

    ``temperature`` [degC] is the laws', where known, ``held_at`` that of the constants where they were not tested
    there. ``whole`` is the law of the sheet as a membrane, where that is asked for; ``left_out`` says which effects of
    the document the springs do not obey, and why.
    """

    ways: tuple[Way, Way]
    thickness: float
    temperature: float | None = None
    held_at: float | None = None
    whole: SheetFabric | None = None
    left_out: tuple[str, ...] = ()

    @property
    def warp(self) -> SpringLaw:
        """The law along the warp."""
        return self.ways[0].law

    @property
    def weft(self) -> SpringLaw:
        """The law along the weft."""
        return self.ways[1].law

    def with_laws(self, warp: SpringLaw, weft: SpringLaw) -> Fabric:
        """Return the fabric with other laws."""
        one, two = self.ways
        return replace(self, ways=(replace(one, law=warp), replace(two, law=weft)))


def read_fabric(job: Job, case: DrapeCase) -> Fabric:
    """Read a material document, or the tests ``warp`` and ``weft`` in its place or in place of one direction.

    The thickness that was asked for goes before what the files state; the temperature is for the document's laws.
    """
    if case.temperature is not None and (case.warp is not None or case.weft is not None):
        raise UsageError(
            f"--temperature {case.temperature:g}degC: a test with --warp or --weft has its own temperature; fit "
            "the tests of several temperatures with hf fit"
        )
    name, given = case.material, case.thickness
    tests = [
        None if file is None else (file, read_curve(job, option, file, angle, given))
        for option, file, angle in (("--warp", case.warp, 0.0), ("--weft", case.weft, 90.0))
    ]
    if name is None:
        for option, other, test in zip(("--weft", "--warp"), ("--warp", "--weft"), tests, strict=True):
            if test is None:
                job.console.note(f"no {other}: the curve of {option} is taken for both directions")
        tests = [test or next(one for one in tests if one is not None) for test in tests]
    known = {file: curve.thickness for file, curve in filter(None, tests) if curve.thickness is not None}
    if given is None and known and max(known.values()) > 1.02 * min(known.values()):
        thickest = max(known, key=lambda file: known[file])
        raise InputError(
            f"is {known[thickest]:g} mm thick, the other test {min(known.values()):g} mm",
            file=thickest,
            key="thickness",
            remedy="give --thickness",
        )
    stated = given or (float(np.mean(list(known.values()))) if known else None)
    fabric = None if name is None else _of_document(job, name, case, stated)
    thick = given or (fabric and fabric.thickness) or stated
    if thick is None:
        thick = USUAL_THICKNESS
        told = name or case.warp or case.weft
        job.console.note(f"{told} states no thickness: 1 mm is taken (--thickness sets it)")
    ways: list[Way] = []
    for k, test in enumerate(tests):
        if test is None:
            assert fabric is not None  # a document stands for what has no test
            ways.append(fabric.ways[k])
            continue
        file, curve = test
        if curve.per_width and thick != USUAL_THICKNESS:
            raise InputError(
                f"is force per width, and the sheet is {thick:g} mm thick",
                file=file,
                key="thickness",
                remedy="give --thickness",
            )
        ways.append(Way(MEASURED, curve.law, file, curve.tested, curve.fails_at))
    return replace(fabric or Fabric((ways[0], ways[1]), thick), ways=(ways[0], ways[1]), thickness=thick)


def _of_document(job: Job, name: str, case: DrapeCase, thickness: float | None) -> Fabric:
    """The fabric of a material document; thickness 0 where it states none. ``thickness`` [mm]: known from elsewhere."""
    read = read_fabric_document(job, name, case.temperature, thickness)
    read.used_at(job)
    document = read.document
    if document.thickness_nominal:
        job.console.note(per_width(name))
    warn_of_effects(job, read, "the springs do" if case.sheet == "net" else "the sheet does")
    whole, ways = read.sheet(), []
    for direction, angle in (("warp", 0.0), ("weft", 90.0)):
        own = direction in (document.directions or {})
        key = f"directions.{direction}.parameters" if own else "parameters"
        law: Pulled = Along(whole, angle) if whole is not None else read.material(direction if own else None)
        known = document.tested_stretch(direction, "uniaxial")
        with placed(name, key, "fit the fabric again with --stable"):
            spring = spring_law(law)
        ways.append(Way(document.model, spring, name, None if known is None else known[1]))
    return Fabric(
        (ways[0], ways[1]),
        document.thickness_mm or 0.0,
        read.temperature,
        read.held_at,
        sheet_of(read) if case.sheet == "membrane" else None,
        tuple(judged(document, case.temperature)[1]),
    )


def use_of(fabric: Fabric, stretch_warp: Array, stretch_weft: Array) -> tuple[SpringUse, SpringUse]:
    """How far each law was used, and whether it was tested and rising there.

    A membrane is not judged by the curves of its springs, but by the margin of its own law.
    """
    uses, springs = [], fabric.whole is None
    for way, stretch in zip(fabric.ways, (stretch_warp, stretch_weft), strict=True):
        law, tested, largest = way.law, way.tested, float(stretch.max())
        softens = springs and law.softens is not None and largest > law.softens
        # A law of constants ends where its chains lock; a measured one is extrapolated.
        locks = springs and way.model != MEASURED and law.softens is None and largest > law.largest_stretch
        uses.append(
            SpringUse(
                model=way.model,
                stretch_max=largest,
                tested_stretch_max=tested,
                beyond_tested=None if tested is None else int(np.count_nonzero(stretch > tested * (1.0 + 1e-9))),
                softens_at=law.softens if softens else None,
                ends_at=law.largest_stretch if locks else None,
                fails_at=way.fails if way.fails is not None and largest > way.fails else None,
            )
        )
    return uses[0], uses[1]


def note_ranges(job: Job, fabric: Fabric, stretch_warp: Array, stretch_weft: Array) -> None:
    """Note where the law of each direction was used; springs below 1 are slack, and ask it nothing."""
    for name, way, stretch in zip(("warp", "weft"), fabric.ways, (stretch_warp, stretch_weft), strict=True):
        known = None if way.tested is None else (1.0, way.tested)
        met = np.maximum(stretch, 1.0)
        stress = None if way.tested is None else _stresses(way.law, float(met.max()), way.tested)
        job.ranges.used(
            "stretch", met, known=known, source=way.source, direction=name, then="extrapolated", stress=stress
        )


def _stresses(law: SpringLaw, most: float, tested: float) -> tuple[float, float]:
    stress = law([most, tested])[1]
    return float(stress[0]), float(stress[1])
