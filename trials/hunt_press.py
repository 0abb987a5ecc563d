"""Inputs chosen to break ``hf press-contact``, each judged by an invariance, a balance or a formula.

Run as ``PYTHONPATH=. python -m trials.hunt_press [part of a name]``: one line a case, status 1 if any is wrong.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from hyperfab.samples import cup
from trials.hunting import Hunt, Ran, asked, off, on_files
from trials.surfaces import Solid, ball, graph, turned_about

#: How figures grow with all lengths, and with all stresses.
LENGTH = {
    "gap_min_mm": 1,
    "gap_mean_mm": 1,
    "gap_max_mm": 1,
    "contact_area_mm2": 2,
    "force_N": 2,
    "pressure_max_MPa": 0,
    "energy_J": 3,
    "stroke_mm": 1,
}
STRESS = {**dict.fromkeys(LENGTH, 0), "force_N": 1, "pressure_max_MPa": 1, "energy_J": 1}
SAME = dict.fromkeys(LENGTH, 1.0)
Pair = tuple[Solid, Solid]


def foam(thick: float = 4.5, modulus: float = 0.05, length: float = 1.0, more: str = "") -> str:
    """Return a sandwich of linear foam with a material that does not grow with heat, all lengths times ``length``."""
    return f"""
format = "hyperfab.foam/1"
thickness = "{thick * length!r} mm"
compression = {{ law = "linear", modulus = "{modulus!r} MPa" }}
expansion = {{ male = "0 1/K", female = "0 1/K" }}
{more}
"""


def cups(cells: int = 30) -> Pair:
    """Return the sample's molds, the grid of one not that of the other."""
    pair = cup.male_cup(cells, cells + 1), cup.female_cup(cells + 1, cells)
    return Solid(pair[0].vertices, pair[0].faces), Solid(pair[1].vertices, pair[1].faces)


def nested(rings: int = 40, shift: float = 1.5) -> Pair:
    """Return a ball of 70 mm to 80 degrees, in a bowl of 75 mm to 88 degrees ``shift`` lower, open below."""
    around = 2 * rings
    male = ball(70.0, rings, around, 80.0)
    bowl = ball(75.0, int(1.1 * rings), around + 6, 88.0, -shift)
    return Solid(male.vertices, male.faces[:-around]), Solid(bowl.vertices, bowl.faces[: -around - 6, ::-1])


def plates(over: float = 10.0, half: tuple[float, float] = (50.0, 30.0), cells: int = 12, slope: float = 0.0) -> Pair:
    """Return two blocks face to face, 5 mm apart, the upper one ``over`` mm larger all round and sloping along x."""
    male = graph(lambda u, v: 0.0 * u, half, (cells, cells), -30.0)
    wide = (half[0] + over, half[1] + over)
    female = graph(lambda u, v: -5.0 - slope * u, wide, (cells + 1, cells - 1), -45.0)
    return male, female.moved(np.diag([1.0, 1.0, -1.0]))


def moved(pair: Pair, matrix: Any = 1.0, shift: Any = 0.0) -> Pair:
    """Return both molds moved."""
    return pair[0].moved(matrix, shift), pair[1].moved(matrix, shift)


def press(
    pair: Pair, sandwich: str | None = None, unit: float = 1.0, files: Mapping[str, str] = {}, **options: Any
) -> Ran:
    """Press a pair of molds; 3 mm apart unless the options say otherwise."""
    given = {"gap": None if "force" in options else "3mm", "strokes": "5"}
    given |= {key.replace("_", "-"): value for key, value in options.items()}
    names = {"male": "m.stl", "female": "f.stl", "foam": "foam.toml"}
    stls = {"m.stl": pair[0].stl(unit), "f.stl": pair[1].stl(unit)}
    return on_files("press-contact", names | given, {**stls, "foam.toml": sandwich or foam(), **files})


def told(one: Ran) -> str:
    """What a run came to, in a word."""
    if not isinstance(one.document, dict):
        return f"{one.status} {one.said.strip()[-90:]}"
    return f"{one.status} {one['force_N']:.6g} N {one['contact_area_mm2']:.6g} mm2"


def alike(
    hunt: Hunt,
    name: str,
    plain: Callable[[], Ran],
    way: str,
    other: Callable[[], Ran],
    scales: Mapping[str, float] = SAME,
    near: float = 2e-5,
) -> None:
    """Judge whether two presses say the same but for ``scales``."""

    def judged() -> tuple[bool, object]:
        one, two = plain(), other()
        apart = off(one, two, scales)
        return (one.status, two.status) == (0, 0) and apart < near, f"{told(two)} {apart:.1e}"

    hunt.case(f"{name}: {way}", judged)


def invariances(hunt: Hunt) -> None:
    """The same molds told otherwise."""
    by = {f: {key: f**power for key, power in LENGTH.items()} for f in (0.05, 20.0)}
    for name, pair in (("cups", cups()), ("spheres", nested())):
        plain = partial(press, pair)
        same = partial(alike, hunt, name, plain)
        same("mirrored along x", lambda p=pair: press(moved(p, np.diag([-1.0, 1.0, 1.0]))))
        same("mirrored along y", lambda p=pair: press(moved(p, np.diag([1.0, -1.0, 1.0]))))
        same("turned by 37 degrees", lambda p=pair: press(moved(p, turned_about("z", 37.0))))
        same("male on top", lambda p=pair: press(moved(p, turned_about("x", 180.0))))
        same("closing along x", lambda p=pair: press(moved(p, turned_about("y", 90.0)), axis="x"))
        same("closing along y", lambda p=pair: press(moved(p, turned_about("x", 90.0)), axis="y"))
        same("shifted far", lambda p=pair: press(moved(p, shift=[1234.5, -321.0, 77.7])))
        same("in inches", lambda p=pair: press(p, unit=25.4, stl_unit="inch"))
        same("in metres", lambda p=pair: press(p, unit=1000.0, stl_unit="m"))
        same("facets in another order", lambda p=pair: press((p[0].shuffled(1), p[1].shuffled(2))))
        same("drawn further apart", lambda p=pair: press((p[0], p[1].moved(shift=[0.0, 0.0, 30.0]))))
        same("drawn into each other", lambda p=pair: press((p[0], p[1].moved(shift=[0.0, 0.0, -7.0]))))
        same("hot, of a metal that does not grow", lambda p=pair: press(p, temperature="200degC"))
        same("gap set hot", lambda p=pair: press(p, temperature="200degC", zero="hot"))
        same("a frame that does not yield", lambda p=pair: press(p, frame_stiffness="1e12kN/mm"))
        same("a tilt of nothing", lambda p=pair: press(p, tilt="0deg,0deg"))
        same("a tilt of 1e-9 degrees", lambda p=pair: press(p, tilt="1e-9deg,1e-9deg"))
        same(
            "foam that relaxes by nothing",
            lambda p=pair: press(p, foam(more='relaxation = { share = 0, time = "1 s", dwell = "9 s" }')),
        )
        same("foam even by variation", lambda p=pair: press(p, foam(more="variation = { x = 0, yy = 0 }")))
        same(
            "a table of two rows",
            lambda p=pair: press(
                p,
                foam().replace('{ law = "linear", modulus = "0.05 MPa" }', '{ table = "t.csv" }'),
                files={"t.csv": "strain [-],stress [MPa]\n0,0\n0.99,0.0495\n"},
            ),
        )
        same(
            "a table in percent and kPa",
            lambda p=pair: press(
                p,
                foam().replace('{ law = "linear", modulus = "0.05 MPa" }', '{ table = "t.csv" }'),
                files={"t.csv": "stress [kPa];strain [%]\n0;0\n24.75;49.5\n49.5;99\n"},
            ),
        )
        same("at the force that it said", lambda p=pair: press(p, force=f"{press(p)['force_N']!r}N"), near=1e-5)
        same(
            "a thousand times stiffer",
            lambda p=pair: press(p, foam(modulus=50.0)),
            {k: 1e3**v for k, v in STRESS.items()},
        )
        for factor, scales in by.items():
            same(
                f"all lengths {factor:g} times",
                lambda p=pair, f=factor: press(moved(p, f), foam(length=f), gap=f"{3.0 * f!r}mm"),
                scales,
            )
        hunt.case(f"{name}: flat facets split in four, and again", partial(split, pair))
        hunt.case(f"{name}: force is the rate of energy", partial(rate, cups(60) if name == "cups" else pair, {}))
    # Spheres of 20 rings are cut as fine as those of 40 are.
    hunt.case("cups: refined", partial(refined, cups, (20, 40, 80)))
    hunt.case("spheres: refined", partial(refined, nested, (40, 80, 160)))
    hunt.case("cups: force is the rate of energy, tilted", partial(rate, cups(60), {"tilt": "0.5deg,-0.3deg"}))
    hunt.case("cups: force is the rate of energy, flat facets", partial(rate, cups(), {"facets": "flat"}))


def rate(pair: Pair, options: Mapping[str, Any]) -> tuple[bool, object]:
    """Whether the force is the rate of the energy with the travel."""
    runs = [press(pair, gap=f"{g}mm", **options) for g in (2.99, 3.0, 3.01)]
    force = 1e3 * (runs[0]["energy_J"] - runs[2]["energy_J"]) / 0.02
    apart = abs(force / runs[1]["force_N"] - 1.0)
    return runs[1].status == 0 and apart < 2e-3, f"{told(runs[1])} {apart:.1e}"


def split(pair: Pair) -> tuple[bool, object]:
    """Whether the same flat facets, split in four and once more, lead to one answer: a facet counts by its corners."""
    runs = [press(pair, facets="flat")]
    for _ in range(2):
        pair = pair[0].split(), pair[1].split()
        runs.append(press(pair, facets="flat"))
    steps = [abs(b["force_N"] / a["force_N"] - 1.0) for a, b in pairwise(runs)]
    return steps[1] < 0.4 * steps[0], f"{told(runs[2])} {steps[0]:.1e} {steps[1]:.1e}"


def refined(made: Callable[[int], Pair], sizes: tuple[int, ...]) -> tuple[bool, object]:
    """Whether finer molds change the answer less and less."""
    runs = [press(made(cells)) for cells in sizes]
    steps = [abs(b["force_N"] / a["force_N"] - 1.0) for a, b in pairwise(runs)]
    return steps[1] < max(0.7 * steps[0], 1e-4), f"{told(runs[2])} {steps[0]:.1e} {steps[1]:.1e}"


def near_to(one: Ran, expected: Mapping[str, float], near: float, status: int = 0) -> tuple[bool, object]:
    """Whether figures are what a formula says."""
    apart = max(abs(one[key] - value) / max(abs(value), 1e-9) for key, value in expected.items())
    return one.status == status and apart < near, f"{told(one)} {apart:.1e}"


def known(hunt: Hunt) -> None:
    """Plates, spheres and wedges, whose answer is a formula; ends that have a status."""
    area = 100.0 * 60.0
    for gap in (4.4999, 3.0, 1e-6):
        for over in (10.0, 0.0, -10.0):
            # A female that is smaller is nearest by its rim beyond it: only what faces it is known.
            pressure = 0.05 * (4.5 - gap) / 4.5
            expected = {"gap_min_mm": gap, "pressure_max_MPa": pressure}
            if over >= 0.0:
                expected |= {
                    "force_N": pressure * area,
                    "contact_area_mm2": area,
                    "energy_J": 0.5e-3 * pressure * (4.5 - gap) * area,
                }
            hunt.case(
                f"plates {gap:g} mm apart, the female {over:g} larger",
                lambda e=expected, g=gap, o=over: near_to(press(plates(o), gap=f"{g!r}mm"), e, 1e-5),
            )
    for half in ((0.5, 0.5), (500.0, 3.0), (2000.0, 1500.0)):
        size = 4.0 * half[0] * half[1]
        hunt.case(
            f"plates of {2 * half[0]:g} x {2 * half[1]:g} mm",
            lambda h=half, s=size: near_to(
                press(plates(10.0, h)), {"force_N": 0.05 * 1.5 / 4.5 * s, "contact_area_mm2": s}, 1e-9
            ),
        )
    hot = foam().replace(
        'male = "0 1/K", female = "0 1/K"', 'male = "20e-6 1/K", female = "10e-6 1/K", reference = "20 degC"'
    )
    # 30 mm of male and 40 mm of female above the faces grow towards each other, the male's face to all sides.
    grown = 3.0 - 30.0 * 20e-6 * 180.0 - 40.0 * 10e-6 * 180.0
    wide = (1.0 + 20e-6 * 180.0) ** 2 * area
    hunt.case(
        "plates grow towards each other",
        lambda: near_to(
            press(plates(), hot, temperature="200degC"),
            {"gap_min_mm": grown, "force_N": 0.05 * (4.5 - grown) / 4.5 * wide},
            1e-8,
        ),
    )
    hunt.case(
        "plates set hot",
        lambda: near_to(
            press(plates(), hot, temperature="200degC", zero="hot"),
            {"gap_min_mm": 3.0, "force_N": 0.05 * 1.5 / 4.5 * wide},
            1e-8,
        ),
    )
    hunt.case(
        "plates at the reference temperature",
        lambda: near_to(press(plates(), hot, temperature="293.15K"), {"gap_min_mm": 3.0}, 1e-9),
    )
    yielding = 0.05 * area / 4.5  # N/mm of the foam
    stands = (50.0 * 3.0 + yielding * 4.5) / (50.0 + yielding)
    hunt.case(
        "plates in a frame of 50 N/mm",
        lambda: near_to(
            press(plates(), frame_stiffness="50N/mm"),
            {"gap_min_mm": stands, "force_N": yielding * (4.5 - stands)},
            1e-7,
        ),
    )
    for degrees in (0.5, -1.0):
        slope = float(np.tan(np.radians(degrees)))

        def wedge(s: float = slope) -> tuple[bool, object]:
            # The nearest gap to a sloping plane, where the male's ends are 3 mm apart at the least along the axis.
            one = press(plates(30.0, slope=s))
            x = np.linspace(-50.0, 50.0, 200001)
            gap = (3.0 + abs(s) * 50.0 + s * x) * np.cos(np.arctan(s))
            p = 0.05 * np.maximum(4.5 - gap, 0.0) / 4.5
            force = np.trapezoid(p, x) * 60.0 * np.cos(np.arctan(s))
            return near_to(one, {"force_N": force, "gap_min_mm": gap.min(), "gap_max_mm": gap.max()}, 1e-3)

        hunt.case(f"a wedge of {degrees:g} degrees", wedge)
    for shift in (0.0, 1.5, 3.0):

        def bowl(d: float = shift) -> tuple[bool, object]:
            angle = np.linspace(0.0, np.radians(80.0), 200001)
            at_top = 5.0 - d
            d_now = d + at_top - 3.0  # closed until 3 mm are left at the top
            gap = 75.0 - np.sqrt(4900.0 + 140.0 * d_now * np.cos(angle) + d_now**2)
            p = 0.05 * np.maximum(4.5 - gap, 0.0) / 4.5
            lean = (70.0 * np.cos(angle) + d_now) / np.sqrt(4900.0 + 140.0 * d_now * np.cos(angle) + d_now**2)
            force = np.trapezoid(p * lean * 2.0 * np.pi * 4900.0 * np.sin(angle), angle)
            return near_to(press(nested(60, d)), {"force_N": force, "gap_min_mm": 3.0}, 2e-3)

        hunt.case(f"a ball in a bowl {shift:g} mm lower", bowl)

    def sides() -> tuple[bool, object]:
        one, two = (
            press(cups(), tilt="0.4deg,0deg"),
            press(moved(cups(), np.diag([1.0, -1.0, 1.0])), tilt="-0.4deg,0deg"),
        )
        apart = off(one, two, SAME)
        return apart < 1e-4, f"{told(two)} {apart:.1e}"

    hunt.case("tilted one way as mirrored the other", sides)
    ends: dict[str, tuple[Callable[[], Ran], tuple[int, ...]]] = {
        "swapped molds": (lambda: press(cups()[::-1]), (3,)),
        "an axis along which they do not close": (lambda: press(cups(), axis="x"), (3,)),
        "a force that no foam carries": (lambda: press(plates(), force="1e9N"), (3,)),
        "a force of next to nothing": (lambda: press(plates(), force="1e-6N"), (0,)),
        "molds side by side": (
            lambda: press((plates()[0], plates()[1].moved(shift=[500.0, 0.0, 0.0]))),
            (3,),
        ),
        "a gap of nothing": (lambda: press(plates(), gap="0mm"), (0, 1)),
        "hot until they collide": (lambda: press(plates(), hot, gap="0.05mm", temperature="300degC"), (1,)),
        "more spotted than there is": (lambda: press(cups(), min_spotted="99.9"), (1,)),
        "two facets a mold": (lambda: press(plates(cells=2)), (0,)),
        "a floating female on a wedge": (
            lambda: press(plates(30.0, slope=0.02), floating=None, float=True, force="30N"),
            (0, 4),
        ),
        "an open female upside down": (
            lambda: press((nested()[0], Solid(nested()[1].vertices, nested()[1].faces[:, ::-1]))),
            (0,),
        ),
        "foam of a hundredth of a millimetre": (lambda: press(cups(), foam(thick=0.01)), (0,)),
        "foam of half a metre": (lambda: press(plates(), foam(thick=500.0)), (0,)),
    }
    for name, (made, statuses) in ends.items():
        hunt.case(
            f"ends with a status of its own: {name}",
            lambda m=made, s=statuses: ((one := m()).status in s, told(one)),
        )


def main() -> int:
    """Run the cases and count."""
    hunt = asked(sys.argv)
    for part in (invariances, known):
        part(hunt)
    return hunt.ended("hf press-contact")


if __name__ == "__main__":
    raise SystemExit(main())
