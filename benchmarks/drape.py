"""CPU time, residual and penetration of the drape of a model sheet, and of the report's own relaxation.

    python benchmarks/drape.py [NODES ...]

Model sheet: 200 x 200 x 1 mm, four edges clamped, over a ball of radius 60 mm that stands 80 mm above its plane.
"""

from __future__ import annotations

import resource
import sys
import time

import numpy as np
import trimesh

from hyperfab.cloth import Sheet, answers, drape, mold_of, tabulate
from hyperfab.cloth.relaxation import relax
from hyperfab.cloth.start import lowered
from hyperfab.surface import Surface

RUBBER = tabulate(lambda lam: (0.4 * (lam - lam**-2), 0.4 * (1 + 2 * lam**-3)), 4.0)
LINE = "{:>6} {:<24} {:>9} {:>7} {:>10} {:>10} {:>11} {:>8}"


def model_sheet(n: int, prestretch: float = 1.0) -> Sheet:
    """n by n nodes."""
    return Sheet(n, n, (200.0, 200.0), 1.0, RUBBER, RUBBER, prestretch=(prestretch, prestretch))


def main(sizes: list[int]) -> None:
    """Print the table."""
    ball = trimesh.creation.icosphere(subdivisions=6, radius=60.0)
    mold = mold_of(Surface(ball.vertices, ball.faces), (0.0, 0.0, 20.0))
    drape(model_sheet(30), mold)  # compile
    print(LINE.format("nodes", "run", "CPU s", "steps", "residual", "slack", "node in mm", "GB"))
    times = []
    for n in sizes:
        for name, prestretch in (("newton, slack springs", 1.0), ("newton, pre-stretched", 1.1)):
            sheet = model_sheet(n, prestretch)
            start = time.process_time()
            found = drape(sheet, mold)
            spent = time.process_time() - start
            if prestretch == 1.0:
                times.append(spent)
            said = answers(sheet, mold, found)
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
            row = (n, name, f"{spent:.2f}", len(found.history), f"{found.residual_relative:.1e}")
            print(LINE.format(*row, said.slack_springs, f"{said.node_penetration:.0e}", f"{memory:.2f}"))
        if n <= 100:
            sheet = model_sheet(n)
            for c in (40.0, 1000.0):
                start = time.process_time()
                rough = relax(sheet, mold, lowered(sheet, mold), c, largest=400)
                spent = time.process_time() - start
                row = (n, f"relaxation, c = {c:g}", f"{spent:.2f}", 400, f"{rough.residual_relative:.1e}")
                print(LINE.format(*row, "", "", ""))
    if len(sizes) > 1:
        print(f"CPU time grows as N^{np.polyfit(np.log(sizes), np.log(times), 1)[0]:.2f}, N nodes a side")


if __name__ == "__main__":
    main([int(text) for text in sys.argv[1:]] or [50, 100, 200, 400])
