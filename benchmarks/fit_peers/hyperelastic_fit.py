"""The fit of the package hyperelastic, run by benchmarks/fit.py: curves on standard input, E2 and seconds out."""

from __future__ import annotations

import contextlib
import json
import sys
import time
import warnings
from collections.abc import Iterator

import hyperelastic as h
import numpy as np
from hyperelastic import lab
from hyperelastic.lab._curve_fit import concatenate_curve_fit

warnings.simplefilter("ignore")
POLYNOMIALS = {
    "neo-hookean": ["C10"],
    "yeoh-1": ["C10"],
    "yeoh-2": ["C10", "C20"],
    "yeoh-3": ["C10", "C20", "C30"],
    "mooney-rivlin-2": ["C10", "C01"],
    "mooney-rivlin-3": ["C10", "C01", "C11"],
}
CASES = {"uniaxial": lab.Uniaxial, "shear": lab.Planar, "biaxial": lab.Biaxial}


def polynomial(**constants: float) -> object:
    """The package's polynomial of third order."""
    law = h.models.invariants.ThirdOrderDeformation(**constants)
    return h.DeformationSpace(h.InvariantsFramework(law))


def ogden(**constants: float) -> object:
    """The package's Ogden law."""
    order = len(constants) // 2
    mu = [constants[f"mu{r}"] for r in range(order)]
    alpha = [constants[f"alpha{r}"] for r in range(order)]
    return h.DeformationSpace(h.StretchesFramework(h.models.stretches.Ogden(mu=mu, alpha=alpha)))


@contextlib.contextmanager
def told(name: str, case: str) -> Iterator[None]:
    """A fit that fails is told and costs its cell."""
    try:
        yield
    except Exception as error:  # noqa: BLE001 - whatever a peer raises
        print(f"hyperelastic, {name} {case}: {type(error).__name__}: {error}", file=sys.stderr)


def main() -> None:
    """Fit every law to case A and case B."""
    curves = {mode: np.array(table) for mode, table in json.load(sys.stdin).items()}
    found: dict[str, dict[str, tuple[float, float]]] = {}
    tasks = {name: (polynomial, labels, np.full(len(labels), 0.1)) for name, labels in POLYNOMIALS.items()}
    for order in (1, 2, 3):
        labels = [f"{kind}{r}" for r in range(order) for kind in ("mu", "alpha")]
        tasks[f"ogden-{order}"] = (ogden, labels, np.array([0.3, 2.0, 0.1, -2.0, 0.1, 4.0][: 2 * order]))
    for name, (material, labels, start_values) in tasks.items():
        for case, modes in (("A", ["uniaxial"]), ("B", list(curves))):
            start = time.process_time()
            with told(name, case):
                value = fit(material, labels, start_values, {mode: curves[mode] for mode in modes})
                found.setdefault(name, {})[case] = (value, time.process_time() - start)
    print(json.dumps(found))


def fit(material: object, labels: list[str], start: np.ndarray, curves: dict[str, np.ndarray]) -> float:
    """Return E2 of the package's least squares, weighed by the readings as E2 is."""
    experiments = [lab.Experiment(label=m, displacement=t[0] - 1, force=t[1]) for m, t in curves.items()]
    simulations = [
        lab.Simulation(loadcase=CASES[mode](), stretch=table[0], material=material, labels=labels, parameters=start)
        for mode, table in curves.items()
    ]
    task = lab.Optimize(experiments=experiments, simulations=simulations, parameters=start)
    task.init_curve_fit()
    stress = np.concatenate([table[1] for table in curves.values()])
    best, _ = concatenate_curve_fit(task.f, task.x, task.y, start, sigma=np.abs(stress), maxfev=20000)
    model = np.concatenate([f(x, *best) for f, x in zip(task.f, task.x, strict=True)])
    return float(np.sum((1.0 - model / stress) ** 2))


main()
