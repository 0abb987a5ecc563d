"""Bands of a heated mold against 2,000 full runs with all that is unsure drawn anew (JCGM 101:2008, 8).

A plate of aluminium on a heater at one side, with a film by temperature and with radiation, small enough that each run
is a run of its own: steps choose themselves, and nothing is taken from the run whose bands are judged. Prints, of each
figure, by how many of its standard deviations the ends of its interval are off, and whether that is within half a unit
of the first digit of the standard deviation:

    PYTHONPATH=. python -m trials.linear_heat [RUNS]
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from scipy.special import ndtri
from scipy.stats import qmc

from hyperfab.cases.options import read
from hyperfab.cases.registry import case_class
from hyperfab.chapters.mold_heat import problem
from hyperfab.chapters.rerun import rerun
from hyperfab.chapters.uncertainty.carry import figures_of

RUNS = 2000
MOLD = """format = "hyperfab.mold/1"
[material.aluminium]
density = "2702 kg/m^3"
conductivity = "{k}"
specific_heat = "{c}"
[[part]]
name = "plate"
material = "aluminium"
box = {{ origin = ["0 mm", "0 mm", "0 mm"], size = ["120 mm", "60 mm", "20 mm"] }}
[[heater]]
on = "plate.x-"
power = "{power}"
[[convection]]
on = "exposed"
h = {{ table = "film.csv" }}
ambient = "{room}"
[[radiation]]
on = "exposed"
emissivity = 0.3
ambient = "25 degC"
[run]
start = "25 degC"
{end}
mesh_size = "20 mm"
tolerance = "0.05 K"
[work_surface]
on = "plate.z+"
[[probe]]
name = "far"
at = ["120 mm", "60 mm", "20 mm"]
"""
FILM = np.array([[25.0, 5.0], [100.0, 9.0], [250.0, 13.0]])
#: What is unsure: its value, its standard deviation, its unit.
UNSURE = {
    "k": (237.0, 7.0, "W/m/K"), "c": (903.0, 9.0, "J/kg/K"), "power": (300.0, 9.0, "W"), "room": (25.0, 3.0, "degC")
}  # fmt: skip
#: Of all rows of the film together, over its values.
FILM_SD = 0.2
ENDS = {"to a target": 'target = "150 degC"', "to a time": 'until = "600 s"'}


def film(by: float, sd: bool = False) -> bytes:
    """Return the film's table, off by so many of its standard deviations."""
    rows = [f"{t},{h * (1.0 + FILM_SD * by)}" + (f",{h * FILM_SD}" if sd else "") for t, h in FILM]
    head = "temperature [degC],h [W/m^2/K]" + (",h sd [W/m^2/K]" if sd else "")
    return "\n".join([head, *rows, ""]).encode()


def heated(mold: str, table: bytes, uncertainty: str | None) -> dict[str, Any]:
    """Return the document of a mold."""
    words = ["mold.toml"] + ([] if uncertainty is None else ["--uncertainty", uncertainty])
    case = read(case_class("mold-heat"), words)
    return rerun(case, "-", {"mold.toml": mold.encode(), "film.csv": table}).document


def drawn(runs: int, end: str) -> Iterator[dict[str, float]]:
    """Yield the figures of runs with everything drawn: a Latin hypercube, each number by itself."""
    numbers = ndtri(qmc.LatinHypercube(len(UNSURE) + 1, seed=7).random(runs))
    for row in numbers:
        moved = {
            name: f"{value + float(by) * sd!r} {unit}"
            for (name, (value, sd, unit)), by in zip(UNSURE.items(), row, strict=False)
        }
        yield dict(figures_of(heated(MOLD.format(**moved, end=end), film(float(row[-1])), "none"), "heat"))


def half_a_unit(sd: float) -> float:
    """Return half a unit of the first digit of a standard deviation (JCGM 101, 7.9.2).

    >>> half_a_unit(0.032), half_a_unit(18.0)
    (0.005, 5.0)
    """
    return float(0.5 * 10.0 ** np.floor(np.log10(sd)))


def once(make: Callable[..., Any]) -> Callable[..., Any]:
    """Return what makes a thing the first time, and gives the same ever after."""
    made: list[Any] = []

    def kept(*given: Any) -> Any:
        if not made:
            made.append(make(*given))
        return made[0]

    return kept


def main() -> None:
    """Print each figure's intervals, by bands and by runs."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else RUNS
    # What is drawn does not change the mold: it is meshed once.
    problem.mesh_mold = once(problem.mesh_mold)
    stated = {
        name: f"{value!r} {unit} +- {sd!r} {unit.replace('degC', 'K')}" for name, (value, sd, unit) in UNSURE.items()
    }
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for label, end in ENDS.items():
            found = heated(MOLD.format(**stated, end=end), film(0.0, sd=True), None)["uncertainty"]
            straight = heated(MOLD.format(**stated, end=end), film(0.0, sd=True), "linear")["uncertainty"]
            full = list(drawn(runs, end))
            print(f"{label}: by itself {found['method']} {found.get('reason', '')}")
            for name, band in straight["quantities"].items():
                outcomes = np.array([one[name] for one in full])
                low, high = np.quantile(outcomes, [0.025, 0.975])
                sd = float(outcomes.std(ddof=1))
                own = found["quantities"][name]
                off, chosen = (max(abs(one["low"] - low), abs(one["high"] - high)) for one in (band, own))
                print(
                    f"  {name}: sd linear {band['sd']:.5g}, chosen {own['sd']:.5g}, {runs} runs {sd:.5g}; ends linear "
                    f"{off / sd:.3f} sd, chosen {chosen / sd:.3f} sd off"
                    f" ({'within' if chosen <= half_a_unit(sd) else 'BEYOND'} half a unit)",
                    flush=True,
                )


if __name__ == "__main__":
    main()
