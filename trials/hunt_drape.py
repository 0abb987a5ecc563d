"""Inputs chosen to break ``hf drape``, each judged by an invariance, a balance or a known answer.

Ran as ``PYTHONPATH=. python -m trials.hunt_drape [part of a name]``: one line a case, status 1 if any is wrong.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from trials.hunting import Hunt, Ran, asked, off, on_files
from trials.surfaces import Solid, ball, graph, joined, lathe, turned_about

C_WARP, C_WEFT, THICK = 0.2, 0.12, 0.8
USUAL = {"grid": "31x27", "size": "200mmx170mm", "depth": "45mm"}
#: Figures and what they become where all lengths, or all stresses, are ``f`` times as large.
LENGTH = {"force_N": 2, "energy_J": 3, "stress_warp_max_MPa": 0, "thickness_min_mm": 1, "stretch_max": 0}
STRESS = {"force_N": 1, "energy_J": 1, "stress_warp_max_MPa": 1, "thickness_min_mm": 0, "stretch_max": 0}
SAME = dict.fromkeys((*LENGTH, "stress_weft_max_MPa"), 1.0)
#: Rounding may lead nodes into other facets, where the sheet rests elsewhere: off in force and energy, at a spring.
NEAR, LOCAL = 2e-4, 1e-2
SWAPPED = {"force_N": 1.0, "energy_J": 1.0, "thickness_min_mm": 1.0, "stretch_max": 1.0}


def fabric(warp: float = C_WARP, weft: float = C_WEFT, thick: float = THICK) -> str:
    """Return a neo-Hookean fabric by its constants along warp and weft [MPa]."""
    ways = {name: {"parameters": {"C10_MPa": c}} for name, c in (("warp", warp), ("weft", weft))}
    return json.dumps(
        {
            "format": "hyperfab.material/1",
            "model": "neo-hookean",
            "parameters": {"C10_MPa": warp},
            "thickness_mm": thick,
            "directions": ways,
        }
    )


def law(model: str, **parameters: float) -> str:
    """Return an isotropic fabric."""
    return json.dumps(
        {"format": "hyperfab.material/1", "model": model, "parameters": parameters, "thickness_mm": THICK}
    )


def drape(mold: Solid | Mapping[str, str], cloth: str | None = None, **options: Any) -> Ran:
    """Drape a sheet on a surface, or on files by name."""
    files = {"m.stl": mold.stl()} if isinstance(mold, Solid) else dict(mold)
    molds = [name for name in files if name.endswith(".stl")]
    given = {"": "f.json", "mold": molds, **USUAL} | {key.replace("_", "-"): value for key, value in options.items()}
    return on_files("drape", given, {"f.json": cloth or fabric(), **files})


def sound(one: Ran) -> bool:
    """Whether a sheet rests: at equilibrium, forces balanced, nowhere inside the mold."""
    return (
        one.status == 0
        and one["converged"]
        and one["residual_relative"] <= 1e-6
        and abs(one["imbalance_N"]) <= 1e-5 * max(one["force_N"], 1e-3)
        and one["penetration_nodes_mm"] <= 1e-9
        and one["force_N"] > 0.0
    )


def parted(one: Ran, two: Ran, scales: Mapping[str, float] = SAME) -> tuple[float, float]:
    """Return how far two answers are apart: in force and energy, and in what single springs and cells say."""
    whole = {key: scales[key] for key in ("force_N", "energy_J")}
    return off(one, two, whole), off(one, two, {key: scale for key, scale in scales.items() if key not in whole})


def told(one: Ran) -> str:
    """What a run came to, in a word."""
    if not one.document:
        return f"{one.status} {one.said.strip()[-90:]}"
    return f"{one.status} {one['force_N']:.6g} N {one.document.get('status') or ''}"[:100]


def waves(u: Any, v: Any) -> Any:
    """Hills and valleys of 6 mm, 20 mm apart."""
    return 6.0 * np.sin(u / 6.0) * np.cos(v / 7.0)


def skew(u: Any, v: Any) -> Any:
    """A hill without any symmetry."""
    return 50.0 * np.exp(-(((u - 8.0) / 48.0) ** 2) - ((v + 0.3 * u) / 42.0) ** 2)


MOLDS = {
    "ball": ball(60.0, 72, 144),
    "hill": graph(skew, (75.0, 65.0), (90, 80), -20.0),
    "box": graph(lambda u, v: 0.0 * u, (45.0, 30.0), (6, 4), -60.0),
}


def alike(
    hunt: Hunt,
    name: str,
    plain: Callable[[], Ran],
    way: str,
    other: Callable[[], Ran],
    scales: Mapping[str, float] = SAME,
) -> None:
    """Judge whether a sheet rests told one way and another, alike but for ``scales``."""

    def judged() -> tuple[bool, object]:
        one, two = plain(), other()
        whole, local = parted(one, two, scales)
        good = sound(one) and sound(two) and whole < NEAR and local < LOCAL
        return good, f"{told(two)} {whole:.1e} {local:.1e}"

    hunt.case(f"{name}: {way}", judged)


def invariances(hunt: Hunt) -> None:
    """The same sheet on the same mold told otherwise."""
    mirror, quarter = np.diag([-1.0, 1.0, 1.0]), turned_about("z", 90.0)
    for name, mold in MOLDS.items():
        same = partial(alike, hunt, name, partial(drape, mold))

        def by(exponents: Mapping[str, int], factor: float) -> dict[str, float]:
            return {key: factor**power for key, power in exponents.items()}

        same("mirrored", lambda m=mold: drape(m.moved(mirror)))
        same(
            "a quarter turn, warp for weft",
            lambda m=mold: drape(m.moved(quarter), fabric(C_WEFT, C_WARP), grid="27x31", size="170mmx200mm"),
            SWAPPED,
        )
        same("shifted far", lambda m=mold: drape(m.moved(shift=[1234.5, -321.0, 77.7])))
        same("in inches", lambda m=mold: drape({"m.stl": m.stl(25.4)}, stl_unit="inch"))
        same(
            "along x",
            lambda m=mold: drape(m.moved([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), axis="x"),
        )
        same("facets in another order", lambda m=mold: drape(m.shuffled()))
        same("every facet split in four", lambda m=mold: drape(m.split()))
        for factor in (0.02, 30.0):
            words = {
                "size": f"{200 * factor!r}mmx{170 * factor!r}mm",
                "depth": f"{45 * factor!r}mm",
                "thickness": f"{THICK * factor!r}mm",
            }
            same(
                f"all lengths {factor:g} times",
                lambda m=mold, w=words, f=factor: drape(m.moved(f), **w),
                by(LENGTH, factor),
            )
        for factor in (1e-6, 1e5):
            same(
                f"stresses {factor:g} times",
                lambda m=mold, f=factor: drape(m, fabric(f * C_WARP, f * C_WEFT)),
                by(STRESS, factor),
            )
        same("at the last of several depths", lambda m=mold: drape(m, depths="11mm,45mm,30mm", depth=None))
        same(
            "thinner by 1e-4, forces too",
            lambda m=mold: drape(m, thickness="8e-5mm"),
            {"force_N": 1e-4, "energy_J": 1e-4, "stretch_max": 1.0, "thickness_min_mm": 1e-4},
        )


def membranes(hunt: Hunt) -> None:
    """The same membrane of one energy for warp, weft and bias told otherwise."""
    mirror, quarter = np.diag([-1.0, 1.0, 1.0]), turned_about("z", 90.0)
    ground = {"C10_MPa": 0.05, "nu": 0.35, "k1_bias_MPa": 0.05, "k2_bias": 1.0, "bias_deg": 45.0, "G_MPa": 0.02}

    def sheet(way: str, across: str, factor: float = 1.0) -> str:
        constants = {**ground, f"k1_{way}_MPa": 0.15, f"k2_{way}": 1.2, f"k1_{across}_MPa": 0.06, f"k2_{across}": 2.0}
        return law("orthotropic", **{k: v * (factor if k.endswith("_MPa") else 1.0) for k, v in constants.items()})

    plain, turned = sheet("warp", "weft"), sheet("weft", "warp")
    for name in ("ball", "hill"):
        mold, shell = MOLDS[name], partial(drape, sheet="membrane")
        same = partial(alike, hunt, f"membrane, {name}", partial(shell, mold, plain))
        same("mirrored", lambda m=mold, s=shell: s(m.moved(mirror), plain))
        same(
            "a quarter turn, warp for weft",
            lambda m=mold, s=shell: s(m.moved(quarter), turned, grid="27x31", size="170mmx200mm"),
            SWAPPED,
        )
        same("shifted far", lambda m=mold, s=shell: s(m.moved(shift=[1234.5, -321.0, 77.7]), plain))
        same("every facet split in four", lambda m=mold, s=shell: s(m.split(), plain))
        same(
            "stresses 1e5 times",
            lambda m=mold, s=shell: s(m, sheet("warp", "weft", 1e5)),
            {key: 1e5**power for key, power in STRESS.items()},
        )


def balances(hunt: Hunt) -> None:
    """The press's force is the rate of the energy, whatever the sheet resists with."""
    fine = ball(60.0, 96, 192)
    hill = graph(skew, (75.0, 65.0), (150, 130), -20.0)
    ways: dict[str, dict[str, Any]] = {
        "threads alone": {},
        "shear stiffness": {"shear_modulus": "40kPa"},
        "mounted taut": {"prestretch": "1.15x1.05"},
        "mounted slack": {"prestretch": "0.97x0.99"},
        "two edges free": {"clamp": "x-,x+"},
        "edges that slide": {"clamp": "x-,x+", "slide": "y-,y+"},
    }
    for name, mold in (("ball", fine), ("hill", hill)):
        for way, options in ways.items():

            def judged(mold: Solid = mold, options: dict[str, Any] = options) -> tuple[bool, object]:
                runs = [drape(mold, depth=f"{d}mm", tolerance="1e-8", **options) for d in (39.9, 40.0, 40.1)]
                rate = 1e3 * (runs[2]["energy_J"] - runs[0]["energy_J"]) / 0.2
                apart = abs(rate / runs[1]["force_N"] - 1.0)
                return all(map(sound, runs)) and apart < 2e-3, f"{told(runs[1])} {apart:.1e}"

            hunt.case(f"force is the rate of energy: {name}, {way}", judged)


def ended(mold: Solid, options: Mapping[str, Any], statuses: tuple[int, ...]) -> tuple[bool, object]:
    """Whether a run ends with one of the statuses, and with status 0 only where the mold bears the sheet."""
    one = drape(mold, **options)
    if not one.document:
        return one.status in statuses and one.status != 0, told(one)
    limp = one["prestretch"][0] < 1.0 or len(one["clamp"]) == 1  # nothing pulls the sheet tight
    held = one.status != 0 or one["depth_mm"] == 0.0 or limp or one["force_N"] > 1e-9
    return one.status in statuses and held, told(one)


def uniaxial(stretch: float, constant: float) -> tuple[float, float]:
    """Return energy density and nominal stress of a neo-Hookean thread."""
    return constant * (stretch**2 + 2.0 / stretch - 3.0), 2.0 * constant * (stretch - stretch**-2)


def known(hunt: Hunt) -> None:
    """Answers that are formulas, limits that must be met, and ends that have a status."""
    for a, b in ((1.0001, 3.0), (2.5, 1.1), (1.3, 1.3)):

        def stretched(a: float = a, b: float = b) -> tuple[bool, object]:
            one = drape(ball(60.0), prestretch=f"{a}x{b}", depth="0mm")
            energy = (uniaxial(a, C_WARP)[0] + uniaxial(b, C_WEFT)[0]) * 200.0 / a * 170.0 / b * THICK * 1e-3
            apart = max(abs(one["energy_J"] / energy - 1.0), abs(one["thickness_min_mm"] * a * b / THICK - 1.0))
            return one.status == 0 and apart < 1e-8, f"{told(one)} {apart:.1e}"

        hunt.case(f"mounted {a:g} by {b:g}: energy and thickness", stretched)

    def ridge(cells: int) -> Solid:
        """A cylinder of radius 60 mm lying along y, its axis at z = 0."""
        return lathe(np.array([[0.0, -40.0], [60.0, -40.0], [60.0, 40.0], [0.0, 40.0]]), cells).moved(
            turned_about("x", 90.0)
        )

    def string() -> tuple[bool, object]:
        one = drape(ridge(720), grid="201x3", size="200mmx10mm", clamp="x-,x+", depth="20mm")
        reach, half = np.hypot(100.0, 40.0), 100.0
        wrap = np.arctan2(40.0, half) + np.arccos(60.0 / reach)
        length = 2.0 * np.sqrt(reach**2 - 3600.0) + 60.0 * (np.pi - 2.0 * wrap)
        stretch = length / 200.0
        lean = np.pi / 2 - wrap
        force = 2.0 * uniaxial(stretch, C_WARP)[1] * 10.0 * THICK * np.sin(lean)
        apart = max(abs(one["force_N"] / force - 1.0), abs(one["stretch_max"] / stretch - 1.0))
        return sound(one) and apart < 2e-3, f"{told(one)} {force:.6g} {apart:.1e}"

    hunt.case("a strip over a cylinder: stretch and force", string)

    def refined(mold: Solid, options: dict[str, Any], most: float) -> tuple[bool, object]:
        runs = [drape(mold, grid=grid, **options) for grid in ("21x21", "41x41", "81x81")]
        steps = [abs(b["energy_J"] / a["energy_J"] - 1.0) for a, b in pairwise(runs)]
        return all(map(sound, runs)) and steps[1] < max(
            0.6 * steps[0], most
        ), f"{told(runs[2])} {steps[0]:.1e} {steps[1]:.1e}"

    hunt.case("refined: ball", lambda: refined(ball(60.0, 96, 192), {}, 1e-4))
    hunt.case(
        "refined: ball, shear stiffness",
        lambda: refined(ball(60.0, 96, 192), {"shear_modulus": "40kPa"}, 1e-4),
    )
    hunt.case("refined: ball with friction", lambda: refined(ball(60.0, 96, 192), {"friction": "0.3"}, 1e-3))

    def limit(name: str, options: dict[str, Any], plain: dict[str, Any], near: float) -> None:
        def judged() -> tuple[bool, object]:
            mold = ball(60.0, 48, 96)
            one, two = drape(mold, **plain), drape(mold, **(plain | options))
            apart = off(one, two, {"force_N": 1.0, "energy_J": 1.0})
            return sound(one) and sound(two) and apart < near, f"{told(two)} {apart:.1e}"

        hunt.case(f"limit: {name}", judged)

    limit("friction of 1e-6", {"friction": "1e-6"}, {}, 1e-3)
    limit("a shear modulus of 1e-3 Pa", {"shear_modulus": "0.001Pa"}, {}, 1e-5)
    limit("a blank holder that holds", {"blank_holder": "1e4N/mm", "load_steps": "4"}, {}, 1e-5)
    limit("a sheet that weighs 1e-6 g/m^2", {"mass": "1e-6g/m^2"}, {}, 1e-6)
    limit("prestretch of 1 + 1e-9", {"prestretch": "1.000000001"}, {}, 1e-5)
    limit("dynamic relaxation", {"solver": "dynamic"}, {"grid": "17x15"}, 1e-4)
    limit("dynamic relaxation, shear", {"solver": "dynamic"}, {"grid": "17x15", "shear_modulus": "50kPa"}, 1e-4)

    def two_files(order: int) -> tuple[bool, object]:
        pair = [ball(40.0).moved(shift=[x, 5.0 * x / 30.0, 0.0]) for x in (-30.0, 30.0)]
        whole = drape(joined(*[one.moved(shift=[0.0, 0.0, 0.0]) for one in pair]), grid="41x35")
        files = {f"{k}.stl": one.stl() for k, one in enumerate(pair[::order])}
        apart_run = drape(files, grid="41x35")
        apart = off(whole, apart_run, SAME)
        return sound(apart_run) and apart < 1e-5, f"{told(apart_run)} {told(whole)} {apart:.1e}"

    hunt.case("two balls in two files as in one", lambda: two_files(1))
    hunt.case("two balls in two files, the other order", lambda: two_files(-1))
    shapes: dict[str, tuple[Solid, dict[str, Any]]] = {
        "a grid of 3x3": (ball(60.0, 144, 288), {"grid": "3x3"}),
        "a grid of 3x61": (ball(60.0, 144, 288), {"grid": "3x61"}),
        "an even grid": (ball(60.0), {"grid": "30x26"}),
        "a ball of 60000 facets": (ball(60.0, 150, 200), {}),
        "a needle": (lathe(np.array([[0.0, 60.0], [4.0, 20.0], [30.0, 0.0], [0.0, 0.0]]), 24), {}),
        "a cone of 5 degrees": (
            lathe(np.array([[0.0, 60.0], [5.2, 0.0], [0.0, 0.0]]), 64),
            {"depth": "30mm"},
        ),
        "a flat cone of 80 degrees": (
            lathe(np.array([[0.0, 10.0], [60.0, 0.0], [0.0, -5.0]]), 64),
            {"depth": "9mm"},
        ),
        "a bowl with a rim": (
            lathe(np.array([[0.0, 0.0], [40.0, 20.0], [50.0, 20.0], [50.0, -30.0], [0.0, -30.0]]), 48),
            {},
        ),
        "a depth of 0.5 mm": (ball(60.0, 96, 96), {"depth": "0.5mm", "grid": "31x31"}),
        "as deep as is left": (ball(60.0, 96, 192), {"depth": "110mm"}),
        "an ellipsoid lying long": (ball(20.0, 48, 96).moved(np.diag([3.5, 0.8, 1.0])), {"depth": "30mm"}),
        "waves": (graph(waves, (70.0, 60.0), (90, 80), -60.0), {"depth": "30mm", "grid": "41x35"}),
        "stairs": (
            graph(lambda u, v: 10.0 * np.floor((u + 60.5) / 20.0), (60.0, 40.0), (60, 8), -60.0),
            {"depth": "40mm"},
        ),
        "friction of 2": (ball(60.0), {"friction": "2"}),
        "a hill that rubs a little": (MOLDS["hill"], {"friction": "0.05"}),
        "a hill that rubs much, in many steps": (MOLDS["hill"], {"friction": "0.6", "load_steps": "40"}),
        "a membrane that rubs on a hill": (MOLDS["hill"], {"friction": "0.25", "sheet": "membrane"}),
        "friction and one load step": (ball(60.0), {"friction": "0.3", "load_steps": "1"}),
        "weight of 20 kg/m^2": (ball(60.0), {"mass": "20 kg/m^2", "prestretch": "1.05"}),
        "mounted three times as large": (ball(60.0), {"prestretch": "3"}),
        "one edge held alone slides": (ball(60.0), {"clamp": "x-,x+,y-", "slide": "y+"}),
    }
    # In valleys as narrow as a few facets a node rests in one facet or the next: what that makes goes with their size.
    finer = {
        "waves": graph(waves, (70.0, 60.0), (180, 160), -60.0),
        "a hill that rubs a little": graph(skew, (75.0, 65.0), (180, 160), -20.0),
    }

    def mirrored(mold: Solid, options: dict[str, Any]) -> tuple[bool, float, str]:
        one, two = drape(mold, **options), drape(mold.moved(np.diag([1.0, -1.0, 1.0])), **options)
        whole, local = parted(one, two)
        return sound(one) and sound(two), max(whole, 0.05 * local), f"{told(one)} {whole:.1e} {local:.1e}"

    for name, (mold, options) in shapes.items():
        fine = finer.get(name)

        def rests(
            mold: Solid = mold, options: dict[str, Any] = options, fine: Solid | None = fine
        ) -> tuple[bool, object]:
            right, apart, words = mirrored(mold, options)
            if fine is None or apart < 1e-3:
                return right and apart < 1e-3, words
            finely, left, more = mirrored(fine, options)
            return right and finely and left < 0.1 * apart, f"{words}; facets half as long: {more}"

        hunt.case(f"rests, and mirrored too: {name}", rests)
    laws = {
        "gent near its limit": law("gent", mu_MPa=0.4, Jm=1.2),
        "arruda-boyce near its limit": law("arruda-boyce", mu_MPa=0.3, lambda_m=1.35),
        "ogden with a negative exponent": law("ogden-1", mu1_MPa=-0.2, alpha1=-4.0),
        "yeoh that softens first": law("yeoh-3", C10_MPa=0.2, C20_MPa=-0.03, C30_MPa=0.02),
        "mooney-rivlin of C01 alone": law("mooney-rivlin-2", C10_MPa=0.0, C01_MPa=0.2),
        "a weft of a hundredth": fabric(0.2, 0.002),
        "a law that is not stable": law("yeoh-3", C10_MPa=0.2, C20_MPa=-0.2, C30_MPa=0.0),
    }
    for name, cloth in laws.items():

        def obeys(cloth: str = cloth) -> tuple[bool, object]:
            one = drape(ball(60.0), cloth)
            named = one.status in (3, 4) and bool(one.said)
            return (sound(one) or named) and one.status != 70, told(one)

        hunt.case(f"rests or says why not: {name}", obeys)
    ends: dict[str, tuple[Solid, dict[str, Any], tuple[int, ...]]] = {
        "a sheet smaller than the mold": (ball(60.0), {"size": "60mmx60mm", "depth": "50mm"}, (3, 4)),
        "a mold at the clamped edge": (ball(100.0), {"depth": "99mm"}, (3, 4)),
        "mounted at half": (ball(60.0), {"prestretch": "0.5"}, (0, 4)),
        "one edge held alone": (ball(60.0), {"clamp": "x-"}, (0, 4)),
        "a mold of one facet": (
            Solid(np.array([[-30.0, -30, 0], [30, -30, 0], [0, 30, 5.0]]), np.array([[0, 1, 2]])),
            {"depth": "3mm"},
            (0, 3, 4),
        ),
        "a pin between the nodes": (
            lathe(np.array([[0.0, 60.0], [0.5, 59.0], [0.5, 0.0], [0.0, 0.0]]), 12),
            {"grid": "10x10"},
            (0, 4),
        ),
        "a sheet a metre long, 3 mm wide": (
            ball(60.0),
            {"size": "1mx3mm", "grid": "101x3", "clamp": "x-,x+"},
            (0, 4),
        ),
        "torn at just what it reaches": (ball(60.0), {"max_stretch": "1.0001"}, (1,)),
        "a wall thinner than the spacing": (
            graph(lambda u, v: 0.0 * u, (50.0, 1.0), (10, 1), -60.0),
            {},
            (0, 4),
        ),
        "a ball of 8 by 6 facets": (ball(60.0, 4, 6), {}, (0,)),
        "a depth of 1e-3 mm": (ball(60.0, 96, 96), {"depth": "0.001mm"}, (0, 4)),
        "a depth of 0": (ball(60.0), {"depth": "0mm"}, (0,)),
        "a tolerance of 1e-12": (ball(60.0), {"tolerance": "1e-12"}, (0, 4)),
    }
    for name, (mold, options, statuses) in ends.items():
        hunt.case(f"ends with a status of its own: {name}", partial(ended, mold, options, statuses))


def main() -> int:
    """Run the cases and count."""
    hunt = asked(sys.argv)
    for part in (invariances, membranes, balances, known):
        part(hunt)
    return hunt.ended("hf drape")


if __name__ == "__main__":
    raise SystemExit(main())
