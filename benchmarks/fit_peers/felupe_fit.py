"""FElupe's own fit, run by benchmarks/fit.py: reads the curves on standard input, prints E2 and seconds a law."""

from __future__ import annotations

import contextlib
import json
import sys
import time
import warnings
from collections.abc import Iterator

import felupe as fem
import numpy as np

warnings.simplefilter("ignore")
LAWS = {
    "neo-hookean": (fem.neo_hooke, {"mu": 0.3}),
    "mooney-rivlin-2": (fem.mooney_rivlin, {"C10": 0.1, "C01": 0.1}),
    "yeoh-3": (fem.yeoh, {"C10": 0.1, "C20": 0.0, "C30": 0.0}),
    "ogden-1": (fem.ogden, {"mu": [0.3], "alpha": [2.0]}),
    "ogden-2": (fem.ogden, {"mu": [0.3, 0.1], "alpha": [2.0, -2.0]}),
    "ogden-3": (fem.ogden, {"mu": [0.3, 0.1, 0.1], "alpha": [2.0, -2.0, 4.0]}),
    "arruda-boyce": (fem.arruda_boyce, {"C1": 0.3, "limit": 5.0}),
    "blatz-ko": (fem.blatz_ko, {"mu": 0.3}),
    "alexander": (fem.alexander, {"C1": 0.1, "C2": 0.1, "C3": 0.1, "gamma": 1.0, "k": 1e-3}),
    "extended-tube": (fem.extended_tube, {"Gc": 0.2, "Ge": 0.2, "beta": 0.5, "delta": 0.05}),
}


@contextlib.contextmanager
def told(name: str, case: str) -> Iterator[None]:
    """A fit that fails is told and costs its cell."""
    try:
        yield
    except Exception as error:  # noqa: BLE001 - whatever a peer raises
        print(f"felupe, {name} {case}: {type(error).__name__}: {error}", file=sys.stderr)


def main() -> None:
    """Fit every law to case A and case B."""
    curves = {mode: np.array(table) for mode, table in json.load(sys.stdin).items()}
    found: dict[str, dict[str, tuple[float, float]]] = {}
    for name, (law, constants) in LAWS.items():
        for case in "AB":
            given = {"ux": curves["uniaxial"]}
            if case == "B":
                given |= {"ps": curves["shear"], "bx": curves["biaxial"]}
            start = time.process_time()
            with told(name, case), contextlib.redirect_stdout(sys.stderr):
                _, result = fem.Hyperelastic(law, **constants).optimize(
                    **given, incompressible=name != "blatz-ko", relative=True
                )
                seconds = time.process_time() - start
                found.setdefault(name, {})[case] = (float(np.sum(np.square(result.fun))), seconds)
    print(json.dumps(found))


main()
