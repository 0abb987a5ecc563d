"""Do 95 % intervals of a force cover? Synthetic labs, their fits, and the force that each of them foretells.

    python -m trials.coverage_force [LABS [PRESS ...]]

PRESS is ``sphere`` (into a sheet held at its rim), ``net`` and ``membrane`` (the sheet of a drape, pushed by a ball).
For each law, tests, specimens and scatter, LABS labs (400) are drawn as in ``trials.coverage``; each fits its own
constants with their covariance, which sensitivities carry into the force at those constants. The table says how
often, in per cent, the interval holds the force of the true constants, an equilibrium of its own. Forces of the labs'
constants come from a polynomial through equilibria all over the range of the labs, and equilibria of some labs say how
well it holds. Then, for one lab a law, the linear answer beside 2,000 equilibria with constants drawn from its
covariance (JCGM 101, 8): how many standard deviations the ends of both intervals are apart.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
import trimesh

from hyperfab.arrays import Array
from hyperfab.chapters.fit.identify import Identified, Setting, identify
from hyperfab.cloth import Mold, Sheet, answers, drape, mold_of, raised
from hyperfab.cloth.law import spring_law
from hyperfab.cloth.sensitivity import Neighbourhood as Draped
from hyperfab.materials import bind
from hyperfab.materials.registry import law
from hyperfab.membrane.outline import Disc
from hyperfab.membrane.sensitivity import Neighbourhood
from hyperfab.membrane.sphere_contact import Solved, SphereTest, run
from hyperfab.membrane.tension_field import IsotropicSheet
from hyperfab.numerics.propagation import Band, Source, directions, draws, linear, sampled
from hyperfab.surface import Surface
from trials.coverage import TESTS, TRUTHS, lab

DEPTH, THICKNESS = 60.0, 0.6
SPECIMENS, SCATTERS = (3, 5, 8), (0.005, 0.015, 0.05)
RUNS = 2000
#: Of the polynomials, along each ratio of constants.
DEGREE = 6
#: Steps of differences, over the constant.
STEP = 2e-4


class Sphere:
    """A sphere of radius 40 mm pushed 60 mm into a disc of 200 mm."""

    def __init__(self, name: str) -> None:
        self._name = name
        values = np.array(list(TRUTHS[name].values()))
        self._near = Neighbourhood(run([self._test(values)], [0.5 * DEPTH, DEPTH], 1e-2)[0].solved[-1])
        self._still = np.zeros_like(self._near.solved.state.places)
        self.truth = self._near.solved.state.force

    def _test(self, values: Array) -> SphereTest:
        constants = dict(zip(TRUTHS[self._name], map(float, values), strict=True))
        sheet = IsotropicSheet(bind(self._name, constants))
        return SphereTest(Disc(100.0, quarter=True), sheet, THICKNESS, 40.0, mesh_size=25.0)

    def force(self, values: Array) -> float:
        """Return the force of an equilibrium found anew."""
        return self._near.equilibrium(self._test(values), DEPTH, self._still).state.force

    def slopes(self, values: Array) -> tuple[float, Array]:
        """Return the force, and what it changes by with each constant."""
        near = Neighbourhood(self._near.equilibrium(self._test(values), DEPTH, self._still))
        found = []
        for unit, size in zip(np.eye(len(values)), np.abs(values), strict=True):

            def test(change: float, unit: Array = unit) -> tuple[SphereTest, float]:
                return self._test(values + change * unit), DEPTH

            found.append(near.slopes(test, STEP * size, _force)[1]["force_N"])
        return near.solved.state.force, np.array(found)


def _force(solved: Solved) -> dict[str, float]:
    return {"force_N": solved.state.force}


class Ball:
    """A ball of radius 60 mm pushed 60 mm into a sheet of 220 mm, of 17 by 17 nodes: a net, or a ``membrane``."""

    def __init__(self, name: str, membrane: bool) -> None:
        self._name, self._membrane = name, membrane
        self.truth = self.force(np.array(list(TRUTHS[name].values())))

    @cached_property
    def _mold(self) -> Mold:
        mesh = trimesh.creation.icosphere(subdivisions=4, radius=60.0)
        return raised(mold_of(Surface(mesh.vertices, mesh.faces), (0.0, 0.0, -60.0)), DEPTH)

    def _sheet(self, values: Array) -> Sheet:
        material = bind(self._name, dict(zip(TRUTHS[self._name], map(float, values), strict=True)))
        threads = spring_law(material)
        whole = IsotropicSheet(material) if self._membrane else None
        return Sheet(17, 17, (220.0, 220.0), THICKNESS, threads, threads, membrane=whole)

    def force(self, values: Array) -> float:
        """Return the force of an equilibrium found anew."""
        sheet = self._sheet(values)
        found = drape(sheet, self._mold, 1e-7)
        assert found.converged, found.status
        return answers(sheet, self._mold, found).press_force

    def slopes(self, values: Array) -> tuple[float, Array]:
        """Return the force, and what it changes by with each constant."""
        sheet = self._sheet(values)
        found = drape(sheet, self._mold, 1e-7)
        assert found.converged, found.status
        there = answers(sheet, self._mold, found)
        near = Draped(sheet, self._mold, found, there.cut)
        slopes = []
        for unit, size in zip(np.eye(len(values)), STEP * np.abs(values), strict=True):
            up, down = self._sheet(values + size * unit), self._sheet(values - size * unit)
            _, more, less = near.slopes(up, down, size)
            slopes.append((more.press_force - less.press_force) / (2.0 * size))
        return there.press_force, np.array(slopes)


Press = Sphere | Ball


def press_of(kind: str, name: str) -> Press:
    """Return the press of a kind, with the law called ``name``."""
    return Sphere(name) if kind == "sphere" else Ball(name, kind == "membrane")


def fitted(name: str, tests: Sequence[str], specimens: int, scatter: float, draw: np.random.Generator) -> Identified:
    """Return what a lab fits."""
    setting = Setting(tuple(tests), relative=True, stable=False, accept=1.0)
    found = identify(law(name), lab(name, tuple(tests), specimens, scatter, draw), setting)
    assert isinstance(found, Identified)
    return found


class Near:
    """The force at the constants of labs, from a polynomial through equilibria over their range.

    The law's first constant is a stress that all others but the last of ``gent`` are taken as multiples of: places hang
    on the multiples alone, and the force goes with the first constant.
    """

    def __init__(self, press: Press, name: str, every: Array) -> None:
        self._stresses = np.array([key.endswith("_MPa") for key in TRUTHS[name]][1:])
        ratios = self._ratios(every)
        low, high = ratios.min(axis=0), ratios.max(axis=0)
        self._middle, self._half = 0.5 * (low + high), 0.5 * (high - low)
        self._degrees = [DEGREE] * ratios.shape[1]
        nodes = np.cos(np.pi * (np.arange(DEGREE + 3) + 0.5) / (DEGREE + 3))
        grid = np.array(list(product(nodes, repeat=ratios.shape[1])))
        values = []
        for at in grid:
            ratio = self._middle + self._half * at
            first = every[0, 0]
            constants = np.append(first, np.where(self._stresses, first * ratio, ratio))
            values.append(press.force(constants) / first)
        self._weights = np.linalg.lstsq(self._basis(grid), np.array(values), rcond=None)[0]

    def _ratios(self, constants: Array) -> Array:
        return np.where(self._stresses, constants[:, 1:] / constants[:, :1], constants[:, 1:])

    def _basis(self, at: Array) -> Array:
        columns = [np.polynomial.chebyshev.chebvander(one, DEGREE) for one in at.T]
        found = columns[0]
        for more in columns[1:]:
            found = (found[:, :, None] * more[:, None, :]).reshape(len(at), -1)
        return np.asarray(found)

    def force(self, constants: Array) -> Array:
        """Return the forces (n,) at constants (n, k)."""
        at = (self._ratios(constants) - self._middle) / self._half
        return np.asarray(constants[:, 0] * (self._basis(at) @ self._weights))

    def slopes(self, values: Array) -> Array:
        """Return what the force changes by with each constant."""
        steps = np.diag(STEP * np.abs(values))
        sides = self.force(np.concatenate([values + steps, values - steps]))
        return (sides[: len(values)] - sides[len(values) :]) / (2.0 * np.diag(steps))


@dataclass(frozen=True)
class Labs:
    """What the labs of one row of the table fitted: constants (n, k), and the source of each."""

    name: str
    tests: int
    specimens: int
    scatter: float
    values: Array
    sources: list[Source]


def labs_of(name: str, tests: tuple[str, ...], specimens: int, scatter: float, labs: int) -> Labs:
    """Return what labs fit."""
    draw = np.random.default_rng([labs, specimens, round(1e4 * scatter), len(tests), len(name)])
    values, sources = [], []
    for _ in range(labs):
        found = fitted(name, tests, specimens, scatter, draw)
        known = found.certainty.scatter
        assert known is not None
        values.append(list(found.material.parameters.values()))
        sources.append(Source("constants", known.covariance, known.freedom, known.parts))
    return Labs(name, len(tests), specimens, scatter, np.array(values), sources)


def band_of(force: float, slopes: Array, source: Source) -> Band:
    """Return the interval of a force."""
    return linear(force, np.array([slopes @ column for _, column in directions([source])]), [source])


def main() -> None:
    """Print the tables."""
    labs = int(sys.argv[1]) if len(sys.argv) > 1 else 400
    kinds = sys.argv[2:] or ["sphere", "net", "membrane"]
    shares: dict[str, list[float]] = {kind: [] for kind in kinds}
    print("press    law              tests specimens scatter covered %  sd %  rms error %", flush=True)
    for name in TRUTHS:
        presses = {kind: press_of(kind, name) for kind in kinds}
        for tests in TESTS:
            every = [labs_of(name, tests, count, scatter, labs) for count in SPECIMENS for scatter in SCATTERS]
            together = np.concatenate([one.values for one in every])
            for kind, press in presses.items():
                near = Near(press, name, together)
                some = together[:: max(len(together) // 20, 1)]
                found = np.array([press.force(values) for values in some])
                off = np.abs(near.force(some) / found - 1.0).max()
                shares[kind] += [covered(kind, one, press.truth, near) for one in every]
                print(f"  the polynomial is within {100 * off:.4f} % of {len(some)} equilibria", flush=True)
        for kind, press in presses.items():
            _beside_runs(kind, press, every[-1])
    for kind, found in shares.items():
        print(f"{kind}: mean {np.mean(found):.2f} %, least {min(found):.2f}, most {max(found):.2f}, {labs} labs a row")


def covered(kind: str, labs: Labs, truth: float, near: Near) -> float:
    """Print and return how often the intervals of one row cover, in per cent."""
    forces = near.force(labs.values)
    bands = [
        band_of(float(force), near.slopes(values), source)
        for force, values, source in zip(forces, labs.values, labs.sources, strict=True)
    ]
    share = 100.0 * float(np.mean([band.low <= truth <= band.high for band in bands]))
    rms = 100.0 * float(np.sqrt(np.mean((forces / truth - 1.0) ** 2)))
    print(
        f"{kind:8} {labs.name:16} {labs.tests:5} {labs.specimens:9} {100 * labs.scatter:6.1f}% {share:9.2f} "
        f"{100 * np.median([band.sd for band in bands]) / truth:5.2f} {rms:12.2f}",
        flush=True,
    )
    return share


def _beside_runs(kind: str, press: Press, labs: Labs) -> None:
    source, values = labs.sources[0], labs.values[0]
    force, slopes = press.slopes(values)
    band = band_of(force, slopes, source)
    drawn = draws([source], RUNS)
    columns = np.array([column for _, column in directions([source])])
    outcomes = np.array([press.force(values + z @ columns) for z in drawn])
    full = sampled(force, outcomes, drawn, [source])
    ends = max(abs(band.low - full.low), abs(band.high - full.high)) / full.sd
    print(f"  {kind}: linear sd {band.sd:.4g}, {RUNS} runs {full.sd:.4g}: ends {ends:.3f} sd apart", flush=True)


if __name__ == "__main__":
    main()
