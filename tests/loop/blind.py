"""Blind trials of fabrics: truths drawn at random, nothing declared, and what ``close`` calls them. ``make blind``
prints the table.

Run as ``PYTHONPATH=.:tests python -m loop.blind fabric [trials] [effect or effect+effect ...]``; deterministic for
given arguments. ``--poor`` takes one rate, one cycle, one direction, ``--other`` the second set of generators, whose
laws and protocols are others, ``--third``, ``--fourth``, ``--fifth`` and ``--sixth`` sets to which nothing is tuned
and whose plain laws are no model's, ``--smooth``, ``--foreign`` and ``--rough`` sets of such laws that names are
developed on.
``--next`` carries out the measurement that an ambiguous finding asks for, and beside it the old test once more;
``--without`` closes the loop again with the formula that was found taken out of the catalogue, as if it were a
stranger's.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from loop.generators import fabric as truths
from loop.generators import (
    fifth_fabric,
    foreign_fabric,
    fourth_fabric,
    other_fabric,
    rough_fabric,
    sixth_fabric,
    smooth_fabric,
    third_energy,
    third_fabric,
)

from hyperfab.curve import TestCurve
from hyperfab.loop.engine import Finding, close
from hyperfab.loop.fabric import FabricProblem, fabric_problem
from hyperfab.loop.fitting import fit
from hyperfab.loop.noise import Noise
from hyperfab.materials.registry import law

#: A fabric of any set, and what draws and measures those of another set than the first.
AnyTruth = (
    truths.Truth
    | other_fabric.Truth
    | third_energy.Truth
    | smooth_fabric.Truth
    | fourth_fabric.Truth
    | fifth_fabric.Truth
    | sixth_fabric.Truth
)
SETS: Mapping[str, Any] = {
    "other": other_fabric, "third": third_fabric, "rough": rough_fabric, "smooth": smooth_fabric,
    "fourth": fourth_fabric, "fifth": fifth_fabric, "sixth": sixth_fabric,
    "foreign": foreign_fabric,
}  # fmt: skip
#: Sets whose plain laws are no model's.
STRANGE = ("third", "rough", "smooth", "fourth", "fifth", "sixth", "foreign")

#: Pairs for the trials with two effects.
PAIRS = (
    "anisotropy+hysteresis", "rate+thermal-softening", "mullins+rate", "permanent-set+anisotropy",
    "hysteresis+thermal-softening", "grip-slack+rate", "elastic-law+mullins", "mullins+permanent-set",
)  # fmt: skip


def as_tests(readings: Sequence[truths.Reading]) -> list[TestCurve]:
    """Return the readings as the loop takes them: nothing of the truth goes along."""
    return [
        TestCurve(
            mode=reading.setup.mode,
            stretch=reading.stretch,
            stress=reading.stress,
            stretch2=reading.transverse,
            time_s=reading.time,
            temperature_degC=np.full_like(reading.stretch, reading.setup.temperature),
            direction=reading.setup.angle,
            source=f"test {number}",
            specimen=reading.specimen,
        )
        for number, reading in enumerate(readings)
    ]


def problem_of(readings: Sequence[truths.Reading], model: str = "yeoh-3") -> FabricProblem:
    """Return the problem an engineer would pose: a law with constants that are about right."""
    constants = {"yeoh-3": (0.1, 0.02, 0.01), "neo-hookean": (0.1,)}[model]
    return fabric_problem(law(model), constants, as_tests(readings))


def shown(clean: FabricProblem, noise: float) -> float:
    """Return how many times the noise readings are missed by once the constants are refitted, from ``clean`` ones."""
    sd = np.concatenate([np.full(len(clean.fabric.path.stretch), noise), np.full(len(clean.transverse_rows), 0.002)])
    base = fit(clean, Noise(sd, np.inf, "known"), {}, [one.value for one in clean.own])
    return float(np.sqrt(1.0 + base.chi2 / len(base.residual)))


def _measure_of(truth: AnyTruth) -> Callable[..., list[truths.Reading]]:
    """Return what reads the specimens of a truth of any set."""
    for which in SETS.values():
        if isinstance(truth, which.Truth):
            return which.measure  # type: ignore[no-any-return]
    return truths.measure


def case(
    seed: int, effects: Sequence[str], poor: bool, which: str = ""
) -> tuple[FabricProblem, float, AnyTruth, list[truths.Setup]]:
    """Return a problem whose effects raise the rms to 1.5 times the noise or more after the constants are refitted."""
    model = "neo-hookean" if "elastic-law" in effects else "yeoh-3"
    for attempt in range(50):
        random = np.random.default_rng([seed, attempt, sum(map(ord, "".join(effects)))])
        turn, rate = float(random.uniform(1.35, 1.7)), float(10.0 ** random.uniform(-2.3, -1.3))
        setups = (truths.poor if poor else truths.rich)(turn, rate, float(random.uniform(53.0, 90.0)))
        truth: AnyTruth
        if which:
            kinds = SETS[which].KINDS.get(effects[0], 1) if len(effects) == 1 else 0
            setups = SETS[which].protocol(random)
            truth = SETS[which].draw(random, effects, seed % kinds if kinds else None)
        else:
            truth = truths.draw(random, effects)
        measure = _measure_of(truth)
        clean = measure(truth, setups, np.random.default_rng(0), 0.0)
        top = max(float(np.max(reading.stress)) for reading in clean)
        noise = float(random.uniform(0.005, 0.02)) * top
        readings = measure(truth, setups, random, noise)
        if not effects:
            break
        if shown(problem_of(clean, model), noise) >= 1.5:
            return problem_of(readings, model), noise, truth, setups
    return problem_of(readings, model), noise, truth, setups


def label(found: Finding) -> str:
    """Return the verdict in a word or two."""
    if found.verdict == "effect":
        return "+".join(found.after.ids)
    if found.verdict == "ambiguous":
        return (
            "{"
            + ",".join(sorted({name for one in found.indistinguishable for name in one}))
            + "}"
            + "+".join(found.after.ids)
        )
    return found.verdict


def in_answer(name: str, found: Finding) -> bool:
    """Whether an effect is among those named or among their look-alikes."""
    return name in found.after.ids or any(name in one for one in found.indistinguishable)


def carried_out(
    problem: FabricProblem,
    details: Mapping[str, Any],
    truth: AnyTruth,
    noise: float,
    seed: int,
    points: int = 60,
) -> FabricProblem:
    """Return the problem with one more test, which the generator carries out on one more specimen."""
    setup = truths.Setup(
        mode=details["test"],
        angle=details["direction_deg"],
        rate=details["rate_1_s"],
        temperature=details["temperature_degC"],
        turns=tuple(details["stretch_turns"]),
        hold=details["hold_s"],
        points=points,
    )
    [new] = as_tests(_measure_of(truth)(truth, [setup], np.random.default_rng([seed, 99]), noise))
    tests = [*problem.tests, replace(new, source="the next test", specimen="the next")]
    return problem.remake(tests)


def without_its_formula(problem: FabricProblem, found: Finding) -> FabricProblem | None:
    """Return the problem with the forms that were found taken out, None where others would be lost with one."""
    forms = {name: form.name for name, form in found.after.fit.forms.items()}
    if any(form.free for form in found.after.fit.forms.values()):
        return None
    for name, one in forms.items():
        effect = problem.effect(name)
        if effect.form(one).refines is None and any(form.enriches(one) for form in effect.forms):
            return None
    left = (tuple(form for form in effect.forms if form.name != forms.get(effect.id)) for effect in problem.effects)
    pairs = zip(problem.effects, left, strict=True)
    return replace(problem, effects=tuple(replace(effect, forms=some or effect.forms) for effect, some in pairs))


def next_tally(
    found: Finding,
    problem: FabricProblem,
    drawn: AnyTruth,
    noise: float,
    setups: Sequence[truths.Setup],
    seed: int,
) -> Counter[str]:
    """Carry out the next measurement of an ambiguous finding, and beside it the old test once more."""
    tally: Counter[str] = Counter()
    if found.verdict != "ambiguous" or not found.measurements:
        return tally
    old = setups[0]
    again = {
        "test": old.mode,
        "direction_deg": old.angle,
        "temperature_degC": old.temperature,
        "rate_1_s": old.rate,
        "stretch_turns": old.turns,
        "hold_s": old.hold,
    }
    for what, details in (("next", found.measurements[0].details), ("repeat", again)):
        wider = close(carried_out(problem, details, drawn, noise, seed), design=False)
        tally[f"#{what} tests"] += 1
        right = set(wider.after.ids) == set(drawn.effects)
        tally[f"#{what} truth alone"] += wider.verdict == "effect" and right
        tally[f"#{what} truth first"] += wider.verdict in ("effect", "ambiguous") and (
            wider.after.ids[:1] == tuple(drawn.effects)[:1]
        )
    return tally


def table(
    effects: Sequence[Sequence[str]],
    trials: int,
    poor: bool = False,
    show: bool = False,
    which: str = "",
    design: bool = False,
    without: bool = False,
) -> dict[tuple[str, ...], Counter[str]]:
    """Run the trials and count the verdicts.

    ``design`` carries out the next measurement of ambiguous ones, ``without`` takes the found formulas out beforehand.
    """
    counts: dict[tuple[str, ...], Counter[str]] = {}
    for truth in effects:
        counts[tuple(truth)] = Counter()
        for seed in range(trials):
            problem, noise, drawn, setups = case(seed, truth, poor, which)
            if without:
                poorer = without_its_formula(problem, close(problem, design=False))
                if poorer is None:
                    continue
                problem = poorer
            began = time.process_time()
            counts[tuple(truth)]["#trials"] += 1
            found = close(problem, design=design)
            took = time.process_time() - began
            counts[tuple(truth)][label(found)] += 1
            tally = counts[tuple(truth)]
            named = found.verdict in ("effect", "ambiguous")
            tally["#named alone"] += found.verdict == "effect" and set(found.after.ids) == set(truth)
            # Where the plain law is no model's, elastic-law beside the truth is right too.
            beside = {"elastic-law"} if which in STRANGE else set()
            extra = set(found.after.ids) - set(truth)
            tally["#named, with the plain law"] += (
                found.verdict == "effect" and set(truth) <= set(found.after.ids) and extra <= beside
            )
            tally["#right or in the set"] += named and all(in_answer(name, found) for name in truth)
            tally["#one right"] += named and any(in_answer(name, found) for name in truth)
            if found.belief is not None:
                # Each probability that was stated, in its tenth, and whether it was right; of the plain law, where the
                # truth's is no model's, nobody knows.
                for name, stated in (*found.belief.of.items(), ("", found.belief.something_else)):
                    known = name in truths.IDS or name == ""
                    if known and (name not in beside or name in truth):
                        right = name in truth if name else bool(truth) and not set(truth) <= set(truths.IDS)
                        tenth = f"@{'name' if name else 'something else'} {min(int(10.0 * stated), 9)}"
                        tally[f"{tenth} n"] += 1
                        tally[f"{tenth} right"] += right
                        tally[f"{tenth} stated"] += round(1000.0 * stated)
            worse = found.after.fit.predicted, found.before.fit.predicted
            first = problem.channel == 0
            miss, was = (float(np.sum((problem.measured - one)[first] ** 2)) for one in worse)
            tally["#after > before"] += miss > was
            tally["#held out <= 1.2"] += bool(np.nanmean(found.after.held_out.residual**2) <= 1.44)
            tally["#wrong alone"] += found.verdict == "effect" and not any(in_answer(n, found) for n in truth)
            tally["#ms"] += round(1000.0 * took)
            tally["#slowest ms"] = max(tally["#slowest ms"], round(1000.0 * took))
            if design:
                tally.update(next_tally(found, problem, drawn, noise, setups, seed))
            tally["#spurious"] += (
                named and any(name not in truth for name in found.after.ids) and found.verdict == "effect"
            )
            if show:
                before, left = found.before.judgement.structured, found.after.judgement.structured
                kinds = [int(one["kind"]) for one in drawn.draws.values() if "kind" in one]
                print(
                    f"  {seed:3d} {'+'.join(truth) or 'none':24s} {label(found):50s} kinds {kinds}"
                    f" structure in sd: {before:.2f}, left {left:.2f}; {took:.1f} s",
                    flush=True,
                )
    return counts


def main() -> None:
    """Print the tables."""
    domain = sys.argv[1] if len(sys.argv) > 1 else "fabric"
    trials = int(sys.argv[2]) if len(sys.argv) > 2 else 20
    show = "--show" in sys.argv
    only = [word for word in sys.argv[3:] if not word.startswith("--")]
    if domain != "fabric":
        raise SystemExit(f"no blind trials for {domain} here: see loop.blind_{domain}")
    poor = "--poor" in sys.argv
    which = next((name for name in SETS if f"--{name}" in sys.argv), "")
    if "--two" in sys.argv:
        only = list(PAIRS)
    outside: Sequence[str] = SETS[which].OUTSIDE if which else truths.OUTSIDE
    if only:
        effects = [tuple(part for part in word.split("+") if part and part != "none") for word in only]
    else:
        effects = [(name,) for name in truths.IDS] + [()] + [(name,) for name in outside]
    whole: Counter[str] = Counter()
    stated: Counter[str] = Counter()
    found = table(effects, trials, poor, show, which, "--next" in sys.argv, "--without" in sys.argv)
    for truth, tally in found.items():
        counted = {key: value for key, value in tally.items() if key.startswith("#") and key != "#slowest ms"}
        stated.update({key: value for key, value in tally.items() if key.startswith("@")})
        if any(name in truths.IDS for name in truth):
            whole.update(counted)
        names = {key: value for key, value in tally.items() if key[0] not in "#@"}
        sums = ", ".join(f"{key[1:]} {value}" for key, value in tally.items() if key.startswith("#"))
        print(
            f"{'+'.join(truth) or 'none':28s} {sums} | "
            + ", ".join(f"{key} {value}" for key, value in Counter(names).most_common())
        )
    for what in ("name", "something else"):
        for tenth in (f"@{what} {number}" for number in range(10)):
            if count := stated[f"{tenth} n"]:
                mean, right = stated[f"{tenth} stated"] / 1000.0 / count, stated[f"{tenth} right"] / count
                print(f"{what}: stated {mean:.2f}, right {right:.2f} of {count}")
    print("effects of the catalogue together: " + ", ".join(f"{key[1:]} {n}" for key, n in whole.items()))


if __name__ == "__main__":
    main()
