"""The neighbours of an equilibrium of the sphere test, for how sure its figures are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from hyperfab.arrays import Array
from hyperfab.cases.contact import ContactCase
from hyperfab.chapters.fabric_contact.fields import sure_fields
from hyperfab.chapters.fabric_contact.result import row
from hyperfab.chapters.fabric_contact.setup import Geometry, setup_of
from hyperfab.chapters.job import Job
from hyperfab.chapters.sheet import read_fabric
from hyperfab.chapters.uncertainty.carry import Answer, Changes, Figures, Nearby, Slopes
from hyperfab.chapters.uncertainty.of_fabric import origins_of_fabric
from hyperfab.chapters.uncertainty.sources import Origins
from hyperfab.documents.uncertainty import FIGURES
from hyperfab.errors import NotConverged
from hyperfab.membrane.equilibrium import NoEquilibriumError
from hyperfab.membrane.sensitivity import Neighbourhood
from hyperfab.membrane.sphere_contact import Outcome, Solved, SphereTest

#: Options that leave the mesh as it is.
_ON_THE_MESH = {
    "thickness_mm", "depth_mm", "sphere_radius_mm", "prestretch", "rim_slip_mm2_N", "temperature_degC"
}  # fmt: skip
#: Steps of differences, over a standard deviation.
_STEP = 0.02


def origins_of(job: Job, case: ContactCase) -> Origins:
    """Return what the inputs of a contact say of how sure they are."""
    found = origins_of_fabric(job.inputs, case, case.material, case.temperature)
    if case.against is not None and found.found:
        found.left_out.append("the comparison with --against")
    return found


class Beside(Nearby):
    """What the figures become beside an equilibrium without friction, on its mesh."""

    samples = 400
    #: On one mesh the edge of contact jumps as nodes come to touch, by more than it moves.
    undrawn: ClassVar[Mapping[str, str]] = {
        "contact_radius_mm": "is not drawn: on one mesh it jumps as nodes come to touch; --uncertainty linear"
    }

    def __init__(self, job: Job, case: ContactCase, geometry: Geometry, solved: Solved, origins: Origins) -> None:
        self._job, self._case, self._geometry, self._origins = job, case, geometry, origins
        self._near = Neighbourhood(solved)
        self._moves: list[Array] = []

    def gradient(self) -> Slopes:
        slopes: list[Answer] = []
        self._moves = []
        for sd, index, unit in self._origins.each():

            def test(by: float, index: int = index, unit: Array = unit) -> tuple[SphereTest, float]:
                return self._test({index: by * unit})

            moved, found = self._near.slopes(
                test, _STEP * sd, lambda solved: {**_figures(solved), **sure_fields(solved)}
            )
            self._moves.append(moved)
            figures = {name: float(found.pop(name)) for name in FIGURES["contact"]}
            slopes.append(Answer(figures, {name: np.asarray(slope) for name, slope in found.items()}))
        return Slopes.of(slopes)

    def at(self, changes: Changes) -> Answer:
        """Return the figures of the equilibrium with numbers changed; NotConverged where there is none."""
        if not self._moves:
            self.gradient()
        amounts = self._origins.amounts(changes)
        moved = sum(amount * move for amount, move in zip(amounts, self._moves, strict=True))
        test, depth = self._test(changes)
        try:
            solved = self._near.equilibrium(test, depth, np.asarray(moved))
        except NoEquilibriumError as error:
            raise NotConverged(str(error)) from None
        found = {name: value for name, value in _figures(solved).items() if name not in self.undrawn}
        return Answer(found, sure_fields(solved))

    def _test(self, changes: Changes) -> tuple[SphereTest, float]:
        moved = self._origins.changed(self._case, self._job.inputs, changes)
        fabric = read_fabric(moved.job, moved.case.material, moved.case.temperature, moved.case.thickness)
        setup = setup_of(moved.case, self._geometry, fabric)
        return setup.test(fabric), setup.depths[-1]


def beside(job: Job, case: ContactCase, geometry: Geometry, outcome: Outcome, origins: Origins) -> Beside | None:
    """Return the neighbours of a test's last equilibrium; None where they hang on the way, or have another mesh, or
    where the machine yields, so that the punch is not as deep."""
    solved = outcome.solved[-1]
    if solved.press.tangential.remembers or solved.press.frame or not origins.settings <= _ON_THE_MESH:
        return None
    return Beside(job, case, geometry, solved, origins)


def _figures(solved: Solved) -> Figures:
    found = row(solved)
    return {name: found[name] for name in FIGURES["contact"]}
