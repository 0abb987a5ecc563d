"""Plant small defects in the program, one at a time, and look whether a test notices: ``make mutants``.

The draw is the same each time: of every package so many, by a hash of where each defect stands, so that a change
elsewhere moves nothing. A defect is shown to the tests that reach it until one fails. One that no test notices is
either equivalent (``equivalent.toml`` says why) or asks for a test.
"""

from __future__ import annotations

import argparse
import fcntl
import json
import os
import shutil
import signal
import sys
import time
import tomllib
from collections import Counter
from pathlib import Path

from trials.mutants import reach, tree
from trials.mutants.selection import Program, Selection
from trials.mutants.sites import Mutant, is_python, mutants

#: How many are drawn of which files; the last are twice a figure that a document tells.
STRATA = {
    "materials": 28, "membrane": 24, "cloth": 28, "thermal": 28, "pressing": 22, "surface": 8, "numerics": 6,
    "loop": 26, "io": 20, "figures": 24,
}  # fmt: skip
#: Tests that are not asked: they time, interrupt or drive other programs.
IGNORED = ("tests/faults/", "tests/report/test_browser.py", "tests/test_packaging.py")
#: CPU seconds that compiling the kernels a defect may stand in takes at most.
_COMPILES = 240.0


def drawn(root: Path, scale: float = 1.0) -> list[tuple[str, Mutant]]:
    """The defects of this draw, each with its stratum: at most two of a function."""
    found: list[tuple[str, Mutant]] = []
    for stratum, count in STRATA.items():
        figures = stratum == "figures"
        folders = ("chapters", "loop", "materials", "io", "thermal", "membrane") if figures else (stratum,)
        all_of_it = {
            mutant.name: mutant  # two of one name stand in statements that read alike
            for folder in folders
            for file in sorted((root / "hyperfab" / folder).glob("**/*.py"))
            for mutant in mutants(root, file.relative_to(root).as_posix(), figures)
        }
        taken: Counter[str] = Counter()
        here: list[Mutant] = []
        for _, mutant in sorted(all_of_it.items()):
            at = f"{mutant.path} {mutant.function}"
            if len(here) == round(scale * count):
                break
            if taken[at] < 2 and is_python(root, mutant):
                taken[at] += 1
                here.append(mutant)
        found += [(stratum, mutant) for mutant in sorted(here, key=lambda mutant: (mutant.path, mutant.start))]
    return found


def near(mutants: list[Mutant]) -> tuple[str, ...]:
    """Where the tests of the packages stand in which these defects are: their own, and every example."""
    packages = {mutant.path.split("/")[1] for mutant in mutants}
    more = {"tests/laws/"} if "materials" in packages else set()
    return ("hyperfab/", *sorted(more | {f"tests/{package}/" for package in packages}))


def mapped(root: Path, copy: Path, work: Path, fresh: bool, wanted: tuple[str, ...]) -> dict[str, dict[str, object]]:
    """What each test reaches: as kept, with tests of changed files under ``wanted`` run again."""
    kept = work / "reach.json"
    known: dict[str, dict[str, object]] = (
        json.loads(kept.read_text(encoding="utf-8")) if kept.exists() and not fresh else {}
    )
    files = sorted(
        path.relative_to(root).as_posix()
        for folder in ("tests", "hyperfab")
        for path in (root / folder).glob("**/*.py")
        if not path.relative_to(root).as_posix().startswith(IGNORED)
        and (path.name.startswith("test_") or (folder == "hyperfab" and ">>>" in path.read_text(encoding="utf-8")))
    )
    stamps = {file: _stamp(root / file) for file in files}
    tests = {name: test for name, test in known.items() if stamps.get(name.split("::")[0]) == test["stamp"]}
    changed = [
        file
        for file in files
        if wanted and file.startswith(wanted) and known.get(f"{file}::", {}).get("stamp") != stamps[file]
    ]
    # The tests of commands last, those of whole chains last of all: they take longest.
    late = ("tests/cloth", "tests/loop", "tests/chapters", "tests/cli", "tests/chapters/test_close_loop")
    changed.sort(key=lambda file: (max([0, *(n for n, at in enumerate(late, 1) if file.startswith(at))]), file))
    examples = [file for file in changed if file.startswith("hyperfab")]
    for batch in [examples, *([file] for file in changed if file not in examples)]:
        if not batch:
            continue
        told = work / "told"
        for old in work.glob("told*"):
            old.unlink()
        environment = {reach.TREE: str(copy), reach.TOLD: str(told)}
        with open(work / "map.log", "ab") as log:
            asked = ["-p", "trials.mutants.reach", *batch]
            tree.started(copy, asked, environment, stdout=log, stderr=log).wait()
        tests = {name: test for name, test in tests.items() if name.split("::")[0] not in batch}
        for file in batch:
            tests[f"{file}::"] = {"stamp": stamps[file], "seconds": 0.0, "reaches": []}
        for name, test in reach.read(told).items():
            tests[name] = {**test, "stamp": stamps[name.split("::")[0]]}
        kept.write_text(json.dumps(tests), encoding="utf-8")
        print(f"what it reaches: {batch[-1]}", flush=True)
    return {name: test for name, test in tests.items() if not name.endswith("::")}


def _stamp(path: Path) -> str:
    import hashlib

    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def shown(mutant: Mutant, copy: Path, names: list[str], modules: set[str], seconds: float) -> str:
    """Plant the defect in the copy, run the tests until one fails; ``caught by ...``, ``survived`` or ``no test``."""
    if not names:
        return "no test reaches it"
    file = copy / mutant.path
    source = file.read_bytes()
    aside = copy.parent / "compiled"
    shutil.rmtree(aside, ignore_errors=True)
    compiled = [
        kept
        for module in sorted(modules | {mutant.path})
        for kept in (copy / module).parent.glob(f"__pycache__/{Path(module).stem}.*.nb[ic]")
    ]
    moved = [(kept, aside / str(number)) for number, kept in enumerate(compiled)]
    aside.mkdir(parents=True)
    for kept, away in moved:
        shutil.move(kept, away)
    try:
        file.write_bytes(mutant.planted(source))
        os.utime(file, (tree.EPOCH + 1 + int(mutant.name[:6], 16),) * 2)
        limit = int(2.0 * seconds + 15.0 + (_COMPILES if modules else 0.0))
        status, told = tree.forked(copy, ["-x", "-q", "-rfE", "--no-header", "--tb=no", *names], limit)
        if status is None:
            return "caught: runs on"
        if status == 0:
            return "survived"
        if status in (4, 5):  # a test's name holds what the defect changes: nobody was asked
            return f"no test of that name: status {status}"
        failed = [
            line.split(" - ")[0].split(" ", 1)[1] for line in told.splitlines() if line.startswith(("FAILED", "ERROR "))
        ]
        return f"caught by {failed[0]}" if failed else f"caught: status {status}"
    finally:
        file.write_bytes(source)
        os.utime(file, (tree.EPOCH, tree.EPOCH))
        for module in sorted(modules | {mutant.path}):
            for new in (copy / module).parent.glob(f"__pycache__/{Path(module).stem}.*.nb[ic]"):
                new.unlink()
        for kept, away in moved:
            shutil.move(away, kept)


def main() -> int:
    """Draw, plant, tell; status 1 where under nine in ten of those that matter were noticed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scale", type=float, default=1.0, help="times as many of each package (214 at 1)")
    parser.add_argument("--seconds", type=float, default=60.0, help="CPU time of tests that one defect may take")
    parser.add_argument("--only", default="", help="files whose path begins so")
    parser.add_argument("--fresh", action="store_true", help="ask anew which test reaches what")
    parser.add_argument(
        "--near",
        action="store_true",
        help="ask the tests of a defect's own package alone, not those of commands",
    )
    parser.add_argument("--as-mapped", action="store_true", help="take what is known of who reaches what as it is")
    options = parser.parse_args()
    # Ended from outside, a draw takes its defect out again.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    work = tree.ROOT / "build" / "mutants"
    copy = work / "tree"
    copy.mkdir(parents=True, exist_ok=True)
    lock = open(work / "lock", "w")  # noqa: SIM115 - held until the end: two at a time would plant in one copy
    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    tree.copy(copy)
    told: dict[str, str] = tomllib.loads((Path(__file__).parent / "equivalent.toml").read_text(encoding="utf-8"))
    kept = work / "outcomes.json"
    outcomes: dict[str, list[str]] = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    whole = drawn(copy, options.scale)
    program = Program(copy)
    # Those in kernels last: each costs a compilation.
    draw = sorted(
        ((stratum, mutant) for stratum, mutant in whole if mutant.path.startswith(options.only)),
        key=lambda drawn: bool(program.compiled_from(drawn[1])),
    )
    left, last = [mutant for _, mutant in draw if mutant.name not in told], [("tests/", "hyperfab/")]
    for wanted in [near(left)] + (last if not options.near else []):
        reached = mapped(tree.ROOT, copy, work, options.fresh, () if options.as_mapped else wanted)
        options.fresh = False
        selection = Selection(program, reached)
        for mutant in left:
            names: list[str] = []
            total = 0.0
            for name in selection.tests(mutant):
                total += selection.seconds[name]
                if names and total > options.seconds:
                    break
                names.append(name)
            source, tests = _stamp(copy / mutant.path), _stamp_of(copy, names)
            outcome, old_source, old_tests, _ = outcomes.get(mutant.name, ["", "", "", ""])
            if old_source != source or (not outcome.startswith("caught") and old_tests != tests):
                before, asked = sum(os.times()[2:4]), program.compiled_from(mutant)
                outcome = shown(mutant, copy, names, asked, min(total, options.seconds))
                used = f"{sum(os.times()[2:4]) - before:.1f}"
                outcomes[mutant.name] = [outcome, source, tests, used]
                kept.write_text(json.dumps(outcomes, indent=1), encoding="utf-8")
                print(f"{mutant.name} {mutant}\n           {outcome} ({used} s)", flush=True)
        left = [mutant for mutant in left if not outcomes[mutant.name][0].startswith("caught")]
    return _told(draw, whole, outcomes, told)


def _told(
    draw: list[tuple[str, Mutant]],
    whole: list[tuple[str, Mutant]],
    outcomes: dict[str, list[str]],
    told: dict[str, str],
) -> int:
    """Print what nothing noticed, and how many of each stratum; 1 where under nine in ten of those that matter."""
    counts: dict[str, Counter[str]] = {stratum: Counter() for stratum in [*STRATA, "in all"]}
    for stratum, mutant in draw:
        word = "equivalent" if mutant.name in told else outcomes[mutant.name][0].split()[0].rstrip(":")
        word = word if word in ("equivalent", "caught") else "not"
        if word == "not":
            print(f"not noticed: {mutant.name} {mutant}\n           {outcomes[mutant.name][0]}")
        counts[stratum][word] += 1
        counts["in all"][word] += 1
    for stratum, count in counts.items():
        print(f"{stratum:>10}: {count.total():3d} drawn, {count['caught']:3d} caught, {count['not']:2d} not, "
              f"{count['equivalent']:2d} equivalent")  # fmt: skip
    for stale in sorted(set(told) - {mutant.name for _, mutant in whole}):
        print(f"equivalent.toml: no such defect any more: {stale}")
    matter = counts["in all"]["caught"] + counts["in all"]["not"]
    print(f"{100.0 * counts['in all']['caught'] / max(matter, 1):.1f} % caught of those that are not equivalent")
    return 0 if counts["in all"]["caught"] >= 0.9 * matter else 1


def _stamp_of(copy: Path, names: list[str]) -> str:
    import hashlib

    files = sorted({name.split("::")[0] for name in names})
    return hashlib.sha256("".join([*names, *(_stamp(copy / file) for file in files)]).encode()).hexdigest()[:16]


if __name__ == "__main__":
    start = time.monotonic()
    status = main()
    print(f"{time.monotonic() - start:.0f} s")
    raise SystemExit(status)
