"""Inputs chosen to break ``hf fabric-contact``, each judged by another solution or by an invariance.

Run as ``PYTHONPATH=.:tests python -m trials.hunt_contact [part of a name]``: one line a case, status 1 if any is wrong.
Forces on discs are known by shooting (``tests/membrane/axisymmetric.py``), which shares no line with the program.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from membrane.axisymmetric import pressed_disc

from trials.hunting import Array, Hunt, Ran, asked, hf

#: As rough as the question allows: the estimate of the error says when it is too rough.
ROUGH: Mapping[str, str] = {"depth": "40mm", "steps": "1", "tolerance": "1e-3"}


def fabric(model: str = "neo-hookean", **parameters: float) -> dict[str, Any]:
    """Return a material document, neo-Hookean of 0.2 MPa where nothing is said."""
    return {"format": "hyperfab.material/1", "model": model, "parameters": parameters or {"C10_MPa": 0.2}}


def two_ways(warp: float, weft: float) -> dict[str, Any]:
    """Return a fabric whose directions differ."""
    ways = {name: {"parameters": {"C10_MPa": c, "C20_MPa": 0.1 * c}} for name, c in (("warp", warp), ("weft", weft))}
    return {**fabric("yeoh-2", C10_MPa=0.5 * (warp + weft), C20_MPa=0.05 * (warp + weft)), "directions": ways}


def press(
    sheet: Mapping[str, Any], against: Mapping[str, Any] | None = None, files: Mapping[str, str] | None = None,
    **options: str,
) -> Ran:  # fmt: skip
    """Press a sheet; options as on the command line, ``mesh_size="5mm"``."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        (path / "a.json").write_text(json.dumps(sheet))
        words: list[object] = ["fabric-contact", path / "a.json"]
        if against is not None:
            (path / "b.json").write_text(json.dumps(against))
            words += ["--against", path / "b.json"]
        for name, text in (files or {}).items():
            (path / name).write_text(text)
        for key, value in {**ROUGH, **options}.items():
            words += [f"--{key.replace('_', '-')}", path / value if value in (files or {}) else value]
        return hf(*words)


def told_last(ran: Ran) -> str:
    """Return the last warning or error of a run."""
    return next((line[:100] for line in ran.said.splitlines()[::-1] if line.startswith("hf: ")), "")


def sound(ran: Ran) -> bool:
    """Whether a result keeps the laws that any result must: work and forces balance, nothing unstable in silence."""
    balance = ran["balance"]
    return (
        ran["converged"] is True
        and abs(balance["force_imbalance_relative"]) < 1e-6
        and abs(balance["imbalance_relative"]) < 5e-3
        and ran["stretch_max"] >= 1.0
    )


def forces(hunt: Hunt) -> None:
    """Forces and energies against shooting: depths, spheres and sheets of all sizes."""
    cases: dict[str, tuple[dict[str, str], dict[str, float]]] = {
        "as shallow as allowed": ({"depth": "0.2mm"}, {"depth": 0.2}),
        "a hundredth of the size": ({"depth": "2mm"}, {"depth": 2.0}),
        "deep": ({"depth": "75mm", "steps": "3"}, {"depth": 75.0}),
        "a small sphere": ({"depth": "10mm", "sphere_radius": "5mm"}, {"depth": 10.0, "radius": 5.0}),
        "the smallest sphere": ({"depth": "2mm", "sphere_radius": "1mm"}, {"depth": 2.0, "radius": 1.0}),
        "a sphere as wide as the sheet": (
            {"depth": "30mm", "sphere_radius": "100mm"}, {"depth": 30.0, "radius": 100.0},
        ),
        "a sphere nearly flat": ({"depth": "2mm", "sphere_radius": "1000mm"}, {"depth": 2.0, "radius": 1000.0}),
        "ten times as large": (
            {"depth": "400mm", "sphere_radius": "400mm", "size": "2m"},
            {"depth": 400.0, "radius": 400.0, "rim": 1000.0},
        ),
        "a tenth as large": (
            {"depth": "4mm", "sphere_radius": "4mm", "size": "20mm"}, {"depth": 4.0, "radius": 4.0, "rim": 10.0},
        ),
        "the smallest sheet": (
            {"depth": "0.3mm", "sphere_radius": "0.3mm", "size": "1.5mm"}, {"depth": 0.3, "radius": 0.3, "rim": 0.75},
        ),
        "in inches": ({"depth": "1in", "sphere_radius": "2in", "size": "8in"},
                      {"depth": 25.4, "radius": 50.8, "rim": 101.6}),
        "as thin as a soap film": ({"thickness": "1e-6mm"}, {"depth": 40.0, "thickness": 1e-6}),
        "as thick as a plank": ({"thickness": "50mm"}, {"depth": 40.0, "thickness": 50.0}),
        "a clamp that gives": ({"rim_slip": "5mm^2/N"}, {"depth": 40.0, "rim_slip": 5.0}),
    }  # fmt: skip
    for label, (options, told) in cases.items():
        name = f"force: {label}"
        if not hunt.wanted(name):
            continue
        ran = press(fabric(), **options)
        wanted = None
        # Where shooting begins; where it ends is its own.
        guess = (ran["stretch_max"], ran["contact_radius_undeformed_mm"])
        for pole, edge in (guess, (1.0 + 0.9 * (guess[0] - 1.0), 0.97 * guess[1])):
            try:
                found = pressed_disc(**told, guess=(pole, edge))
            except (ValueError, RuntimeError):
                continue
            if np.isfinite(found).all() and found[0] > 0.0:
                wanted = found
                break
        if wanted is None:
            print(f"     {name}: shooting found nothing", flush=True)
            continue
        off = abs(ran["force_N"] / wanted[0] - 1.0) if ran.document else np.inf
        stored = abs(ran["balance"]["stored_J"] / (1e-3 * wanted[2]) - 1.0) if ran.document else np.inf
        # Shooting counts the clamp's own energy, as the sheet's document does.
        hunt.judge(
            name,
            bool(off < 1e-3 and stored < 1e-3) and sound(ran),
            f"{off:.1e} {stored:.1e} {told_last(ran)}",
        )


def same_laws(hunt: Hunt) -> None:
    """Laws that are one law: the same force, stretch and stress on the same mesh."""
    kin: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
        "Yeoh without its powers": (fabric(), fabric("yeoh-3", C10_MPa=0.2, C20_MPa=0.0, C30_MPa=0.0)),
        "Ogden's power of two": (fabric(), fabric("ogden-1", mu1_MPa=0.4, alpha1=2.0)),
        "Gent without a limit": (fabric(), fabric("gent", mu_MPa=0.4, Im=1e9)),
        "Arruda-Boyce without a limit": (fabric(), fabric("arruda-boyce", mu_MPa=0.4, lambda_m=1e5)),
        "Mooney as Ogden": (
            fabric("mooney-rivlin-2", C10_MPa=0.15, C01_MPa=0.05),
            fabric("ogden-2", mu1_MPa=0.3, alpha1=2.0, mu2_MPa=-0.1, alpha2=-2.0),
        ),
        "directions alike": (fabric("yeoh-2", C10_MPa=0.2, C20_MPa=0.02), two_ways(0.2, 0.2)),
        "a table of one temperature": (fabric(), {**fabric(), "temperature_degC": 23.0}),
    }  # fmt: skip
    for label, (one, other) in kin.items():
        name = f"same law: {label}"
        if not hunt.wanted(name):
            continue
        ran = press(one, other)
        off = abs(ran["force_ratio"] - 1.0) if ran.document else np.inf
        away = ran["stress_difference_percent"] if ran.document else np.inf
        hunt.judge(name, bool(off < 1e-6 and away < 1e-3), f"{off:.1e} {away:.1e} % {told_last(ran)}")


def ratios(hunt: Hunt) -> None:
    """What a change of the input must do to the force, by dimension or by symmetry."""

    @cache
    def plain() -> Ran:
        return press(fabric())

    @cache
    def square() -> Ran:
        return press(two_ways(0.3, 0.1), shape="square")

    def case(
        label: str, first: Callable[[], Ran], made: Callable[[], Ran], factor: float, tolerance: float = 2e-3
    ) -> None:
        name = f"ratio: {label}"
        if not hunt.wanted(name):
            return
        base, ran = first(), made()
        off = abs(ran["force_N"] / (factor * base["force_N"]) - 1.0) if ran.document else np.inf
        same = off < tolerance and ran["stability"]["stable"] == base["stability"]["stable"]
        hunt.judge(name, bool(same) and sound(ran), f"{off:.1e} {told_last(ran)}")

    case("a thousand times as stiff", plain, lambda: press(fabric(C10_MPa=200.0)), 1000.0, 1e-9)
    case("a millionth as stiff", plain, lambda: press(fabric(C10_MPa=2e-7)), 1e-6, 1e-9)
    case("seven steps", plain, lambda: press(fabric(), steps="7"), 1.0)
    case("a finer mesh", plain, lambda: press(fabric(), mesh_size="4mm"), 1.0)
    case("the coarsest mesh", plain, lambda: press(fabric(), mesh_size="33mm"), 1.0)
    case("straight elements", plain, lambda: press(fabric(), element="P1"), 1.0, 4e-3)
    case("a tolerance of 1e-5", plain, lambda: press(fabric(), tolerance="1e-5"), 1.0)
    case("a prestretch of next to nothing", plain, lambda: press(fabric(), prestretch="1.000001"), 1.0)
    case("a rim that gives next to nothing", plain, lambda: press(fabric(), rim_slip="1e-6mm^2/N"), 1.0)
    case("friction of next to nothing", plain, lambda: press(fabric(), friction="1e-6"), 1.0)
    case("warp called weft", square, lambda: press(two_ways(0.1, 0.3), shape="square"), 1.0)
    case("two ways, twice as stiff", square, lambda: press(two_ways(0.6, 0.2), shape="square"), 2.0, 1e-6)
    case("two ways, ten times as large", square, lambda: press(
        two_ways(0.3, 0.1), shape="square", size="2m", sphere_radius="400mm", depth="400mm"), 10.0, 1e-6)  # fmt: skip
    turn = np.linspace(0.0, 2.0 * np.pi, 361)[:-1]
    ring = np.column_stack([100.0 * np.cos(turn), 100.0 * np.sin(turn)])
    box = np.array([[-100.0, -100.0], [100.0, -100.0], [100.0, 100.0], [-100.0, 100.0]])
    case(
        "a disc from a file",
        plain,
        lambda: press(fabric(), files={"o.csv": points(ring)}, shape="o.csv"),
        1.0,
    )
    case(
        "the other way round",
        plain,
        lambda: press(fabric(), files={"o.csv": points(ring[::-1])}, shape="o.csv"),
        1.0,
    )
    case("begun elsewhere, moved and scaled", plain, lambda: press(
        fabric(), files={"o.csv": points(np.roll(0.1 * ring, 77, axis=0) + 300.0)}, shape="o.csv", size="200mm"),
        1.0)  # fmt: skip
    case(
        "a square from a file",
        square,
        lambda: press(two_ways(0.3, 0.1), files={"o.csv": points(box)}, shape="o.csv"),
        1.0,
    )
    case("a square's edges in ten parts", square, lambda: press(
        two_ways(0.3, 0.1), files={"o.csv": points(divided(box, 10))}, shape="o.csv"), 1.0)  # fmt: skip
    case("a ball of facets", plain, lambda: press(fabric(), files={"ball.stl": ball(40.0, 48)}, punch="ball.stl",
                                                  tolerance="1e-2"), 1.0, 2e-2)  # fmt: skip
    case("a ball of facets in inches", plain, lambda: press(
        fabric(), files={"ball.stl": ball(40.0 / 25.4, 48)}, punch="ball.stl", stl_unit="in", tolerance="1e-2"),
        1.0, 2e-2)  # fmt: skip


def points(rows: Array) -> str:
    """Return an outline as a table."""
    return "\n".join(["x [mm],y [mm]", *(f"{x!r},{y!r}" for x, y in rows.tolist()), ""])


def divided(corners: Array, count: int) -> Array:
    """Return the outline with each edge in ``count`` parts."""
    share = np.arange(count)[:, None] / count
    following = np.roll(corners, -1, axis=0)
    return np.concatenate([a + share * (b - a) for a, b in zip(corners, following, strict=True)])


def ball(radius: float, count: int) -> str:
    """Return the upper part of a sphere as STL."""
    polar, around = np.linspace(0.0, 0.7 * np.pi, count), np.linspace(0.0, 2.0 * np.pi, 4 * count + 1)
    place = radius * np.stack(
        [np.outer(np.sin(polar), np.cos(around)), np.outer(np.sin(polar), np.sin(around)),
         np.outer(np.cos(polar), np.ones_like(around))], axis=-1,
    )  # fmt: skip
    place[:, -1] = place[:, 0]
    place[0] = [0.0, 0.0, radius]
    facets = []
    for i in range(count - 1):
        for j in range(4 * count):
            a, b, c, d = place[i, j], place[i + 1, j], place[i + 1, j + 1], place[i, j + 1]
            facets += [(a, b, c)] + ([(a, c, d)] if i else [])
    bottom = np.array([0.0, 0.0, place[-1, 0, 2]])
    facets += [(place[-1, j + 1], place[-1, j], bottom) for j in range(4 * count)]
    lines = [
        "facet normal 0 0 0\nouter loop\n"
        + "\n".join(f"vertex {x!r} {y!r} {z!r}" for x, y, z in np.array(one).tolist())
        + "\nendloop\nendfacet"
        for one in facets
    ]
    return "\n".join(["solid ball", *lines, "endsolid ball", ""])


def bounds(hunt: Hunt) -> None:
    """What lies between what: sheets within sheets, friction, slack, and comparisons turned round."""
    name = "bound"
    if not hunt.wanted(name):
        return
    plain = press(fabric())
    force = plain["force_N"]
    square = press(fabric(), shape="square")["force_N"]
    around = press(fabric(), size="282.8427mm")["force_N"]
    hunt.judge(
        f"{name}: a square between its two circles",
        force > square > around,
        f"{force:.4g} {square:.4g} {around:.4g}",
    )
    rubbed = [press(fabric(), friction=mu)["force_N"] for mu in ("0.1", "0.5", "2")]
    stuck = press(fabric(), friction="stick")["force_N"]
    rising = bool((np.diff([force, *rubbed]) > 0.0).all()) and stuck >= 0.995 * rubbed[-1]
    hunt.judge(f"{name}: friction makes it stiffer, up to stick", rising, [round(one, 3) for one in (*rubbed, stuck)])
    pulls = [press(fabric(), prestretch=s)["force_N"] for s in ("0.8", "0.95", "1.2", "2")]
    order = pulls[0] < pulls[1] < force < pulls[2] < pulls[3]
    hunt.judge(f"{name}: tauter is stiffer", order, [round(one, 3) for one in pulls])
    loose = press(fabric(), prestretch="0.5", depth="10mm")
    nothing = loose.status == 0 and loose["force_N"] == 0.0 and loose["energy_J"] < 1e-9
    hunt.judge(
        f"{name}: a sheet that hangs slack carries nothing",
        nothing,
        f"{loose.status} {loose.said.strip()[-80:]}",
    )
    other = fabric("yeoh-2", C10_MPa=0.25, C20_MPa=0.05)
    there, back = press(fabric(), other), press(other, fabric())
    turned = abs(there["force_ratio"] * back["force_ratio"] - 1.0)
    scale = there["stress_max_MPa"] * there["stress_difference_percent"]
    off = abs(scale / (back["stress_max_MPa"] * back["stress_difference_percent"]) - 1.0)
    hunt.judge(f"{name}: A against B, B against A", turned < 1e-3 and off < 2e-2, f"{turned:.1e} {off:.1e}")
    alone = press(fabric(), fabric())
    hunt.judge(
        f"{name}: against itself",
        alone["stress_difference_percent"] == 0.0 and alone["force_ratio"] == 1.0,
        "",
    )


def limits(hunt: Hunt) -> None:
    """Laws at their limits and inputs without a meaning: a result that holds, or a status with words."""
    laws_at_limits: dict[str, tuple[dict[str, Any], dict[str, str], tuple[int, ...]]] = {
        "chains that lock on the way": (fabric("gent", mu_MPa=0.4, Im=0.02), {}, (0, 4)),
        "chains that lock just beyond": (fabric("gent", mu_MPa=0.4, Im=0.35), {}, (0,)),
        "a power of 25": (fabric("ogden-1", mu1_MPa=0.01, alpha1=25.0), {}, (0,)),
        "a power of -20": (fabric("ogden-1", mu1_MPa=-0.01, alpha1=-20.0), {}, (0, 4)),
        "softening until it gives way": (fabric("yeoh-2", C10_MPa=0.2, C20_MPa=-0.15), {"depth": "70mm"}, (4,)),
        "a foam": (fabric("blatz-ko", mu_MPa=0.4, f=0.0, nu=0.25), {}, (0, 4)),
        "no stiffness at rest": (fabric("yeoh-2", C10_MPa=-0.01, C20_MPa=0.1), {}, (3,)),
        "nothing at all": (fabric(C10_MPa=0.0), {}, (3,)),
        "one way thirty times as stiff": (two_ways(3.0, 0.1), {"shape": "square", "depth": "20mm"}, (0,)),
        "a sphere that strikes the clamp": (fabric(), {"sphere_radius": "150mm", "depth": "80mm"}, (2,)),
        "a depth beyond the sheet": (fabric(), {"depth": "500mm"}, (2,)),
        "a depth of nothing": (fabric(), {"depth": "0mm"}, (2,)),
        "a mesh of one element": (fabric(), {"mesh_size": "150mm"}, (2,)),
        "a depth without a unit": (fabric(), {"depth": "40"}, (2,)),
    }  # fmt: skip
    for label, (sheet, options, statuses) in laws_at_limits.items():
        name = f"limit: {label}"
        if not hunt.wanted(name):
            continue
        ran = press(sheet, **options)
        good = ran.status in statuses and (ran.status == 0 or bool(ran.said.strip()))
        if ran.status == 0:
            good &= sound(ran)
        hunt.judge(name, good, f"{ran.status} {ran.said.strip().splitlines()[-1][:110] if ran.said.strip() else ''}")


def main() -> None:
    """Run the cases and count."""
    hunt = asked(sys.argv)
    for part in (forces, same_laws, ratios, bounds, limits):
        part(hunt)
    raise SystemExit(hunt.ended("fabric-contact"))


if __name__ == "__main__":
    main()
