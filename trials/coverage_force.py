"""Do 95 % intervals of the sphere's force cover? Synthetic labs, their fits, and the force each of them foretells.

    python -m trials.coverage_force [LABS [LAW]]

For each law, number of specimens and scatter, LABS labs (100) are drawn as in ``trials.coverage``; each fits its own
constants with their covariance, which direct sensitivities carry into the force of a sphere pushed into a sheet. The
table says how often, in per cent, the interval holds the force of the true constants. Then, for one lab, the linear
answer beside the forces of 300 sets of constants drawn from its covariance.
"""

from __future__ import annotations

import sys
from itertools import product

import numpy as np

from hyperfab.chapters.fit.identify import Identified, Setting, identify
from hyperfab.materials import bind
from hyperfab.materials.registry import law
from hyperfab.membrane.outline import Disc
from hyperfab.membrane.sensitivity import Neighbourhood
from hyperfab.membrane.sphere_contact import Solved, SphereTest, run
from hyperfab.membrane.tension_field import IsotropicSheet
from hyperfab.numerics.propagation import Source, directions, draws, linear, sampled
from trials.coverage import TRUTHS, lab

DEPTH, TESTS = 60.0, ("uniaxial", "shear")


def sphere(name: str, constants: dict[str, float]) -> SphereTest:
    """Return the test of a sheet with these constants."""
    return SphereTest(
        Disc(100.0, quarter=True), IsotropicSheet(bind(name, constants)), 0.6, 40.0, mesh_size=18.0
    )


def force(solved: Solved) -> dict[str, float]:
    """Return the force [N]."""
    return {"force_N": solved.state.force}


class Lab:
    """A lab's fit, and the force at its constants with what it changes by with each."""

    def __init__(self, name: str, found: Identified, truth: Solved) -> None:
        scatter = found.certainty.scatter
        assert scatter is not None
        self.name, self.constants = name, found.material.parameters
        self.source = Source("constants", scatter.covariance, scatter.freedom)
        start = Neighbourhood(truth).equilibrium(self.test(), DEPTH, np.zeros_like(truth.state.places))
        self.near, self.force, slopes, self.moves = Neighbourhood(start), start.state.force, [], []
        for place, sd in enumerate(np.sqrt(np.diag(scatter.covariance))):

            def test(change: float, place: int = place) -> tuple[SphereTest, float]:
                return self.test(change * np.eye(len(self.constants))[place]), DEPTH

            self.moves.append(self.near.move(test, 0.02 * sd))
            slopes.append(self.near.slopes(test, 0.02 * sd, self.moves[-1], force)["force_N"])
        self.effects = np.array([slopes @ column for _, column in directions([self.source])])
        self.band = linear(self.force, self.effects, [self.source])

    def test(self, changes: np.ndarray | None = None) -> SphereTest:
        """Return the test with the lab's constants, changed."""
        more = np.zeros(len(self.constants)) if changes is None else changes
        own = self.constants.items()
        return sphere(self.name, {key: value + float(d) for (key, value), d in zip(own, more, strict=True)})

    def again(self, changes: np.ndarray) -> float:
        """Return the force of an equilibrium with changed constants."""
        moved = sum(d * move for d, move in zip(changes, self.moves, strict=True))
        return self.near.equilibrium(self.test(changes), DEPTH, np.asarray(moved)).state.force


def fitted(name: str, specimens: int, scatter: float, draw: np.random.Generator) -> Identified:
    """Return what a lab fits."""
    setting = Setting(TESTS, relative=True, stable=False, accept=1.0)
    found = identify(law(name), lab(name, TESTS, specimens, scatter, draw), setting)
    assert isinstance(found, Identified)
    return found


def main() -> None:
    """Print the table."""
    labs = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    names = sys.argv[2:] or list(TRUTHS)
    print(f"{'law':16} {'specimens':9} {'scatter':8} covered  mean sd  rms error (both % of the force)")
    last: Lab | None = None
    for name, specimens, scatter in product(names, (3, 5), (0.015,)):
        truth = run([sphere(name, TRUTHS[name])], [0.5 * DEPTH, DEPTH], 1e-2)[0].solved[-1]
        draw = np.random.default_rng([labs, specimens, round(1e4 * scatter), len(name)])
        held, sds, errors = [], [], []
        for _ in range(labs):
            last = Lab(name, fitted(name, specimens, scatter, draw), truth)
            held.append(last.band.low <= truth.state.force <= last.band.high)
            sds.append(last.band.sd / truth.state.force)
            errors.append(last.force / truth.state.force - 1.0)
        rms = float(np.sqrt(np.mean(np.square(errors))))
        print(
            f"{name:16} {specimens:9} {100 * scatter:7.1f}% {100 * np.mean(held):7.1f}  {100 * np.mean(sds):6.2f} "
            f"{100 * rms:9.2f}",
            flush=True,
        )
    assert last is not None
    drawn = draws([last.source], 300)
    columns = np.array([column for _, column in directions([last.source])])
    outcomes = np.array([last.again(z @ columns) for z in drawn])
    full = sampled(last.force, outcomes, drawn, [last.source])
    print(f"linear:   {last.force:.4f} N, sd {last.band.sd:.4f}, {last.band.low:.4f} to {last.band.high:.4f}")
    print(f"300 runs: mean {outcomes.mean():.4f} N, sd {full.sd:.4f}, {full.low:.4f} to {full.high:.4f}")


if __name__ == "__main__":
    main()
