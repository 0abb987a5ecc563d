"""Constants of Treloar's rubber by three programs: the same table of E2 and seconds, in one run.

    python benchmarks/fit.py [--data FOLDER] [--peers PYTHON]

E2 = sum((1 - P_model/P_measured)^2). Case A is fitted to the uniaxial test, case B to all three. FElupe and
hyperelastic (GPL, installed apart: pip install felupe hyperelastic tensortrax) run in the interpreter PYTHON, from
start values as their examples take them and with the relative objective. A dash: the program has no such law, or its
fit failed (the reason is on standard error). Times are CPU seconds after import.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from hyperfab.curve import TestCurve
from hyperfab.materials import laws
from hyperfab.materials.identification import Problem, Rows, fit_law
from hyperfab.materials.modes import MODES

HERE = Path(__file__).parent
#: The fourteen laws of the report, then those added to them.
REPORT = (
    "neo-hookean", "mooney-rivlin-2", "mooney-rivlin-3", "mooney-rivlin-5", "mooney-rivlin-9", "ogden-1", "ogden-2",
    "ogden-3", "yeoh-1", "yeoh-2", "yeoh-3", "arruda-boyce", "gent", "blatz-ko",
)  # fmt: skip
MORE = (
    "arruda-boyce-langevin", "gent-gent", "yeoh-3-lni2", "arruda-boyce-lni2", "carroll", "alexander", "extended-tube",
)  # fmt: skip


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", default=str(HERE.parent / "specimens" / "treloar-1944"))
    parser.add_argument("--peers", default=sys.executable, help="interpreter that has felupe and hyperelastic")
    options = parser.parse_args()
    curves = read(Path(options.data))
    found = {"hyperfab": ours(curves)}
    for peer in ("felupe", "hyperelastic"):
        rows = run_peer(peer, options.peers, curves)
        if rows:
            found[peer] = rows
    print(f"{sum(len(lam) for lam, _ in curves.values())} points of {options.data}")
    head = f"{'':24}" + "".join(f"{peer + ' ' + case:>18}{'s':>8}" for case in "AB" for peer in found)
    print(head)
    worse = []
    for name in (*REPORT, *MORE):
        line = f"{name:24}"
        for case in "AB":
            best = found["hyperfab"][name][case][0]
            for peer, rows in found.items():
                value, seconds = rows.get(name, {}).get(case, (None, None))
                line += f"{'-':>18}{'':8}" if value is None else f"{value:18.6g}{seconds:8.4f}"
                if value is not None and value < best * (1.0 - 1e-6):
                    worse.append(f"{name} {case}: {peer} {value:.6g} against {best:.6g}")
        print(line)
    total = sum(found["hyperfab"][name][case][1] for name in REPORT for case in "AB")
    print(f"hyperfab, {len(REPORT)} laws x 2 cases: {total:.3f} s")
    print("; ".join(worse) if worse else "no program has a lower E2 anywhere")


def read(folder: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return stretch and nominal stress of each test."""
    found = {}
    for mode in MODES:
        rows = [line.split(",") for line in (folder / f"{mode}.csv").read_text().splitlines() if line[:1].isdigit()]
        table = np.array(rows, dtype=float)
        found[mode] = (table[:, 0], table[:, 1])
    return found


def ours(curves: dict[str, tuple[np.ndarray, np.ndarray]]) -> dict[str, dict[str, tuple[float, float]]]:
    """Return E2 and CPU seconds of every law, case A and B; the first of two runs warms the caches."""
    every = [TestCurve(mode, lam, P, 1.0 / P) for mode, (lam, P) in curves.items()]
    found: dict[str, dict[str, tuple[float, float]]] = {}
    for name in (*REPORT, *MORE):
        law = laws()[name]
        for case, chosen in (("A", every[:1]), ("B", every)):
            start = time.process_time()
            fit = fit_law(Problem(law, Rows.of(chosen)))
            seconds = time.process_time() - start
            assert fit is not None
            found.setdefault(name, {})[case] = (fit.sse, seconds)
    return found


def run_peer(
    peer: str, python: str, curves: dict[str, tuple[np.ndarray, np.ndarray]]
) -> dict[str, dict[str, tuple[float, float]]]:
    """Return the rows of a peer, empty where it is not installed."""
    data = json.dumps({mode: [lam.tolist(), P.tolist()] for mode, (lam, P) in curves.items()})
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [python, str(HERE / "fit_peers" / f"{peer}_fit.py")],
        input=data,
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    if done.returncode != 0:
        print(f"{peer}: {done.stderr.strip().splitlines()[-1] if done.stderr else 'failed'}", file=sys.stderr)
        return {}
    sys.stderr.write(done.stderr)
    rows: dict[str, dict[str, tuple[float, float]]] = json.loads(done.stdout.splitlines()[-1])
    return rows


if __name__ == "__main__":
    main()
