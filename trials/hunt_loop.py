"""Inputs chosen to break ``hf close-loop`` on fabrics, each judged by an invariance or by a truth that is known.

Run as ``PYTHONPATH=.:tests python -m trials.hunt_loop [part of a name]``: one line a case, status 1 if any is wrong.
Files go the way a user's do: written, read, looked at, posed and closed.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from loop.generators import fabric as truths
from numpy.typing import NDArray

from hyperfab.chapters.close_loop.domain import How
from hyperfab.chapters.close_loop.fabric import pose
from hyperfab.chapters.close_loop.measured_tests import read_measured
from hyperfab.chapters.job import Job
from hyperfab.console import Console
from hyperfab.documents.base import parse_document
from hyperfab.documents.material import MaterialDocument
from hyperfab.errors import HyperfabError
from hyperfab.io.layout import PLAIN
from hyperfab.loop.engine import Finding, close
from hyperfab.materials.modes import OF_A_SHEET
from trials.hunting import File, Hunt, asked, headed, scaled, strained

Array = NDArray[np.float64]
GIVEN = {"C10_MPa": 0.1, "C20_MPa": 0.02, "C30_MPa": 0.01}


@dataclass(frozen=True)
class Closed:
    """A finding, or why there is none, and what was told of the files."""

    found: Finding | None
    told: Sequence[str] = ()
    refused: str = ""
    left_out: int = 0

    @property
    def names(self) -> tuple[str, frozenset[str]]:
        """The verdict and what was named or stands beside it."""
        if self.found is None:
            return self.refused, frozenset()
        sets = {name for one in self.found.indistinguishable for name in one}
        return self.found.verdict, frozenset({*self.found.after.ids, *sets})

    @property
    def rms(self) -> float:
        """What is left, in MPa."""
        assert self.found is not None
        problem, fit = self.found.after.problem, self.found.after.fit
        first = problem.channel == 0
        return float(np.sqrt(np.mean((problem.measured - fit.predicted)[first] ** 2)))


def closed(files: Sequence[File], model: Mapping[str, float] | None = None, **more: object) -> Closed:
    """Write the files and close the loop on them."""
    with tempfile.TemporaryDirectory() as folder:
        names = []
        for number, one in enumerate(files):
            path = Path(folder) / f"{number}.csv"
            path.write_text(one.text())
            names.append(str(path))
        document = {
            "format": "hyperfab.material/1",
            "model": "yeoh-3",
            "parameters": dict(model or GIVEN),
            **more,
        }
        job = Job("close-loop", [], Console(quiet=True))
        try:
            tests = read_measured(job, names, PLAIN, None, {}, How(), OF_A_SHEET)
            problem = pose(parse_document(document, "m.json", MaterialDocument), "m.json", tests)
            found = close(problem, design=False)
        except HyperfabError as error:
            return Closed(None, refused=str(error))
        return Closed(found, tests.warnings, left_out=sum(tests.left_out.values()))


def files(
    effects: tuple[str, ...],
    seed: int = 1,
    setups: Sequence[truths.Setup] | None = None,
    noise: float = 0.004,
) -> list[File]:
    """Return the files of a fabric that nobody declared."""
    random = np.random.default_rng([seed, len(effects)])
    truth = truths.draw(random, effects)
    read = truths.measure(truth, setups or truths.rich(1.5, 0.01, 60.0), random, noise)
    return [
        File(
            {
                "test": one.setup.mode, "direction": "weft" if one.setup.angle else "warp",
                "temperature": f"{one.setup.temperature} degC", "specimen": one.specimen,
            },
            {"time [s]": one.time, "stretch [-]": one.stretch, "stress [MPa]": one.stress},
        )
        for one in read
    ]  # fmt: skip


def swapped(one: File) -> File:
    """Return the file with warp called weft."""
    return headed(direction="warp" if one.head["direction"] == "weft" else "weft")(one)


def later(one: File) -> File:
    """Return the file with a clock that began a thousand seconds earlier."""
    return one.with_columns(lambda key, v: (key, v + 1000.0) if key.startswith("time") else (key, v))


def same(one: Closed, other: Closed, tolerance: float) -> bool:
    """Whether two findings say the same, and leave the same."""
    return one.names == other.names and abs(one.rms - other.rms) <= tolerance * max(one.rms, 1e-12)


def invariances(hunt: Hunt) -> None:
    """The same readings told otherwise: order, units, names, clocks and columns must not change the answer."""
    ways: dict[str, tuple[Callable[[list[File]], list[File]], float]] = {
        "order of files reversed": (lambda f: f[::-1], 1e-4),
        "order of files drawn": (lambda f: [f[i] for i in np.random.default_rng(3).permutation(len(f))], 1e-4),
        "kPa": (lambda f: [scaled("stress [MPa]", 1e3, "stress [kPa]")(one) for one in f], 1e-5),
        "strain in percent": (lambda f: [strained(one) for one in f], 1e-5),
        "time in minutes": (lambda f: [scaled("time [s]", 1 / 60.0, "time [min]")(one) for one in f], 1e-4),
        "clock begins later": (lambda f: [later(one) for one in f], 1e-4),
        "specimens called otherwise": (
            lambda f: [headed(specimen=f"Probe {9 - i}")(one) for i, one in enumerate(f)], 1e-6,
        ),
        "temperature in kelvin": (
            lambda f: [
                headed(temperature=f"{float(one.head['temperature'].split()[0]) + 273.15:.2f} K")(one) for one in f
            ],
            1e-4,
        ),
        "an unknown column that is constant": (
            lambda f: [
                replace(one, columns={**one.columns, "Channel 7 [V]": np.full(len(one.columns["time [s]"]), 4.2)})
                for one in f
            ],
            1e-6,
        ),
        "a file once more under a note": (lambda f: [*f, headed(note="again")(f[0])], 1e-6),
        "no time where the rate is said": (
            lambda f: [
                replace(one, columns={k: v for k, v in one.columns.items() if not k.startswith("time")}) for one in f
            ],
            np.inf,
        ),
    }  # fmt: skip
    for effects in (("thermal-softening",), ("anisotropy",), ()):
        label = "+".join(effects) or "none"
        base = files(effects)
        told = None
        for name, (way, tolerance) in ways.items():
            full = f"{label}: {name}"
            if not hunt.wanted(full):
                continue
            told = told or closed(base)
            new = closed(way(base))
            hunt.judge(
                full,
                same(told, new, tolerance),
                f"{told.names[0]} {sorted(told.names[1])} | {new.names[0]} {sorted(new.names[1])}",
            )
    for factor in (0.3, 3.0):
        full = f"anisotropy: the model's constants times {factor}"
        if hunt.wanted(full):
            base = files(("anisotropy",))
            one, other = closed(base), closed(base, {key: factor * value for key, value in GIVEN.items()})
            hunt.judge(full, same(one, other, 1e-3), other.names)
    for name, effects in (("mirrored", ("anisotropy",)), ("mirrored", ("thermal-softening",))):
        full = f"{effects[0]}: warp and weft {name}"
        if hunt.wanted(full):
            base = files(effects)
            one, other = closed(base), closed([swapped(f) for f in base])
            hunt.judge(full, one.names[1] == other.names[1] and one.names[0] == other.names[0], other.names)
    full = "thermal-softening: another reference temperature"
    if hunt.wanted(full):
        base = files(("thermal-softening",))
        one, other = closed(base), closed(base, temperature_degC=60.0)
        hunt.judge(full, same(one, other, 1e-3), other.names)
    full = "thermal-softening: a hundred times stiffer"
    if hunt.wanted(full):
        base = files(("thermal-softening",))
        one = closed(base)
        other = closed([f.with_stress(lambda p: 100.0 * p) for f in base], {k: 100.0 * v for k, v in GIVEN.items()})
        hunt.judge(full, one.names == other.names and abs(other.rms / one.rms - 100.0) < 0.1, other.names)


def known(hunt: Hunt) -> None:
    """Truths that are known: what must, or must not, be named."""

    def pulls(gains: Sequence[float], heads: Sequence[Mapping[str, str]], noise: float = 0.002) -> list[File]:
        setups = [truths.Setup(turns=(1.5,), rate=0.01) for _ in gains]
        made = files((), seed=7, setups=setups, noise=noise)
        return [
            replace(one.with_stress(lambda p, g=g: g * p), head={**one.head, **head})
            for one, g, head in zip(made, gains, heads, strict=True)
        ]  # type: ignore[misc]

    def never_worse(one: Closed) -> bool:
        if one.found is None:
            return False
        first = one.found.after.problem.channel == 0
        measured = one.found.after.problem.measured[first]
        old, new = (measured - state.fit.predicted[first] for state in (one.found.before, one.found.after))
        return float(new @ new) <= float(old @ old) * (1.0 + 1e-9)

    def case(name: str, made: Callable[[], list[File]], good: Callable[[Closed], bool]) -> None:
        if hunt.wanted(name):
            one = closed(made())
            judged = one.found is None or never_worse(one)
            hunt.judge(name, judged and good(one), one.names if one.found else one.refused[:90])

    plain = lambda n: pulls([1.0] * n, [{"specimen": str(k)} for k in range(n)])  # noqa: E731
    clean = lambda one: one.names == ("noise", frozenset())  # noqa: E731
    for share in (0.1, 0.2, 0.4):
        case(
            f"a spike of {share:.0%} in one of three", lambda s=share: [  # type: ignore[misc]
                *plain(2), plain(3)[2].with_stress(lambda p: p + s * p.max() * (np.arange(len(p)) == 30)),
            ], lambda one: not one.names[1] and (one.left_out == 1 or one.names[0] == "unexplained"),
        )  # fmt: skip
    for drop in (0.02, 0.05):

        def slipped(one: File, drop: float = drop) -> File:
            return one.with_columns(
                lambda key, v: (key, v - drop * (np.arange(len(v)) >= 40)) if key.startswith("stretch") else (key, v)
            )

        case(f"the extensometer slips by {drop}", lambda s=slipped: [s(one) for one in plain(3)], clean)  # type: ignore[misc]
    case(
        "a load cell at the end of its range",
        lambda: [one.with_stress(lambda p: np.minimum(p, 0.8 * p.max())) for one in plain(3)],
        lambda one: "elastic-law" not in one.names[1],
    )
    case(
        "rows that stand twice",
        lambda: [one.rows(np.repeat(np.arange(len(one.columns["time [s]"])), 2)) for one in plain(2)],
        clean,
    )  # type: ignore[arg-type]
    case(
        "four rows a test",
        lambda: [one.rows(slice(0, None, 19)) for one in plain(6)],
        lambda one: one.found is None or one.found.noise.source.startswith("assumed"),
    )
    case("one curve alone", lambda: plain(1), lambda one: one.names[0] == "noise")
    case(
        "one loop alone, softened",
        lambda: files(("mullins",), setups=[truths.Setup(turns=(1.5, 1.0))]),
        lambda one: one.names[0] in ("ambiguous", "unexplained"),
    )
    case(
        "a replica without noise",
        lambda: [*plain(3), *pulls([1.0], [{"specimen": "ideal"}], noise=0.0)],
        clean,
    )
    for size in (0.02, 0.05):
        gains = 1.0 + size * np.random.default_rng(5).standard_normal(6)
        case(
            f"replicates that scatter by {size:.0%}",
            lambda g=gains: pulls(list(g), [{"specimen": str(k)} for k in range(6)]),
            clean,
        )  # type: ignore[misc]
    gains = 1.0 + 0.015 * np.random.default_rng(6).standard_normal(8)
    heads = [
        {"direction": d, "temperature": f"{t} degC", "specimen": f"{d}{t}"}
        for d in ("warp", "weft")
        for t in (20, 40, 60, 80)
    ]
    case(
        "specimens scatter, none tested twice",
        lambda: pulls(list(gains), heads, noise=3e-4),
        lambda one: one.names[0] == "noise",
    )
    # Williams, Landel and Ferry's shift from 60 K below, as stiffness: no formula of the catalogue.
    degrees = (-50, -30, -10, 20, 50, 80)
    glass = [float(10.0 ** (-0.25 * 17.44 * (t + 110.0) / (51.6 + t + 110.0) + 2.9)) for t in degrees]
    warm = [{"temperature": f"{t} degC", "specimen": f"{t}"} for t in (-50, -30, -10, 20, 50, 80)]
    case(
        "from glass to rubber, one test a temperature",
        lambda: pulls(glass, warm),
        lambda one: "thermal-softening" in one.names[1],
    )
    case(
        "from glass to rubber, two tests a temperature",
        lambda: pulls([*glass, *glass], [*warm, *({**h, "specimen": h["specimen"] + "b"} for h in warm)]),
        lambda one: "thermal-softening" in one.names[1],
    )
    for weft in (0.1, 0.25, 0.8):
        case(
            f"a biaxial sheet, fibres across {weft}",
            lambda w=weft: biaxial(w),
            lambda one: one.names[0] != "noise" and "anisotropy" in one.names[1],
        )  # type: ignore[misc]
    case(
        "a biaxial sheet alike both ways",
        lambda: biaxial(0.0, 0.0),
        lambda one: "anisotropy" not in one.names[1],
    )
    offset = lambda: [one.with_stress(lambda p: p + 0.02) for one in files((), seed=2)]  # noqa: E731
    case("every reading off by the same", offset, lambda one: "load-offset" in one.names[1])
    wet = [{"humidity": f"{h} %", "specimen": str(h)} for h in (35, 45, 55, 65)]
    case(
        "humidity that no law knows",
        lambda: pulls([1.2, 1.05, 0.95, 0.8], wet),
        lambda one: any("humidity" in text for text in one.told),
    )
    for name in ("rate", "hysteresis", "mullins", "permanent-set", "grip-slack", "compressibility"):
        closer = [replace(one, points=120) for one in truths.rich(1.5, 0.01, 60.0)]
        case(
            f"{name} read by twice as many rows",
            lambda n=name, s=closer: files((n,), setups=s),  # type: ignore[misc]
            lambda one, n=name: n in one.names[1],  # type: ignore[misc]
        )


def biaxial(weft: float, warp: float = 0.4) -> list[File]:
    """Return a sheet with fibres along warp and weft, pulled by three protocols, twice each, both axes read."""
    rng, found = np.random.default_rng(1), []
    pull = np.linspace(0.0, 0.2, 40)
    for protocol, (x, y) in {"x": (1.0, 0.0), "y": (0.0, 1.0), "both": (1.0, 1.0)}.items():
        for number in range(2):
            lx, ly = (1.0 + on * pull + 0.01 * pull * (not on) for on in (x, y))
            lz = 1.0 / (lx * ly)
            px = 0.4 * (lx - lz**2 / lx) + 4.0 * warp * (lx**2 - 1.0) * lx + 1e-3 * rng.standard_normal(40)
            py = 0.4 * (ly - lz**2 / ly) + 4.0 * weft * (ly**2 - 1.0) * ly + 1e-3 * rng.standard_normal(40)
            head = {"test": "biaxial-general", "direction": "warp", "specimen": f"{protocol}{number}"}
            found.append(File(head, {"stretch [-]": lx, "stress [MPa]": px, "stretch 2 [-]": ly, "stress 2 [MPa]": py}))
    return found


def main() -> None:
    """Run the cases and count."""
    hunt = asked(sys.argv)
    invariances(hunt)
    known(hunt)
    raise SystemExit(hunt.ended("close-loop"))


if __name__ == "__main__":
    main()
