"""`hf sweep`: cost of a case beyond its command, two workers against one, and a study under constant killing.

    python benchmarks/sweep.py                 overhead at 10^3 cases, scaling, and a short run under killing
    python benchmarks/sweep.py overhead 10000  overhead, memory of the driver, at so many trivial cases
    python benchmarks/sweep.py chaos 200       so many cases of the sample study of the press, a worker killed every
                                               20 s, the driver twice; the table against that of an undisturbed
                                               serial run. Exit status 1 where a case is lost or run twice

The driver holds Dask's scheduler, so its memory is that of both.
"""

from __future__ import annotations

import importlib
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import psutil

ROOT = Path(__file__).resolve().parent.parent

TRIVIAL = """
format = "hyperfab.study/1"
name = "Trivial"
[axis.a]
range = {{ from = 1, to = {count}, count = {count} }}
[[step]]
name = "one"
command = "{command}"
arguments = ["{{a}}"]
[figures]
sum = "one.sum"
"""

# ---- the trivial commands -------------------------------------------------------------------------------------

COMMANDS = {"add": "none", "wait": "none"}


def check(command: str, words: Sequence[str]) -> str | None:
    """Nothing can be wrong with the arguments of a trivial command."""
    return None


def warm(commands: Sequence[str]) -> None:
    """There is nothing to warm up."""


def run(command: str, words: Sequence[str], output: str):  # type: ignore[no-untyped-def]
    """Write a small document; ``wait`` computes for a tenth of a second before."""
    from hyperfab.io.atomic import write_files
    from hyperfab.io.json_io import dump_json
    from hyperfab.studies.store import Outcome

    end = time.process_time() + (0.1 if command == "wait" else 0.0)
    while time.process_time() < end:
        sum(range(1000))
    write_files([(output, dump_json({"sum": float(words[0])}))])
    return Outcome(0)


def drive(study: str, out: str, jobs: str) -> int:
    """Run a study of trivial commands in this process, and tell its memory."""
    from hyperfab.cases.sweep import SweepCase
    from hyperfab.chapters import sweep
    from hyperfab.chapters.job import Job
    from hyperfab.console import Console

    status = sweep.run(
        Job("sweep", [study], Console(quiet=True)),
        SweepCase(study=study, out=out, jobs=int(jobs)),
        commands=importlib.import_module("sweep"),
    )
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024)
    return status


# ---- what is measured -----------------------------------------------------------------------------------------


def overhead(count: int) -> None:
    """Print the time and memory of a study of trivial cases."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "study.toml").write_text(TRIVIAL.format(count=count, command="add"))
        started, megabytes = _timed(folder, "out", 2)
        again, memory = _timed(folder, "out", 2)
        logs = Path(folder, "out", "steps").glob("*/*.log")
        inside = sum(float(re.findall(r"in ([0-9.]+) s", log.read_text())[0]) for log in logs)
        rows = Path(folder, "out", "sweep.csv").read_text().count("\n") - 1
        print(
            f"{count:>8} cases  {started:8.1f} s  {1000 * (started - inside / 2) / count:6.2f} ms a case beyond it"
            f"  driver {megabytes} MB  table {rows} rows; again: {again:.1f} s, {memory} MB"
        )


def scaling(count: int = 150) -> None:
    """Print the time of commands of a tenth of a second with one worker and with two."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "study.toml").write_text(TRIVIAL.format(count=count, command="wait"))
        Path(folder, "few.toml").write_text(TRIVIAL.format(count=2, command="wait"))
        times = []
        for jobs in (1, 2):
            start_up, _ = _timed(folder, f"few-{jobs}", jobs, "few.toml")
            whole, _ = _timed(folder, f"out-{jobs}", jobs)
            times.append(whole - start_up)
        print(
            f"{count} cases of 0.1 s: one worker {times[0]:.1f} s, two {times[1]:.1f} s: "
            f"{times[0] / times[1]:.2f} times (start-up taken off)"
        )


def chaos(count: int, interval: float = 20.0) -> bool:
    """Print what is lost and run twice while workers and drivers are killed; return whether nothing is."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _sample_study(folder, count)
        workers = drivers = 0
        start = last = time.monotonic()
        process = _hf(folder, "out", 2)
        while process.poll() is None:
            time.sleep(0.2)
            if time.monotonic() - last < interval:
                continue
            last = time.monotonic()
            done = len(list((folder / "out").glob("steps/*/*/outcome.json")))
            if drivers < 2 and done > count * (drivers + 1) / 3:
                process.kill()
                process.wait()
                drivers += 1
                process = _hf(folder, "out", 2)
                continue
            family = _workers(process)
            if family:
                family[workers % len(family)].kill()
                workers += 1
        disturbed = time.monotonic() - start
        status = process.returncode
        if not (folder / "out" / "sweep.csv").exists():
            print(f"no table: the last driver ended with {status} after {disturbed:.0f} s, {workers} workers killed")
            return False
        start = time.monotonic()
        _hf(folder, "serial", 1).wait()
        serial = time.monotonic() - start
        logs = [log.read_text() for log in (folder / "out").glob("steps/*/*.log")]
        finished = [log.count(" finished ") for log in logs]
        begun = sum(log.count(" started") for log in logs)
        equal = (folder / "out" / "sweep.csv").read_bytes() == (folder / "serial" / "sweep.csv").read_bytes()
        rows = (folder / "out" / "sweep.csv").read_text().count("\n") - 1
        print(
            f"{rows} cases, exit {status}: {workers} workers and {drivers} drivers killed; {finished.count(1)} steps "
            f"finished once, {len(finished) - finished.count(1)} otherwise, {begun - len(logs)} begun in vain; table "
            f"byte-equal to the serial run: {equal}; {disturbed:.0f} s, serial {serial:.0f} s"
        )
        return equal and rows == count and finished == [1] * count


def _sample_study(folder: Path, count: int) -> None:
    """Write the sample study of the press with ``count`` cases: five foams and two temperatures by more gaps."""
    for name in ("molds/cup-male.stl", "molds/cup-female.stl", "specimens/foam.toml", "specimens/foam.csv"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes((ROOT / name).read_bytes())
    text = (ROOT / "molds" / "study-press.toml").read_text()
    for old, new in (
        ('values = ["4 mm", "5 mm", "6 mm"]', 'range = { from = "4 mm", to = "6 mm", count = 5 }'),
        ("count = 4", f"count = {count // 10}"),
    ):
        assert text.count(old) == 1, f"the sample study has no {old}"
        text = text.replace(old, new)
    (folder / "molds" / "study.toml").write_text(text)


def _workers(driver: subprocess.Popen[bytes]) -> list[psutil.Process]:
    """The driver's worker processes; none where it has just ended."""
    try:
        return [one for one in psutil.Process(driver.pid).children() if "spawn_main" in " ".join(one.cmdline())]
    except psutil.NoSuchProcess:
        return []


def _hf(folder: Path, out: str, jobs: int) -> subprocess.Popen[bytes]:
    words = [
        sys.executable,
        "-m",
        "hyperfab",
        "sweep",
        "molds/study.toml",
        "--out",
        out,
        "--jobs",
        str(jobs),
        "--quiet",
    ]
    return subprocess.Popen(words, cwd=folder)


def _timed(folder: str, out: str, jobs: int, study: str = "study.toml") -> tuple[float, int]:
    code = "import sys; sys.path.insert(0, sys.argv[1]); import sweep; sys.exit(sweep.drive(*sys.argv[2:]))"
    here = str(Path(__file__).resolve().parent)
    start = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-c", code, here, study, out, str(jobs)],
        cwd=folder,
        stdout=subprocess.PIPE,
        check=True,
    )
    return time.monotonic() - start, int(done.stdout)


if __name__ == "__main__":
    what = sys.argv[1] if len(sys.argv) > 1 else "all"
    size = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    if what in ("all", "overhead"):
        overhead(size or 1000)
    if what in ("all", "scaling"):
        scaling(size or 150)
    if what in ("all", "chaos") and not chaos(size or 40, 20.0 if size else 8.0):
        sys.exit("something was lost, or run twice")
