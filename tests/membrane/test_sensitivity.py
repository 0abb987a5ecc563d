"""What an equilibrium changes by with a number of the test: against equilibria found anew, and Euler's theorem."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hyperfab.materials import bind
from hyperfab.membrane.equilibrium import Press
from hyperfab.membrane.measures import fields
from hyperfab.membrane.outline import Disc
from hyperfab.membrane.sensitivity import Neighbourhood
from hyperfab.membrane.sphere_contact import Solved, SphereTest, run
from hyperfab.membrane.tension_field import IsotropicSheet

DEPTH = 45.0
#: Of differences, over the constant.
STEP = 1e-4
CONSTANTS = {"C10_MPa": 0.061, "C20_MPa": 0.0215, "C30_MPa": 0.0173}


def of(constants: dict[str, float], model: str = "yeoh-3", **more: float) -> SphereTest:
    """Return a test of a sheet with these constants."""
    law = IsotropicSheet(bind(model, constants))
    return SphereTest(Disc(100.0, quarter=True), law, 0.6, 40.0, mesh_size=14.0, **more)  # type: ignore[arg-type]


def figures(solved: Solved) -> dict[str, float]:
    """Return the force, the energy and the largest stress."""
    smooth = fields(solved.press.sheet, solved.state.places)
    return {"force": solved.state.force, "energy": solved.state.energy, "stress": float(smooth.cauchy.max())}


@pytest.fixture(scope="module")
def solved() -> Solved:
    """The equilibrium at the last depth."""
    return run([of(CONSTANTS)], [25.0, DEPTH], 1e-2)[0].solved[-1]


def moved(name: str, change: float) -> tuple[SphereTest, float]:
    """Return the test with one of its numbers changed."""
    if name in CONSTANTS:
        return of(CONSTANTS | {name: CONSTANTS[name] + change}), DEPTH
    if name == "depth":
        return of(CONSTANTS), DEPTH + change
    return replace(of(CONSTANTS), **{name: getattr(of(CONSTANTS), name) + change}), DEPTH


@pytest.mark.parametrize(
    ("name", "size"),
    [("C10_MPa", 0.06), ("C20_MPa", 0.02), ("C30_MPa", 0.017), ("thickness", 0.6), ("radius", 40.0), ("depth", 45.0),
     ("prestretch", 1.0)],
)  # fmt: skip
def test_sensitivities_are_those_of_equilibria_found_anew(solved: Solved, name: str, size: float) -> None:
    near, step = Neighbourhood(solved), 1e-5 * size  # no node comes to touch or is let go on the way

    def test(change: float) -> tuple[SphereTest, float]:
        return moved(name, change)

    way, direct = near.slopes(test, step, figures)
    rows = [figures(near.equilibrium(*test(k * step), k * step * way)) for k in (-1, 1, -2, 2)]
    for key in direct:
        again = (8.0 * (rows[1][key] - rows[0][key]) - (rows[3][key] - rows[2][key])) / (12.0 * step)
        assert direct[key] == pytest.approx(again, rel=1e-5, abs=1e-8 * abs(rows[0][key]) / size), key


@pytest.mark.parametrize(
    ("model", "constants"),
    [("yeoh-3", CONSTANTS), ("mooney-rivlin-2", {"C10_MPa": 0.05, "C01_MPa": 0.02})],
)
def test_force_is_the_sum_of_each_constant_times_its_sensitivity(
    solved: Solved, model: str, constants: dict[str, float]
) -> None:
    """Euler's theorem: places hang on the ratios of constants that are stresses, forces go with all of them."""
    if model != "yeoh-3":
        solved = run([of(constants, model)], [25.0, DEPTH], 1e-2)[0].solved[-1]
    near, total = Neighbourhood(solved), dict.fromkeys(figures(solved), 0.0)
    for name, value in constants.items():

        def test(change: float, name: str = name) -> tuple[SphereTest, float]:
            return of(constants | {name: constants[name] + change}, model), DEPTH

        for key, slope in near.slopes(test, STEP * value, figures)[1].items():
            total[key] += value * slope
    for key, value in figures(solved).items():
        assert total[key] == pytest.approx(value, rel=1e-9), key


def test_an_equilibrium_with_friction_has_no_neighbours(solved: Solved) -> None:
    from hyperfab.membrane.contact import Coulomb

    rubbing = Press(solved.press.sheet, solved.press.punch, Coulomb(0.3))
    with pytest.raises(ValueError, match="friction"):
        Neighbourhood(Solved(rubbing, solved.state))
    assert np.isfinite(solved.state.force)
