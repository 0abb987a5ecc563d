"""What ``hf fit`` expects of tests it has not seen, against what is true there, where one mode alone was fitted.

    python -m trials.unseen [DRAWS]

Rubbers by formulas that are none of the program's laws, with constants drawn at random (DRAWS of each, 2), and the
measured ones of ``HYPERFAB_DATA``. Each is fitted with ``--model all`` on one mode; the law that is chosen is then
asked for the other two, up to the same I1. The table says the error it stated (``carry_over``), the real one, that of
the best law there is, and the ratio of the first two.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from hyperfab.chapters.fit.identify import Identified, Setting
from hyperfab.chapters.fit.judge import Judged, judge
from hyperfab.curve import TestCurve
from hyperfab.io.csv_tests import read_tests
from hyperfab.materials import laws
from hyperfab.materials.identification.transfer import stretch_at
from hyperfab.materials.modes import MODES, nominal_stress, second_stretch
from trials.hunting import Array

Energy = Callable[[Array, Array, Array], Array]
#: Errors of a reading, relative and as a share of the largest.
NOISE, FLOOR = 0.01, 0.001


def langevin_energy(r: Array) -> Array:
    """Return a chain's energy over its stretch's part r of the full one, Cohen's approximation integrated."""
    return r**2 / 2 - np.log(1 - r**2)


def van_der_waals(draw: np.random.Generator) -> Energy:
    """Kilian's gas of chains, which takes I1 and I2 together."""
    mu, limit, pull, mix = 0.4, draw.uniform(5, 11), draw.uniform(0.1, 0.35), draw.uniform(0.75, 1.0)

    def energy(a: Array, b: Array, c: Array) -> Array:
        I1, I2 = a**2 + b**2 + c**2, a**2 * b**2 + b**2 * c**2 + a**2 * c**2
        x = mix * I1 + (1 - mix) * I2
        eta = np.sqrt((x - 3) / (limit**2 - 3))
        return mu * (-(limit**2 - 3) * (np.log(1 - eta) + eta) - 2 / 3 * pull * ((x - 3) / 2) ** 1.5)

    return energy


def three_chains(draw: np.random.Generator) -> Energy:
    """James and Guth's three chains along the axes, and a tube that falls with the stretch (Heinrich's)."""
    mu, limit, tube, beta = 0.25, draw.uniform(5.5, 12), draw.uniform(0.05, 0.25), draw.uniform(0.2, 1.0)

    def energy(a: Array, b: Array, c: Array) -> Array:
        total = sum(mu * limit**2 / 3 * langevin_energy(one / limit) for one in (a, b, c))
        return np.asarray(total + 2 * tube / beta**2 * (a**-beta + b**-beta + c**-beta))

    return energy


def sphere(draw: np.random.Generator) -> Energy:
    """Chains in all directions whose stretches are averaged by a power (Miehe, Goektepe and Lulei), and tubes."""
    mu, limit, power = 0.28, draw.uniform(5.0, 9.0), draw.uniform(1.2, 3.0)
    tube, q = draw.uniform(0.05, 0.25), draw.uniform(0.1, 0.6)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    turn = (np.arange(12) + 0.5) * np.pi / 24
    z = 0.5 * (nodes + 1.0)
    ring = np.sqrt(1 - z**2)[:, None]
    ways = np.stack([ring * np.cos(turn), ring * np.sin(turn), z[:, None] + 0 * turn], axis=-1).reshape(-1, 3)
    share = np.repeat(weights / 2 / 12, 12)

    def energy(a: Array, b: Array, c: Array) -> Array:
        axes = np.stack([a, b, c], axis=-1)[..., None, :]
        length = np.sqrt((axes**2 * ways**2).sum(axis=-1))
        area = np.sqrt((axes**-2.0 * ways**2).sum(axis=-1))
        mean = (length**power @ share) ** (1 / power)
        return np.asarray(mu * limit**2 * langevin_energy(mean / limit) + 3 * tube / q * (area**q @ share))

    return energy


def nonaffine(draw: np.random.Generator) -> Energy:
    """Davidson and Goulbourne's network."""
    Gc, Ge, limit = draw.uniform(0.15, 0.3), draw.uniform(0.03, 0.3), draw.uniform(3.0, 6.0)

    def energy(a: Array, b: Array, c: Array) -> Array:
        I1 = a**2 + b**2 + c**2
        chains = Gc * I1 / 6 - Gc * limit**2 * np.log(3 * limit**2 - I1)
        return np.asarray(chains + Ge * sum(one + 1 / one for one in (a, b, c)))

    return energy


def slip_links(draw: np.random.Generator) -> Energy:
    """Edwards and Vilgis: cross-links, and links that slide along the chains."""
    Nc, Ns, eta, short = (
        draw.uniform(0.1, 0.3),
        draw.uniform(0.05, 0.3),
        draw.uniform(0.1, 0.5),
        draw.uniform(0.08, 0.13),
    )

    def energy(a: Array, b: Array, c: Array) -> Array:
        squares = [a**2, b**2, c**2]
        I1, left = sum(squares), 1 - short**2 * sum(squares)
        links = Nc / 2 * ((1 - short**2) * I1 / left + np.log(left))
        slides = sum((1 + eta) * (1 - short**2) * s / ((1 + eta * s) * left) + np.log(1 + eta * s) for s in squares)
        return np.asarray(links + Ns / 2 * (slides + np.log(left)))

    return energy


def biderman(draw: np.random.Generator) -> Energy:
    """Powers of I1 and a Mooney term, which no rubber keeps to high stretch: up to moderate ones."""
    C10, C01, C20, C30 = (
        0.2,
        draw.uniform(0.002, 0.02),
        -draw.uniform(0.0005, 0.002),
        draw.uniform(2e-5, 6e-5),
    )

    def energy(a: Array, b: Array, c: Array) -> Array:
        x, I2 = a**2 + b**2 + c**2 - 3, a**2 * b**2 + b**2 * c**2 + a**2 * c**2
        return np.asarray(C10 * x + C01 * I2 + C20 * x**2 + C30 * x**3)

    return energy


def attard(draw: np.random.Generator) -> Energy:
    """Attard and Hunt: even powers of the stretches and of their inverses."""
    A1, A2, B1 = 0.2, draw.uniform(1e-4, 6e-4), draw.uniform(0.002, 0.03)

    def energy(a: Array, b: Array, c: Array) -> Array:
        return np.asarray(sum(A1 * s**2 + A2 * s**4 + B1 * s**-2 for s in (a, b, c)))

    return energy


def yeoh_fleming(draw: np.random.Generator) -> Energy:
    """Yeoh and Fleming's limit, with Gent and Thomas's logarithm of I2."""
    A, B, C, limit, C2 = 0.12, draw.uniform(2, 8), 0.22, draw.uniform(40, 100), draw.uniform(0.0, 0.15)

    def energy(a: Array, b: Array, c: Array) -> Array:
        x, I2 = a**2 + b**2 + c**2 - 3, a**2 * b**2 + b**2 * c**2 + a**2 * c**2
        return np.asarray(-A / B * limit * np.exp(-B * x / limit) - C * limit * np.log(1 - x / limit) + C2 * np.log(I2))

    return energy


RUBBERS: Mapping[str, Callable[[np.random.Generator], Energy]] = {
    "van der Waals": van_der_waals, "three chains": three_chains, "sphere": sphere, "non-affine": nonaffine,
    "slip-links": slip_links, "Biderman": biderman, "Attard": attard, "Yeoh-Fleming": yeoh_fleming,
}  # fmt: skip


def stress(energy: Energy, mode: str, lam: Array) -> Array:
    """Return the nominal stress: the energy's derivative along the loading direction, by a complex step."""
    across = second_stretch(mode, lam)
    one = lam + 1e-30j
    return np.asarray(energy(one, across + 0j, 1.0 / (one * across)).imag / 1e-30)


def synthetic(name: str, seed: int) -> dict[str, TestCurve]:
    """Return the three tests of one rubber, to the same I1, with noise."""
    draw = np.random.default_rng([seed, len(name), ord(name[0])])
    energy, reach = RUBBERS[name](draw), draw.uniform(4.0, 17.0)
    found = {}
    for mode in MODES:
        lam = stretch_at(mode, reach * np.linspace(0.05, 1.0, 16) ** 1.5)
        exact = stress(energy, mode, lam)
        noise = draw.standard_normal((2, len(lam)))
        read = exact * (1.0 + NOISE * noise[0]) + FLOOR * exact.max() * noise[1]
        found[mode] = TestCurve(mode=mode, source=mode, stretch=lam, stress=read)
    return found


def measured(folder: Path) -> dict[str, TestCurve]:
    """Return the measured tests of a rubber."""
    found = {}
    for mode in MODES:
        path = folder / f"{mode}.csv"
        [test] = read_tests(path.read_bytes(), path.name)
        moving = test.stretch > 1.0
        found[mode] = TestCurve(mode=mode, source=mode, stretch=test.stretch[moving], stress=test.stress[moving])
    return found


def trial(tests: Mapping[str, TestCurve], mode: str) -> tuple[Judged, float, float]:
    """Return the law chosen on one mode, its real error in the others, and that of the best law there is."""
    setting = Setting((mode,), relative=True, stable=False, accept=0.3)
    candidates = [law for law in laws().values() if law.isotropic]
    ranking = sorted(
        (judge(law, {None: [tests[mode]]}, setting) for law in candidates),
        key=lambda one: one.best_first,
    )
    errors = [real(one, tests, mode) for one in ranking]
    usable = [error for one, error in zip(ranking, errors, strict=True) if one.accepted and one.stable]
    return ranking[0], errors[0], min(usable)


def real(one: Judged, tests: Mapping[str, TestCurve], fitted: str) -> float:
    """Return the relative rms of a law in the modes that it has not seen, up to the I1 that it has."""
    found = one.results[None]
    if not isinstance(found, Identified):
        return float("inf")
    error, reach = [], found.fit.problem.rows.extent.x
    for mode, test in tests.items():
        if mode != fitted:
            near = test.stretch <= 1.001 * stretch_at(mode, np.array([reach]))[0]
            error.append(1.0 - nominal_stress(found.material, mode, test.stretch[near]) / test.stress[near])
    with np.errstate(over="ignore"):
        return float(np.sqrt(np.mean(np.concatenate(error) ** 2)))


def main() -> None:
    """Print the table."""
    draws = int(sys.argv[1]) if len(sys.argv) > 1 else 2
    sets = {f"{name} {k + 1}": synthetic(name, k) for name in RUBBERS for k in range(draws)}
    folder = Path(os.environ.get("HYPERFAB_DATA", "data"))
    sets |= {name: measured(folder / name) for name in ("treloar-1944", "kawabata-1981") if (folder / name).is_dir()}
    rows = []
    print(f"{'rubber':18s} {'fitted on':9s} {'law':22s} {'stated':>7s} {'real':>7s} {'ratio':>6s} {'best':>7s}")
    for name, tests in sets.items():
        for mode in MODES:
            chosen, error, best = trial(tests, mode)
            rows.append((chosen.carry_over, error, best))
            shown = f"{chosen.carry_over:7.3f} {error:7.3f} {chosen.carry_over / error:6.2f} {best:7.3f}"
            print(f"{name:18s} {mode:9s} {chosen.law.name:22s} {shown}", flush=True)
    stated, error, best = np.array(rows).T
    ratio = stated / error
    low, middle, high = np.quantile(ratio, [0.25, 0.5, 0.75])
    print(f"{len(rows)} trials, stated over real: median {middle:.2f}, quartiles {low:.2f} and {high:.2f}")
    print(
        f"stated below the real one in {np.mean(ratio < 1):.0%} of them, below half of it in {np.mean(ratio < 0.5):.0%}"
    )
    print(
        f"real error: median {np.median(error):.3f}, largest {error.max():.2f}; of the best law {np.median(best):.3f}"
    )


if __name__ == "__main__":
    main()
