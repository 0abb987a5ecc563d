"""What the engine promises: everything runs once, whatever dies, and the table does not tell how it came about."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT
from studies import trivial

from hyperfab.cases.sweep import SweepCase
from hyperfab.chapters import sweep
from hyperfab.chapters.job import Job
from hyperfab.chapters.summary import paragraph
from hyperfab.console import Console
from hyperfab.errors import InputError, OutputError, UsageError
from hyperfab.studies.store import Outcome

pytest.importorskip("distributed", reason="Dask is not installed (pip install . brings it)")

SUMS = """
format = "hyperfab.study/1"
name = "Sums"
[axis.a]
range = {{ from = 1, to = 4, count = 4 }}
[axis.b]
values = {b}
[[step]]
name = "first"
command = "{command}"
arguments = ["{{a}}"]
[[step]]
name = "second"
command = "add"
arguments = ["{{first}}", "{{b * 1}}"]
[figures]
sum = "second.sum"
"""

DRIVER = """
import sys
sys.path[:0] = [{root!r}, {root!r} + "/tests"]
from hyperfab.cases.sweep import SweepCase
import studies.trivial
from hyperfab.chapters import sweep
from hyperfab.chapters.job import Job
from hyperfab.console import Console, run_guarded
from hyperfab.studies import plan
plan.program = lambda: "the same"  # also in a tree that is being worked on
if __name__ == "__main__":
    study, out, jobs, retry = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4] == "retry"
    sys.exit(run_guarded(lambda: sweep.run(
        Job("sweep", [study], Console()), SweepCase(study=study, out=out, jobs=jobs, retry_failed=retry),
        commands=studies.trivial), True))
"""


class Inline:
    """A client that runs each batch at once, in this process: for what does not depend on processes."""

    def submit(self, function: Any, *arguments: Any, key: str, pure: bool) -> Any:
        return Done(key, function(*arguments))

    def nthreads(self) -> dict[str, int]:
        return {"here": 1}


class Done:
    """A future that is there already."""

    status = "finished"

    def __init__(self, key: str, value: Any) -> None:
        self.key = key
        self.value = value

    def result(self) -> Any:
        return self.value

    def add_done_callback(self, call: Any) -> None:
        call(self)


class Said(Console):
    """A console that keeps what is said."""

    text = ""

    def note(self, text: str) -> None:
        self.text += text + "\n"

    warn = note


class Shop:
    """A folder with a driver that sweeps trivial commands."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        (folder / "driver.py").write_text(DRIVER.format(root=str(ROOT)))

    def study(self, command: str = "add", b: str = '["1 mm", "2 mm"]') -> None:
        (self.folder / "study.toml").write_text(SUMS.format(command=command, b=b))

    def start(self, out: str, jobs: int = 2, retry: str = "") -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            [sys.executable, "driver.py", "study.toml", out, str(jobs), retry],
            cwd=self.folder,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )

    def sweep(self, out: str, jobs: int = 2, retry: str = "") -> tuple[int, str]:
        process = self.start(out, jobs, retry)
        said = process.communicate(timeout=120)[1].decode()
        return process.returncode, said

    def inline(self, out: str, retry: bool = False) -> tuple[int, str]:
        said = Said()
        here = contextlib.chdir(self.folder)
        with here, pytest.MonkeyPatch.context() as patch:
            patch.setattr("hyperfab.studies.plan.program", lambda: "the same")
            patch.setattr("hyperfab.studies.cluster.local", lambda jobs, plugin: contextlib.nullcontext(Inline()))
            status = sweep.run(
                Job("sweep", ["study.toml"], said),
                SweepCase(study="study.toml", out=out, jobs=1, retry_failed=retry),
                commands=trivial,
            )
        return status, said.text

    def table(self, out: str) -> bytes:
        return (self.folder / out / "sweep.csv").read_bytes()

    def finished(self, out: str) -> list[int]:
        """Return how often each step says in its log that it was finished."""
        logs = (self.folder / out).glob("steps/*/*.log")
        return [path.read_text().count(" finished ") for path in logs]


@pytest.fixture
def shop(tmp_path: Path) -> Shop:
    return Shop(tmp_path)


def test_shared_steps_run_once_and_a_second_run_does_nothing(shop: Shop) -> None:
    shop.study()
    status, said = shop.inline("out")
    assert status == 0, said
    assert "8 cases: 12 steps run, 0 found finished" in said
    assert shop.finished("out") == [1] * 12
    rows = shop.table("out").decode().splitlines()
    assert rows[0].startswith("case,a,b_mm,status,sum")
    assert rows[0].endswith(",number")
    assert [row.rpartition(",")[2] for row in rows[1:]] == [str(n) for n in range(1, 9)]
    assert [row.split(",")[1:5] for row in rows[1:3]] == [
        ["1.0", "1.0", "0", "2.0"],
        ["1.0", "2.0", "0", "3.0"],
    ]
    before = shop.table("out")
    status, said = shop.inline("out")
    assert status == 0
    assert "0 steps run, 12 found finished" in said
    assert shop.table("out") == before
    # Another value of one axis runs what is new, and nothing else.
    shop.study(b='["1 mm", "2 mm", "3 mm"]')
    status, said = shop.inline("out")
    assert "12 cases: 4 steps run, 12 found finished" in said
    assert shop.finished("out") == [1] * 16


def test_a_failing_case_is_told_in_the_table_and_the_others_go_on(shop: Shop) -> None:
    shop.study(command="fail")
    status, said = shop.inline("out")
    assert status == 1
    assert "2 of 8 cases failed" in said
    rows = [row.split(",") for row in shop.table("out").decode().splitlines()]
    message = rows[0].index("message")
    assert [row[3] for row in rows[1:]] == ["0"] * 6 + ["4"] * 2
    assert rows[-1][message] == "first.json: 4.0 is more than 3"
    # Failures are results too: only --retry-failed tries them again.
    assert "0 steps run" in shop.inline("out")[1]
    assert "1 steps run" in shop.inline("out", retry=True)[1]


def test_what_a_failed_case_came_to_is_none_of_its_figures(shop: Shop) -> None:
    shop.study(command="stall")
    more = 'far = "first.sum"\n[limit]\nfar = { most = 9 }\n[pareto]\nminimize = ["sum"]\nmaximize = ["far"]\n'
    with (shop.folder / "study.toml").open("a") as study:
        study.write(more)
    status, said = shop.inline("out")
    assert status == 1
    assert "2 of 8 cases failed" in said
    found = json.loads((shop.folder / "out" / "sweep.json").read_bytes())
    # The last two, at a = 4, end at 3.5: that is no value of the figure at a = 4, and keeps to no limit.
    assert found["figures"]["far"] == {"cases": 6, "least": 1.0, "mean": 2.0, "greatest": 3.0}
    assert found["within_limits"] == 6
    assert found["best"]["far"]["a"] == 3.0
    (effect,) = (one for one in found["effects"] if (one["axis"], one["figure"]) == ("a", "far"))
    assert (effect["levels"], effect["means"]) == ([1.0, 2.0, 3.0], [1.0, 2.0, 3.0])


def test_an_axis_along_which_nothing_changes_is_told(shop: Shop) -> None:
    shop.study()
    assert "every case finds the same" not in shop.inline("out")[1]
    # The step is another for each value of b, and b plays no part in it.
    text = (
        (shop.folder / "study.toml")
        .read_text()
        .replace('"add"\narguments = ["{first}"', '"first"\narguments = ["{first}"')
    )
    (shop.folder / "study.toml").write_text(text)
    status, said = shop.inline("out")
    assert status == 0
    assert "along b every case finds the same" in said
    found = json.loads((shop.folder / "out" / "sweep.json").read_bytes())
    assert found["idle"] == ["b"]
    assert "along b every case finds the same" in paragraph(found)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("sum =", "b_mm =", "key figures.b_mm: is the column b_mm, the column of axis.b"),
        ("sum =", "case =", "key figures.case: is the column case, a column of each table's own"),
        (
            "sum =",
            "within_limits =",
            "key figures.within_limits: is the column within_limits, a column of each table's own",
        ),
        ("axis.a]", "axis.status]", "key axis.status: is the column status, a column of each table's own"),
        ("axis.a]", "axis.b_mm]", "key axis.b: is the column b_mm, the column of axis.b_mm"),
    ],
)
def test_one_column_is_of_one_thing(shop: Shop, old: str, new: str, words: str) -> None:
    shop.study()
    text = (shop.folder / "study.toml").read_text().replace(old, new)
    text = text.replace("{a}", f"{{{new[5:-1]}}}") if old == "axis.a]" else text
    (shop.folder / "study.toml").write_text(text)
    with pytest.raises(InputError, match=re.escape(words)):
        shop.inline("out")


def test_what_was_found_with_a_file_that_changed_meanwhile_is_not_kept(
    shop: Shop, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A step is known by what its files held: found with others, it would be taken for that ever after."""
    shop.study()
    text = (shop.folder / "study.toml").read_text().replace('"{b * 1}"', '"{b * 1}", "n.json"')
    (shop.folder / "study.toml").write_text(text)
    number, run, seen = shop.folder / "n.json", trivial.run, 0

    def changing(command: str, words: Sequence[str], output: str) -> Outcome:
        nonlocal seen
        if output.endswith("second.json"):
            seen += 1
            number.touch()  # written anew, and the same
            if seen == 4:
                number.write_text('{"sum": 20}')
        return run(command, words, output)

    number.write_text('{"sum": 10}')
    monkeypatch.setattr(trivial, "run", changing)
    with pytest.raises(InputError, match="changed while the study ran") as error:
        shop.inline("out")
    assert str(error.value).startswith(str(number))
    number.write_text('{"sum": 10}')
    assert shop.inline("out")[0] == 0
    table = [row.split(",") for row in shop.table("out").decode().splitlines()[1:]]
    assert [float(row[4]) for row in table] == [10.0 + float(row[1]) + float(row[2]) for row in table]


def test_a_full_disk_stops_the_study_and_the_next_run_goes_on(shop: Shop) -> None:
    shop.study(command="fill")
    with pytest.raises(OutputError, match="No space left"):
        shop.inline("out")
    kept = shop.finished("out").count(1)
    assert kept >= 2
    assert not list((shop.folder / "out").glob("steps/*/.*run-*"))
    (shop.folder / "freed").touch()
    status, said = shop.inline("out")
    assert status == 0
    assert f"{kept} found finished" in said
    assert shop.finished("out") == [1] * 12


@pytest.mark.slow
def test_a_step_that_kills_its_worker_costs_its_cases_only(shop: Shop) -> None:
    (shop.folder / "study.toml").write_text(
        SUMS.format(command="add", b='["1 mm"]').replace(
            'command = "add"\narguments = ["{first}"', 'command = "die"\narguments = ["{first}"'
        )
    )
    (shop.folder / "study.toml").write_text((shop.folder / "study.toml").read_text().replace("count = 4", "count = 2"))
    status, said = shop.sweep("out", jobs=1)
    assert status == 1, said
    assert b",137," in shop.table("out")
    assert b"its worker died each time" in shop.table("out")


@pytest.mark.slow
def test_killed_workers_and_drivers_lose_nothing_and_run_nothing_twice(shop: Shop) -> None:
    psutil = pytest.importorskip("psutil", reason="comes with distributed")
    shop.study(command="sleep", b="[" + ", ".join(str(n / 100) for n in range(1, 5)) + "]")
    text = (shop.folder / "study.toml").read_text()
    text = text.replace("from = 1, to = 4", "from = 0.1, to = 0.3").replace('command = "add"', 'command = "sleep"')
    (shop.folder / "study.toml").write_text(text)
    first = shop.start("out")
    _wait_for_steps(shop, "out", 3, first)
    workers = [child for child in psutil.Process(first.pid).children() if "spawn_main" in " ".join(child.cmdline())]
    assert workers
    workers[0].kill()
    _wait_for_steps(shop, "out", 6, first)
    first.kill()
    first.communicate()
    alive = psutil.wait_procs(workers, timeout=10)[1]
    assert not alive, "workers outlived their driver"
    status, said = shop.sweep("out")
    assert status == 0, said
    assert shop.finished("out") == [1] * 20
    assert shop.inline("serial")[0] == 0
    assert shop.table("serial") == shop.table("out")
    assert not list((shop.folder / "out").glob("steps/*/.*run-*"))


@pytest.mark.parametrize(
    ("number", "status"), [(signal.SIGINT, 130), pytest.param(signal.SIGTERM, 143, marks=pytest.mark.slow)]
)
def test_a_stop_keeps_what_is_done_and_leaves_no_process(shop: Shop, number: int, status: int) -> None:
    psutil = pytest.importorskip("psutil", reason="comes with distributed")
    shop.study(command="sleep")
    process = shop.start("out")
    _wait_for_steps(shop, "out", 1, process)
    family = psutil.Process(process.pid).children(recursive=True)
    asked = time.monotonic()
    os.killpg(process.pid, number) if number == signal.SIGINT else process.send_signal(number)
    said = process.communicate(timeout=30)[1].decode()
    # 0.5 s where the machine is not loaded; 2 s are promised.
    assert time.monotonic() - asked < 15.0
    assert process.returncode == status
    assert "what is finished is kept" in said
    assert "Traceback" not in said
    assert not psutil.wait_procs(family, timeout=2)[1]
    assert shop.finished("out").count(1) >= 1


def test_a_stop_while_workers_start_does_not_wait_for_them(shop: Shop) -> None:
    psutil = pytest.importorskip("psutil", reason="comes with distributed")
    shop.study(command="sleep")
    process = shop.start("out")
    driver = psutil.Process(process.pid)
    for _ in range(600):
        workers = [one for one in driver.children() if "spawn_main" in " ".join(one.cmdline())]
        if workers:
            break
        time.sleep(0.05)
    assert workers
    family = driver.children(recursive=True)
    asked = time.monotonic()
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=30)[1].decode()
    # 0.4 s where the machine is not loaded; it took ten more.
    assert time.monotonic() - asked < 8.0
    assert process.returncode == 130
    assert "Traceback" not in said
    assert not psutil.wait_procs(family, timeout=2)[1]


@pytest.mark.slow
def test_nothing_listens_beyond_the_loopback_and_a_second_driver_is_refused(shop: Shop) -> None:
    psutil = pytest.importorskip("psutil", reason="comes with distributed")
    shop.study(command="sleep")
    process = shop.start("out")
    _wait_for_steps(shop, "out", 1, process)
    family = [psutil.Process(process.pid), *psutil.Process(process.pid).children(recursive=True)]
    heard = {
        found.laddr.ip
        for member in family
        for found in member.net_connections(kind="inet")
        if found.status == psutil.CONN_LISTEN
    }
    with pytest.raises(UsageError, match="another hf sweep is at work there"):
        shop.inline("out")
    process.terminate()
    process.communicate()
    assert heard == {"127.0.0.1"}


def _wait_for_steps(shop: Shop, out: str, count: int, process: subprocess.Popen[bytes]) -> None:
    for _ in range(600):
        if len(list((shop.folder / out).glob("steps/*/*/outcome.json"))) >= count:
            return
        assert process.poll() is None, process.stderr.read() if process.stderr else ""
        time.sleep(0.05)
    raise AssertionError("the driver finished nothing within half a minute")
