"""Ctrl-C and SIGTERM end each command within two seconds, and leave neither a half file nor a child."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SECONDS = 2.0

FABRIC = {
    "format": "hyperfab.material/1",
    "model": "yeoh-3",
    "parameters": {"C10_MPa": 0.18, "C20_MPa": -0.004, "C30_MPa": 0.0008},
    "thickness_mm": 1.0,
}
MALE, FEMALE = str(ROOT / "molds/cup-male.stl"), str(ROOT / "molds/cup-female.stl")
#: Each command at work that takes much longer than the test waits.
LONG = {
    "fit": ["fit", "--uniaxial", "long.csv", "--model", "all"],
    "fabric-contact": ["fabric-contact", "fabric.json", "--mesh-size", "1.5mm", "--steps", "100"],
    "drape": ["drape", "fabric.json", "--mold", MALE, "--grid", "800x800", "--size", "260mmx260mm"],
    "mold-heat": ["mold-heat", "mold.toml"],
    "press-contact": [
        "press-contact", "--male", "fine.stl", "--female", FEMALE, "--foam", str(ROOT / "specimens/foam.toml"),
        "--force", "200N", "--temperature", "200degC",
    ],
}  # fmt: skip
#: Where SIGTERM is tried by default, which goes the way of Ctrl-C: an iteration of ours, and a child that meshes.
SOME = ("drape", "mold-heat")
#: All, those not among these where there is time.
OFTEN = [pytest.param(name, marks=() if name in SOME else pytest.mark.slow) for name in LONG]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "fabric.json").write_text(json.dumps(FABRIC))
    rows = "".join(f"{1 + i / 160000:.6f},{0.1 + i / 80000 + (i % 7) / 1000:.6f}\n" for i in range(240_000))
    (tmp_path / "long.csv").write_text("stretch,stress [MPa]\n" + rows)
    mold = (ROOT / "molds/original.toml").read_text()
    mold = mold.replace("../specimens/film.csv", str(ROOT / "specimens/film.csv"))
    lines = ['mesh_size = "7 mm"' if line.startswith("mesh_size") else line for line in mold.splitlines()]
    (tmp_path / "mold.toml").write_text("\n".join(lines))
    (tmp_path / "fine.stl").write_bytes(refined(Path(MALE).read_bytes()))
    return tmp_path


def refined(stl: bytes) -> bytes:
    """The surface with each facet cut into sixteen."""
    import numpy as np

    from hyperfab.io.stl import read_stl
    from hyperfab.io.stl_write import stl_bytes

    mesh = read_stl(stl, "male")
    corners = mesh.vertices[mesh.faces]
    for _ in range(2):
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        corners = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return stl_bytes(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))


def session(leader: int) -> list[int]:
    """Return the living processes of a session: a child that outlived the command would be among them."""
    found = []
    for entry in os.listdir("/proc"):
        if not entry.isdigit():
            continue
        try:
            fields = Path(f"/proc/{entry}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == leader and fields[0] != "Z":
            found.append(int(entry))
    return found


@dataclass(frozen=True)
class Ended:
    """How the command ended: its status, and the seconds from the signal by the processor and by the clock."""

    status: int
    cpu_s: float
    wall_s: float
    said: str


def interrupt(arguments: list[str], folder: Path, number: signal.Signals, after: float, group: bool) -> Ended:
    """Start the command and send the signal after some seconds, to the process or, as a terminal does, to its group."""
    earlier = cpu_of_children()
    with (folder / ".stderr").open("wb") as messages:
        process = subprocess.Popen(
            [sys.executable, "-m", "hyperfab", *arguments, "-o", "out.json"],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdout=subprocess.DEVNULL,
            stderr=messages,
            start_new_session=True,
        )
        try:
            time.sleep(after)
            assert process.poll() is None, "ended before the signal: make its work longer"
            used, start = cpu_of(process.pid), time.perf_counter()
            (os.killpg if group else os.kill)(process.pid, number)
            status = process.wait(timeout=30)
            wall = time.perf_counter() - start
            time.sleep(0.1)
            assert session(process.pid) == []
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
    return Ended(status, cpu_of_children() - earlier - used, wall, (folder / ".stderr").read_text())


def cpu_of(process: int) -> float:
    """Return the processor seconds a process and the children it waited for have used."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


def cpu_of_children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def check(command: str, folder: Path, number: signal.Signals, after: float, group: bool) -> None:
    before = {path.name for path in folder.iterdir()}
    ended = interrupt(LONG[command], folder, number, after, group)
    assert ended.status == 128 + number, ended.said
    # The promise is two seconds on a free core. Here other tests share it, so the processor's seconds count where
    # the clock says more; they include what a reaped mesher used before the signal, so they are no bound by themselves.
    assert min(ended.wall_s, ended.cpu_s) < SECONDS
    assert ended.wall_s < 15.0
    assert "Traceback" not in ended.said
    assert {path.name for path in folder.iterdir()} - {".stderr"} == before


@pytest.mark.parametrize("command", OFTEN)
def test_ctrl_c_ends_the_command(command: str, folder: Path) -> None:
    check(command, folder, signal.SIGINT, 3.0, group=True)


@pytest.mark.parametrize("command", OFTEN)
def test_sigterm_ends_the_command(command: str, folder: Path) -> None:
    check(command, folder, signal.SIGTERM, 2.0, group=False)


@pytest.mark.slow
@pytest.mark.parametrize("after", [0.3, 0.6, 1.0, 1.5, 2.0, 5.0, 7.0, 10.0])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("command", LONG)
def test_at_any_moment(command: str, number: signal.Signals, after: float, folder: Path) -> None:
    check(command, folder, number, after, group=number == signal.SIGINT)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_during_compiled_code_waits_until_its_result_is_python(number: signal.Signals, tmp_path: Path) -> None:
    """numba calls Python to box a result and does not look whether that raised: the process would crash."""
    script = tmp_path / "loop.py"
    script.write_text(
        "import sys\n"
        "import numpy as np\n"
        "from numba import njit\n"
        "from hyperfab.console import run_guarded\n"
        "@njit\n"
        "def fill(n):\n"
        "    found = np.zeros(64)\n"
        "    for i in range(n):\n"
        "        found[i % 64] += np.sqrt(i)\n"
        "    return found, np.arange(n % 7)\n"
        "def work():\n"
        "    print('ready', flush=True)\n"
        "    while True:\n"
        "        fill(2_000_000)\n"
        "fill(10)\n"
        "sys.exit(run_guarded(work, debug=False))\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(
        [sys.executable, script], env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdout is not None
    process.stdout.readline()
    time.sleep(0.3)
    process.send_signal(number)
    _, said = process.communicate(timeout=20)
    assert process.returncode == 128 + number, said


@pytest.mark.parametrize("after", [0.1, 0.2, 0.3])
def test_an_early_ctrl_c_is_no_traceback(after: float, folder: Path) -> None:
    ended = interrupt(LONG["fit"], folder, signal.SIGINT, after, group=True)
    assert "hyperfab" not in ended.said
    assert ended.status in (130, -signal.SIGINT)  # before our first line the interpreter just dies of it


def test_ctrl_c_inside_an_exec_is_still_status_130(tmp_path: Path) -> None:
    script = tmp_path / "exec.py"
    script.write_text(
        "import sys\n"
        "from hyperfab.console import run_guarded\n"
        "source = 'import os, signal\\nos.kill(os.getpid(), signal.SIGINT)\\nfor i in range(10**6): pass'\n"
        "sys.exit(run_guarded(lambda: exec(source), debug=False))\n"
    )
    done = subprocess.run(
        [sys.executable, script],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 130, done.stderr
