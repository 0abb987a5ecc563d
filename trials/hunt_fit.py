"""Inputs chosen to break ``hf fit``, each judged by a truth that is known or by an invariance.

Run as ``PYTHONPATH=.:tests python -m trials.hunt_fit [part of a name]``: one line a case, status 1 if any is wrong.
Truths are the papers' energies in 50 digits (``tests/laws/laws_mp.py``), which share no line with the program.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
from laws.constants import CONSTANTS
from laws.laws_mp import energy
from laws.laws_mp import stress as exact

from hyperfab.errors import InputError
from hyperfab.materials import bind, laws
from hyperfab.materials.stability import Range, stable_ranges
from trials.hunting import Array, File, Hunt, Ran, asked, headed, hf, scaled, strained

STRETCH, STRESS = "stretch [-]", "stress [MPa]"
MODES = ("uniaxial", "shear", "biaxial")
REACH = {"uniaxial": 2.6, "shear": 2.3, "biaxial": 1.8}
#: Sets of options a file of force and extension needs.
SIZES = {"gauge length": "50 mm", "width": "10 mm", "thickness": "0.8 mm"}


def curve(name: str, parameters: Mapping[str, float], mode: str, stretch: Sequence[float], **head: str) -> File:
    """Return the file of a test of a known truth."""
    lam = np.asarray(stretch, float)
    stress = np.array([float(exact(name, parameters, mode, one)) for one in lam])
    return File({"test": mode, **head}, {STRETCH: lam, STRESS: stress})


def truth(name: str) -> dict[str, float]:
    """Return constants of a law of the size that rubber has."""
    return dict(zip(laws()[name].names, CONSTANTS[name], strict=True))


def exact_tests(name: str, count: int = 12, modes: Sequence[str] = MODES, **head: str) -> list[File]:
    """Return exact tests of a law in several modes."""
    return [curve(name, truth(name), mode, np.linspace(1.0, REACH[mode], count + 1)[1:], **head) for mode in modes]


def noisy(files: Sequence[File], seed: int, share: float) -> list[File]:
    """Return the files with errors of a share of each reading."""
    draw = np.random.default_rng(seed)
    return [one.with_stress(lambda p: p * (1.0 + share * draw.standard_normal(len(p)))) for one in files]


def fit(files: Sequence[File | str | bytes], *options: object) -> Ran:
    """Write the files, and fit them."""
    with tempfile.TemporaryDirectory() as folder:
        names = []
        for number, one in enumerate(files):
            path = Path(folder) / f"{number}.csv"
            data = one.text() if isinstance(one, File) else one
            path.write_bytes(data.encode() if isinstance(data, str) else data)
            names.append(path)
        return hf("fit", *names, *options)


def away(found: Mapping[str, float], wanted: Mapping[str, float]) -> float:
    """Return the largest relative difference of two sets of constants; infinite where they have other names."""
    if set(found) != set(wanted):
        return float("inf")
    scale = max(map(abs, wanted.values()))
    return max(abs(found[key] - value) / (abs(value) or scale) for key, value in wanted.items())


def moved(one: Ran, other: Ran) -> float:
    """Return how far apart the constants of two fits are, those of directions and temperatures too."""
    if one.document is None or other.document is None:
        return float("inf")
    pairs = [(one["parameters"], other["parameters"])]
    ways = [run.document.get("directions") or {} for run in (one, other)]
    if set(ways[0]) != set(ways[1]):
        return float("inf")
    pairs += [(ways[0][key]["parameters"], ways[1][key]["parameters"]) for key in ways[0]]
    tables = [run.document.get("temperatures") or [] for run in (one, other)]
    if len(tables[0]) != len(tables[1]):
        return float("inf")
    pairs += [(a["parameters"], b["parameters"]) for a, b in zip(*tables, strict=True)]
    return max(away(a, b) for a, b in pairs)


def lines(*rows: str) -> str:
    """Return a text of lines."""
    return "\n".join([*rows, ""])


def known(hunt: Hunt) -> None:
    """Exact readings give the constants back, also at the limits of the laws and from little."""

    def case(
        name: str, law: str, wanted: Mapping[str, float], files: Callable[[], list[File]], *options: object,
        tolerance: float = 1e-6,
    ) -> None:  # fmt: skip
        if not hunt.wanted(name):
            return
        ran = fit(files(), "--model", law, *options)
        off = away(ran["parameters"], wanted) if ran.document else float("inf")
        said = f"{off:.1e}" if ran.document else f"status {ran.status}: {ran.said.strip().splitlines()[-1][:100]}"
        hunt.judge(name, ran.status == 0 and off < tolerance, said)

    for name in CONSTANTS:
        # An upturn that 12 readings see in the seventh digit cannot come back to six digits.
        loose = {"mooney-rivlin-9": 1e-5, "carroll": 1e-5, "ogden-3": 1e-4, "alexander": 1e-5}.get(name, 1e-6)
        case(f"{name}: three modes", name, truth(name), lambda n=name: exact_tests(n), tolerance=loose)  # type: ignore[misc]
    for name in ("yeoh-3", "gent", "ogden-1", "arruda-boyce-langevin", "mooney-rivlin-2"):
        case(f"{name}: biaxial alone", name, truth(name), lambda n=name: exact_tests(n, 9, ["biaxial"]))  # type: ignore[misc]
    count = {"neo-hookean": 2, "gent": 2, "yeoh-3": 3, "ogden-1": 2, "mooney-rivlin-5": 5}
    for name, rows in count.items():
        modes = MODES if rows > 3 else MODES[:1]
        case(
            f"{name}: {rows} rows", name, truth(name),
            lambda n=name, r=rows, m=modes: exact_tests(n, -(-r // len(m)), m), tolerance=1e-5,  # type: ignore[misc]
        )  # fmt: skip
    limits: dict[str, tuple[str, dict[str, float], Sequence[float]]] = {
        "readings at 0.99 of Gent's limit": ("gent", {"mu_MPa": 0.2, "Im": 5.0}, np.linspace(1.05, 2.64, 15)),
        "readings at 0.9999 of Gent's limit": ("gent", {"mu_MPa": 0.2, "Im": 1.0}, np.linspace(1.05, 1.6180, 15)),
        "a limit that no reading comes near": ("gent", {"mu_MPa": 0.2, "Im": 2e3}, np.linspace(1.05, 2.0, 15)),
        "a limit of 1.02": ("gent", {"mu_MPa": 3.0, "Im": 2e-3}, np.linspace(1.002, 1.0253, 15)),
        "a power of 25": ("ogden-1", {"mu1_MPa": 0.02, "alpha1": 25.0}, np.linspace(1.01, 1.3, 15)),
        "a power of -20": ("ogden-1", {"mu1_MPa": -0.02, "alpha1": -20.0}, np.linspace(0.7, 1.3, 16)),
        "a power of 0.05": ("ogden-1", {"mu1_MPa": 9.0, "alpha1": 0.05}, np.linspace(1.05, 3.0, 15)),
        "two powers alike": ("ogden-2", {"mu1_MPa": 0.3, "alpha1": 1.5, "mu2_MPa": 0.1, "alpha2": 3.0},
                             np.linspace(1.05, 4.0, 30)),
        "chains of 1.2": ("arruda-boyce-langevin", {"mu_MPa": 0.2, "lambda_m": 1.2}, np.linspace(1.02, 1.6, 15)),
        "compression alone": ("yeoh-2", {"C10_MPa": 0.3, "C20_MPa": 0.05}, np.linspace(0.4, 0.98, 15)),
        "through rest": ("yeoh-3", {"C10_MPa": 0.2, "C20_MPa": -0.02, "C30_MPa": 0.004}, np.linspace(0.6, 2.0, 16)),
        "strains of a thousandth": ("neo-hookean", {"C10_MPa": 40.0}, np.linspace(1.0001, 1.001, 10)),
        "a stretch of 12": ("yeoh-3", {"C10_MPa": 0.2, "C20_MPa": -1e-3, "C30_MPa": 1e-5}, np.linspace(1.5, 12, 20)),
        "Poisson's ratio zero nearly": ("blatz-ko-general", {"mu_MPa": 0.2, "f": 0.4, "nu": 0.02},
                                        np.linspace(0.6, 1.6, 16)),
        "Poisson's ratio a half nearly": ("blatz-ko-general", {"mu_MPa": 0.2, "f": 0.4, "nu": 0.49},
                                          np.linspace(0.6, 1.6, 16)),
    }  # fmt: skip
    for label, (name, wanted, stretch) in limits.items():
        modes = MODES if name.startswith("blatz") else MODES[:1]
        case(
            label, name, wanted,
            lambda n=name, w=wanted, s=stretch, m=modes: [curve(n, w, one, s) for one in m], tolerance=1e-5,  # type: ignore[misc]
        )  # fmt: skip
    for power in (-4, 3):
        wanted = {"C10_MPa": 0.2 * 10.0**power, "C20_MPa": 0.01 * 10.0**power}
        case(
            f"a stiffness of 1e{power} MPa", "yeoh-2", wanted,
            lambda w=wanted: [curve("yeoh-2", w, "uniaxial", np.linspace(1.1, 2.0, 9))],  # type: ignore[misc]
        )  # fmt: skip


WAYS: dict[str, tuple[Callable[[list[File]], list[Any]], tuple[object, ...]]] = {
    "order of files reversed": (lambda f: f[::-1], ()),
    "order of rows reversed": (lambda f: [one.rows(slice(None, None, -1)) for one in f], ()),
    "order of rows drawn": (
        lambda f: [one.rows(np.random.default_rng(4).permutation(len(one.columns[STRETCH]))) for one in f], (),
    ),
    "each file in two": (
        lambda f: [part for one in f for part in (one.rows(slice(0, 5)), one.rows(slice(5, None)))], (),
    ),
    "kPa": (lambda f: [scaled(STRESS, 1e3, "stress [kPa]")(one) for one in f], ()),
    "psi": (lambda f: [scaled(STRESS, 1.0 / 6.894757293168361e-3, "stress [psi]")(one) for one in f], ()),
    "strain in percent": (lambda f: [strained(one) for one in f], ()),
    "true stress": (lambda f: [true_stress(one) for one in f], ()),
    "force and extension in mm": (lambda f: [machine(one, 1.0, "mm") for one in f], ()),
    "force and extension in inches": (lambda f: [machine(one, 1 / 25.4, "in") for one in f], ()),
    "membrane stress and its thickness": (
        lambda f: [scaled(STRESS, 0.8, "membrane stress [N/mm]")(one) for one in f], ("--thickness", "0.8mm"),
    ),
    "semicolons and decimal commas": (lambda f: [one.text().replace(",", ";").replace(".", ",") for one in f], ()),
    "UTF-16": (lambda f: [one.text().encode("utf-16") for one in f], ()),
    "Windows line ends": (lambda f: [one.text().replace("\n", "\r\n") for one in f], ()),
    "a column that nobody knows": (
        lambda f: [replace(one, columns={**one.columns, "Kanal 7 [V]": one.columns[STRETCH] * 4.2}) for one in f], (),
    ),
    "a row at rest more": (lambda f: [with_rest(one) for one in f], ()),
    "tests named in the order of fit-on": (lambda f: f, ("--fit-on", "biaxial,uniaxial,shear")),
    "biaxial told as general": (lambda f: [general(one) for one in f], ()),
    "temperature in fahrenheit": (lambda f: [headed(temperature="73.4 degF")(one) for one in f], ()),
}  # fmt: skip


def true_stress(one: File) -> File:
    """Return the file with Cauchy stress: nominal over the section left, that of a sheet that keeps its volume."""
    return one.with_columns(
        lambda key, v: ("true stress [MPa]", v * one.columns[STRETCH]) if key == STRESS else (key, v)
    )


def machine(one: File, per_mm: float, unit: str) -> File:
    """Return the file as force and extension of a specimen whose sizes are stated; a disc pulled both ways too."""
    if one.head["test"] == "biaxial":
        return one
    found = {
        f"extension [{unit}]": 50.0 * (one.columns[STRETCH] - 1.0) * per_mm,
        "force [N]": one.columns[STRESS] * 8.0,
    }
    return File({**one.head, **SIZES}, found)


def with_rest(one: File) -> File:
    """Return the file with a first row at rest."""
    return one.with_columns(lambda key, v: (key, np.concatenate([[1.0 if key == STRETCH else 0.0], v])))


def general(one: File) -> File:
    """Return an equal biaxial test with both axes read."""
    if one.head["test"] != "biaxial":
        return one
    both = {**one.columns, "stretch 2 [-]": one.columns[STRETCH], "stress 2 [MPa]": one.columns[STRESS]}
    return File({**one.head, "test": "biaxial-general"}, both)


def invariances(hunt: Hunt) -> None:
    """The same readings told otherwise: the constants must not change."""
    for law in ("yeoh-3", "ogden-2"):
        base = noisy(exact_tests("gent-gent", 14, temperature="23 degC"), 3, 0.02)
        plain: Ran | None = None
        for label, (way, options) in WAYS.items():
            name = f"{law}: {label}"
            if not hunt.wanted(name):
                continue
            plain = plain or fit(base, "--model", law)
            reference = plain
            if label == "biaxial told as general":
                # Two stresses a row count twice: so do the rows of an equal biaxial test given twice over.
                reference = fit([*base, headed(specimen="again")(base[2])], "--model", law)
            ran = fit(way(base), "--model", law, *options)
            off = moved(ran, reference)
            hunt.judge(name, off < 1e-6, f"{off:.1e}" if ran.document else ran.said.strip().splitlines()[-1][:110])


def lycra(weft: float = 0.6, share: float = 0.01, seed: int = 2, **head: str) -> list[File]:
    """Return noisy strips of a fabric along warp and weft, three specimens each."""
    draw, found = np.random.default_rng(seed), []
    for way, gain in (("warp", 1.0), ("weft", weft)):
        for number in range(3):
            plain = curve("yeoh-2", {"C10_MPa": 0.1, "C20_MPa": 0.03}, "uniaxial", np.linspace(1.02, 1.6, 15))
            stiffer = gain * (1.0 + 0.02 * draw.standard_normal())
            read = plain.with_stress(lambda p, k=stiffer: p * k * (1.0 + share * draw.standard_normal(len(p))))
            found.append(headed(direction=way, specimen=f"{way}{number}", **head)(read))
    return found


def swapped(one: File) -> File:
    """Return the file with warp called weft."""
    return headed(direction="warp" if one.head["direction"] == "weft" else "weft")(one)


def same_ways(one: Ran, other: Ran, across: bool = False, factor: float = 1.0) -> float:
    """Return how far the stresses of two fabrics are apart in each direction, through their constants in MPa."""
    ways = ("warp", "weft")
    found = []
    for way in ways:
        b = other["directions"][ways[1 - ways.index(way)] if across else way]["parameters"]
        a = one["directions"][way]["parameters"]
        found.append(away(b, {key: v * (factor if key.endswith("_MPa") else 1.0) for key, v in a.items()}))
    return max(found)


def directions(hunt: Hunt) -> None:
    """Two directions: turned, scaled, shuffled; each alone is what it is together."""
    for law in ("yeoh-2", "gent", "orthotropic", "fabric-fibres"):
        if not hunt.wanted(f"{law}: two ways"):
            continue
        base = lycra()
        plain = fit(base, "--model", law)
        loose = 1e-5 if law in ("orthotropic", "fabric-fibres") else 1e-8
        turned = same_ways(plain, fit([swapped(one) for one in base], "--model", law), across=True)
        hunt.judge(f"{law}: two ways, warp called weft", turned < loose, f"{turned:.1e}")
        stiff = same_ways(
            plain, fit([one.with_stress(lambda p: 300.0 * p) for one in base], "--model", law), factor=300.0
        )
        hunt.judge(f"{law}: two ways, 300 times as stiff", stiff < loose, f"{stiff:.1e}")
        drawn = [base[k] for k in np.random.default_rng(8).permutation(len(base))]
        order = same_ways(plain, fit(drawn, "--model", law))
        hunt.judge(f"{law}: two ways, files in another order", order < loose, f"{order:.1e}")
        degrees = fit([headed(direction="0" if one.head["direction"] == "warp" else "90 deg")(one) for one in base],
                      "--model", law)  # fmt: skip
        hunt.judge(
            f"{law}: two ways, told in degrees",
            same_ways(plain, degrees) < loose,
            f"{same_ways(plain, degrees):.1e}",
        )
        if law in ("yeoh-2", "gent"):
            alone = fit(base[:3], "--model", law)
            off = away(alone["parameters"], plain["directions"]["warp"]["parameters"])
            hunt.judge(f"{law}: two ways, the warp alone", off < loose, f"{off:.1e}")


def warmth(hunt: Hunt) -> None:
    """Temperatures: units, order, odd ones, and tests a few kelvin apart."""
    name = "temperatures"
    if not hunt.wanted(name):
        return

    def at(*degrees: float, unit: str = "degC") -> list[File]:
        found = []
        for t in degrees:
            wanted = {
                "C10_MPa": 0.2 * np.exp(-0.004 * (t - 23.0)),
                "C20_MPa": 0.01 * np.exp(-0.004 * (t - 23.0)),
            }
            read = curve("yeoh-2", wanted, "uniaxial", np.linspace(1.05, 1.8, 12))
            told = {"degC": t, "K": t + 273.15, "degF": 1.8 * t + 32.0}[unit]
            found.append(headed(temperature=f"{told:.6g} {unit}")(read))
        return found

    plain = fit(at(23, 60, 105), "--model", "yeoh-2")
    for unit in ("K", "degF"):
        off = moved(plain, fit(at(23, 60, 105, unit=unit), "--model", "yeoh-2"))
        hunt.judge(f"{name}: in {unit}", off < 1e-6, f"{off:.1e}")
    off = moved(plain, fit(at(105, 23, 60), "--model", "yeoh-2"))
    hunt.judge(f"{name}: in another order", off < 1e-10, f"{off:.1e}")
    for label, degrees in {"from -60 to 220": (-60, 0, 220), "none near room": (150, 180)}.items():
        ran = fit(at(*degrees), "--model", "yeoh-2")
        off = max(
            abs(row["parameters"]["C10_MPa"] / (0.2 * np.exp(-0.004 * (row["temperature_degC"] - 23.0))) - 1.0)
            for row in ran["temperatures"]
        )
        hunt.judge(f"{name}: {label}", off < 1e-9, f"{off:.1e}")
    # Each is within 4 K of the next, the ends are not: whatever is done, it is said, and no test counts as another's.
    ran = fit(at(20, 24, 28, 32, 36, 40), "--model", "yeoh-2")
    told = len(ran.document.get("temperatures") or []) > 1 or "temperature" in " ".join(
        ran.document.get("warnings") or []
    )
    hunt.judge(
        f"{name}: six tests 4 K apart",
        told,
        [row["temperature_degC"] for row in ran.document.get("temperatures") or []],
    )
    # A test that is heated as it is pulled has no one temperature.
    warm = at(23)[0]
    ramp = replace(warm, head={k: v for k, v in warm.head.items() if k != "temperature"},
                   columns={**warm.columns, "temperature [degC]": np.linspace(20.0, 80.0, 12)})  # fmt: skip
    ran = fit([ramp], "--model", "yeoh-2")
    said = (
        [text for text in ran.document.get("warnings") or [] if "temperature" in text] if ran.document else [ran.said]
    )
    hunt.judge(f"{name}: heated while it is pulled", bool(said), said[:1] or ran["temperature_degC"])
    for text in ("-300 degC", "0 K", "5000 degC"):
        read = headed(temperature=text)(at(23)[0])
        ran = fit([read], "--model", "yeoh-2")
        hunt.judge(
            f"{name}: {text}",
            ran.status == 3 or "temperature" in ran.said,
            f"{ran.status} {ran.said.strip()[:90]}",
        )


def choice(hunt: Hunt) -> None:
    """``--model all``: the law chosen hangs neither on units, nor on the order of files, nor on stiffness."""
    name = "all laws"
    if not hunt.wanted(name):
        return
    for seed, modes in enumerate((MODES, ("uniaxial",), ("shear", "biaxial"))):
        base = noisy(exact_tests("gent-gent", 12, modes), seed, 0.02)
        plain = fit(base, "--model", "all")
        ways: dict[str, tuple[list[File], float]] = {
            "another order": (base[::-1] if len(base) > 1 else [base[0].rows(slice(None, None, -1))], 1.0),
            "kPa": ([scaled(STRESS, 1e3, "stress [kPa]")(one) for one in base], 1.0),
            "50 times as stiff": ([one.with_stress(lambda p: 50.0 * p) for one in base], 50.0),
        }
        for label, (files, factor) in ways.items():
            ran = fit(files, "--model", "all")
            ranks = [[row["model"] for row in run["models"]] for run in (plain, ran)]
            wanted = {k: v * (factor if k.endswith("_MPa") else 1.0) for k, v in plain["parameters"].items()}
            carry = [[row.get("carry_over") or 0.0 for row in run["models"]] for run in (plain, ran)]
            near = bool(np.allclose(carry[0], carry[1], rtol=1e-4))
            # Laws that do equally well may stand in either order.
            same = ran["model"] == plain["model"] and away(ran["parameters"], wanted) < 1e-5 and near
            hunt.judge(
                f"{name}: {'+'.join(modes)}, {label}",
                same,
                f"{plain['model']} | {ran['model']}, {ranks[0] == ranks[1]}",
            )


def certainty(hunt: Hunt) -> None:
    """How sure constants are: in the units of the constants, whatever the order, the names or the number of rows."""
    name = "certainty"
    if not hunt.wanted(name):
        return
    base = lycra()[:3]
    plain = fit(base, "--model", "yeoh-2")

    def spread(ran: Ran) -> Array:
        return np.array(ran["fit"]["uncertainty"]["covariance"])

    ways: dict[str, tuple[list[File], float, float]] = {
        "another order": (base[::-1], 1.0, 1e-9),
        "100 times as stiff": ([one.with_stress(lambda p: 100.0 * p) for one in base], 1e4, 1e-9),
        "kPa": ([scaled(STRESS, 1e3, "stress [kPa]")(one) for one in base], 1.0, 1e-9),
        "specimens called otherwise": (
            [headed(specimen=f"Probe {9 - k}")(one) for k, one in enumerate(base)],
            1.0,
            1e-9,
        ),
        # Rows say nothing of how specimens scatter.
        "every row twice": ([one.rows(np.repeat(np.arange(15), 2)) for one in base], 1.0, 1e-9),
    }
    for label, (files, factor, tolerance) in ways.items():
        ran = fit(files, "--model", "yeoh-2")
        off = float(np.abs(spread(ran) / (factor * spread(plain)) - 1.0).max())
        free = ran["fit"]["uncertainty"]["degrees_of_freedom"] == 2
        hunt.judge(f"{name}: {label}", off < tolerance and free, f"{off:.1e}")
    # A law linear in its constants, one weight for all rows: the sd is that of the specimens' own constants.
    flat = fit(base, "--model", "neo-hookean", "--objective", "absolute")
    each = [fit([one], "--model", "neo-hookean", "--objective", "absolute")["parameters"]["C10_MPa"] for one in base]
    wanted = float(np.std(each, ddof=1) / np.sqrt(3.0))
    off = abs(flat["fit"]["parameters_sd"]["C10_MPa"] / wanted - 1.0)
    hunt.judge(f"{name}: that of the specimens' own constants", off < 1e-6, f"{off:.1e}")


def weights(hunt: Hunt) -> None:
    """Objectives, limits and the noise of a reading: by their definitions."""
    name = "weights"
    if not hunt.wanted(name):
        return
    base = noisy(exact_tests("gent", 14, MODES), 5, 0.03)
    stress = np.concatenate([one.columns[STRESS] for one in base])

    def model(ran: Ran) -> Array:
        return np.concatenate(
            [
                [float(exact(ran["model"], ran["parameters"], one.head["test"], lam)) for lam in one.columns[STRETCH]]
                for one in base
            ]
        )

    for law in ("yeoh-3", "ogden-2", "gent"):
        for kind in ("relative", "absolute"):
            ran = fit(base, "--model", law, "--objective", kind)
            error = 1.0 - model(ran) / stress
            E2, nrmse = float(error @ error), float(np.sqrt(np.mean((error * stress) ** 2)) / stress.max())
            off = max(abs(ran["fit"]["E2"] / E2 - 1.0), abs(ran["fit"]["nrmse"] / nrmse - 1.0))
            hunt.judge(f"{name}: {law}, {kind}, its figures", off < 1e-9, f"{off:.1e}")
            # No constants nearby do better.
            goal = (lambda e: float(e @ e)) if kind == "relative" else (lambda e: float((e * stress) @ (e * stress)))
            draw, best = np.random.default_rng(1), goal(error)
            beaten = []
            for size in (1e-2, 1e-4):
                for _ in range(6):
                    near = {key: v * (1.0 + size * draw.standard_normal()) for key, v in ran["parameters"].items()}
                    beaten.append(goal(1.0 - model(Ran(0, {"model": law, "parameters": near}, "")) / stress) < best)
            hunt.judge(
                f"{name}: {law}, {kind}, none nearby better",
                not any(beaten),
                f"{sum(beaten)} of {len(beaten)}",
            )
    plain = fit(base, "--model", "yeoh-3", "--noise", "0.01MPa")
    off = moved(
        plain,
        fit(
            [scaled(STRESS, 1e3, "stress [kPa]")(one) for one in base],
            "--model",
            "yeoh-3",
            "--noise",
            "10kPa",
        ),
    )
    hunt.judge(f"{name}: noise in kPa", off < 1e-9, f"{off:.1e}")
    column = [replace(one, columns={**one.columns, "stress sd [MPa]": np.full(14, 0.01)}) for one in base]
    off = moved(plain, fit(column, "--model", "yeoh-3"))
    hunt.judge(f"{name}: noise in a column", off < 1e-9, f"{off:.1e}")
    flat = fit(base, "--model", "yeoh-3", "--objective", "absolute")
    off = moved(flat, fit(base, "--model", "yeoh-3", "--objective", "absolute", "--noise", "0.02MPa"))
    hunt.judge(f"{name}: one noise for all in an absolute fit", off < 1e-9, f"{off:.1e}")
    rms = fit(base, "--model", "neo-hookean")["fit"]["relative_rms"]
    for factor, status in ((1.000001, 0), (0.999999, 1)):
        ran = fit(base, "--model", "neo-hookean", "--accept", f"{factor * rms:.12g}")
        hunt.judge(f"{name}: accepted to {factor} of its error", ran.status == status, ran.status)


def prepared(hunt: Hunt) -> None:
    """Cycles, branches, slack and zero: what is taken out leaves what was put in."""
    name = "prepared"
    if not hunt.wanted(name):
        return
    up = np.linspace(1.02, 1.7, 18)
    wanted = {"C10_MPa": 0.15, "C20_MPa": 0.02}
    one = curve("yeoh-2", wanted, "uniaxial", up)
    P = one.columns[STRESS]

    def judged(label: str, file: File, *options: object, tolerance: float = 1e-9) -> None:
        ran = fit([file], "--model", "yeoh-2", *options)
        off = away(ran["parameters"], wanted) if ran.document else np.inf
        hunt.judge(
            f"{name}: {label}",
            off < tolerance,
            f"{off:.1e} {ran.said.strip()[:60] if off >= tolerance else ''}",
        )

    loop = {STRETCH: np.concatenate([up, up[::-1][1:]]), STRESS: np.concatenate([P, 0.6 * P[::-1][1:]])}
    judged("loading of a loop", File(one.head, loop), "--branch", "load")
    cycles = {key: np.concatenate([v, v * (1.0 if key == STRETCH else 0.8), v * (1.0 if key == STRETCH else 0.7)])
              for key, v in loop.items()}  # fmt: skip
    judged("first loading of three cycles", File(one.head, cycles), "--branch", "load", "--cycle", "first")
    third = File(one.head, {k: v / (1.0 if k == STRETCH else 0.7) for k, v in cycles.items()})
    judged("last loading of three cycles", third, "--branch", "load", "--cycle", "last")
    offset = File(one.head, {STRETCH: np.concatenate([[1.0], up]), STRESS: np.concatenate([[0.0], P]) + 0.02})
    judged("an offset of the load cell", offset, "--zero")
    sized = {"gauge length": "50 mm", "width": "10 mm", "thickness": "1 mm"}
    slack = File({**one.head, **sized}, {
        "extension [mm]": np.concatenate([np.linspace(0, 2.9, 6), 53.0 * np.concatenate([[1.0], up]) - 50.0]),
        "force [N]": np.concatenate([np.zeros(6), [0.0], 10.0 * P]),
    })  # fmt: skip
    # The strip is 53 mm long where it begins to carry.
    judged("slack taken out by a preload", slack, "--preload", "1e-6 N", tolerance=1e-4)
    fine = curve("yeoh-2", wanted, "uniaxial", np.linspace(1.02, 1.7, 400))
    judged("dense rows averaged", fine, "--resample", "40", tolerance=2e-3)
    doubled = File(one.head, {key: np.repeat(v, 3) for key, v in one.columns.items()})
    judged("every row three times", doubled)


def refused(hunt: Hunt) -> None:
    """What cannot be meant ends with status 2 or 3 and says why; never a defect, never constants."""
    head = f"{STRETCH},{STRESS}"
    bad: dict[str, tuple[str | bytes, tuple[object, ...]]] = {
        "an empty file": ("", ()),
        "a head alone": (lines("# test: uniaxial", head), ()),
        "a stretch below zero": (lines("# test: uniaxial", head, "1.1,0.1", "-1.2,0.2", "1.3,0.3"), ()),
        "a stretch of zero": (lines("# test: uniaxial", head, "0,0.1", "1.2,0.2", "1.3,0.3"), ()),
        "a cell that says nan": (lines("# test: uniaxial", head, "1.1,0.1", "1.2,nan", "1.3,0.3"), ()),
        "a cell beyond all numbers": (lines("# test: uniaxial", head, "1.1,0.1", "1.2,1e999", "1.3,0.3"), ()),
        "no stress in any row": (lines("# test: uniaxial", head, "1.1,0", "1.2,0", "1.3,0"), ()),
        "one stretch in all rows": (lines("# test: uniaxial", head, "1.2,0.1", "1.2,0.2", "1.2,0.3"), ()),
        "zeros and ones": (bytes(range(256)) * 4, ()),
        "a stress without a unit": (lines("# test: uniaxial", "stretch [-],stress", "1.1,0.1", "1.2,0.2"), ()),
        "stress given twice": (lines("# test: uniaxial", f"{head},{STRESS}", "1.1,0.1,0.2", "1.2,0.2,0.3"), ()),
        "a test nobody knows": (lines("# test: torsion", head, "1.1,0.1", "1.2,0.2"), ()),
        "more constants than rows": (lines("# test: uniaxial", head, "1.1,0.1", "1.2,0.2"), ("--model", "yeoh-3")),
        "a fit on a test not there": (lines("# test: uniaxial", head, "1.1,0.1", "1.2,0.2"), ("--fit-on", "shear")),
        "stress against the stretch": (lines("# test: uniaxial", head, "1.1,-0.1", "1.2,-0.2", "1.3,-0.3"), ()),
    }  # fmt: skip
    for label, (text, options) in bad.items():
        name = f"refused: {label}"
        if hunt.wanted(name):
            ran = fit([text], *options)
            good = ran.status in (2, 3) and ran.document is None
            hunt.judge(name, good, f"{ran.status} {ran.said.strip().splitlines()[-1][:100] if ran.said else ''}")


def least(name: str, parameters: Mapping[str, float], l1: float, l2: float) -> float:
    """Return the smaller over the larger eigenvalue of the energy's second derivatives by the logarithmic strains."""
    step, one, two = mp.mpf(10) ** -12, mp.log(mp.mpf(l1)), mp.log(mp.mpf(l2))

    def at(i: int, j: int) -> Any:
        return energy(name, parameters, mp.exp(one + i * step), mp.exp(two + j * step))

    try:
        d11, d22 = at(1, 0) + at(-1, 0) - 2 * at(0, 0), at(0, 1) + at(0, -1) - 2 * at(0, 0)
        d12 = (at(1, 1) + at(-1, -1) - at(1, -1) - at(-1, 1)) / 4
        if any(mp.im(d) for d in (d11, d22, d12)):
            return np.nan
        d11, d22, d12 = (mp.re(d) for d in (d11, d22, d12))
        middle, radius = (d11 + d22) / 2, mp.hypot((d11 - d22) / 2, d12)
        return float((middle - radius) / (abs(middle) + radius))
    except (ValueError, ZeroDivisionError):  # beyond the law's limit there is no energy
        return np.nan


def misjudged(name: str, parameters: Mapping[str, float], mode: str, told: Range) -> list[float]:
    """Return stretches at which the range told is not what the energy's second derivatives say."""
    nu = parameters["nu"] if name.startswith("blatz") else 0.5
    inside = np.geomspace(max(told.low, 0.3), min(told.high, 6.0), 42)[1:-1]
    ends = [told.high * 1.001] if told.ended_by == "instability" else []
    ends += [told.low * 0.999] if told.low > 0.21 else []

    def at(lam: float) -> float:
        return least(name, parameters, lam, {"uniaxial": lam**-nu, "shear": 1.0, "biaxial": lam}[mode])

    return [lam for lam in inside if not at(lam) > -1e-6] + [lam for lam in ends if at(lam) > 1e-4]


def stability(hunt: Hunt) -> None:
    """The stable range of each mode, of constants of any size and sign, by the second derivatives of the energy."""
    draw = np.random.default_rng(5)
    for name, usual in CONSTANTS.items():
        said: list[str] = []
        for _ in range(5):
            own = np.array(usual) * 10.0 ** draw.uniform(-1.0, 1.0, len(usual)) * draw.choice([1, 1, -1], len(usual))
            parameters = dict(zip(laws()[name].names, map(float, own), strict=True))
            # The reference's error function of an imaginary argument is not told for k below zero.
            if not hunt.wanted(f"stability: {name}") or parameters.get("k", 1.0) < 0.0:
                continue
            try:
                ranges = stable_ranges(bind(name, parameters))
            except InputError:
                continue
            said += [f"{parameters} {mode} {wrong}" for mode, told in ranges.items()
                     if (wrong := misjudged(name, parameters, mode, told))]  # fmt: skip
        if hunt.wanted(f"stability: {name}"):
            hunt.judge(f"stability: {name}", not said, said[:1])


def main() -> None:
    """Run the cases and count."""
    hunt = asked(sys.argv)
    known(hunt)
    invariances(hunt)
    for part in (directions, warmth, choice, certainty, weights, prepared, stability, refused):
        part(hunt)
    raise SystemExit(hunt.ended("fit"))


if __name__ == "__main__":
    main()
