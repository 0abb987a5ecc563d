"""A command that cannot write its output ends with status 5, leaves the old files whole, and no litter."""

from __future__ import annotations

import errno
import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from hyperfab.cli import app
from hyperfab.errors import UsageError
from hyperfab.io import atomic
from hyperfab.io.output import Output

ROOT = Path(__file__).resolve().parents[2]
UNIAXIAL = ROOT / "specimens/treloar-1944/uniaxial.csv"
FIT = ["fit", "--uniaxial", str(UNIAXIAL), "--model", "yeoh-3", "--quiet"]


def everything(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def run_here(arguments: list[str]) -> int:
    """Run the command in this process, where the system's calls can be made to fail."""
    status: int = app(arguments, standalone_mode=False)
    return status


def failing(call: str, number: int, code: int, calls: list[int]) -> Callable[..., object]:
    real = getattr(os, call)

    def wrapped(*arguments: object, **keywords: object) -> object:
        calls.append(1)
        if len(calls) == number:
            raise OSError(code, os.strerror(code))
        return real(*arguments, **keywords)

    return wrapped


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EIO])
@pytest.mark.parametrize("call", ["write", "fsync", "replace"])
def test_the_kth_call_fails_and_nothing_has_changed(
    call: str, code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "fabric.json"
    assert run_here([*FIT, "-o", str(target)]) == 0
    written = everything(tmp_path)
    assert len(written) == 3
    old = {name: b"old " + name.encode() for name in written}
    for number in range(1, 20):
        for name, data in old.items():
            (tmp_path / name).write_bytes(data)
        calls: list[int] = []
        with monkeypatch.context() as patch:
            patch.setattr(atomic.os, call, failing(call, number, code, calls))
            status = run_here([*FIT, "-o", str(target)])
        said = capfd.readouterr().err
        if len(calls) < number:
            assert status == 0
            assert everything(tmp_path) == written
            break
        assert status == 5
        assert os.strerror(code) in said
        assert str(tmp_path) in said
        assert "Traceback" not in said
        assert everything(tmp_path) == old
    assert number > 3


def limited(bytes_: int) -> Callable[[], None]:
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (bytes_, bytes_))


def hf(arguments: list[str], folder: Path, **keywords: object) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, "-m", "hyperfab", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=False,
        timeout=120,
        **{"stderr": subprocess.PIPE, **keywords},  # type: ignore[call-overload]
    )


def test_a_limit_on_the_size_of_files_is_status_5(tmp_path: Path) -> None:
    done = hf([*FIT, "-o", "fabric.json"], tmp_path, preexec_fn=limited(1000))
    assert done.returncode == 5
    assert b"File too large" in done.stderr
    assert everything(tmp_path) == {}


def test_a_full_disk_behind_standard_output_is_status_5(tmp_path: Path) -> None:
    with open("/dev/full", "wb") as full:
        done = hf(FIT, tmp_path, stdout=full)
    assert done.returncode == 5
    assert b"No space left on device" in done.stderr
    assert b"Traceback" not in done.stderr


def test_a_reader_that_leaves_is_no_traceback(tmp_path: Path) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    done = hf(FIT, tmp_path, stdout=writing)
    os.close(writing)
    assert done.returncode == 5
    assert b"Traceback" not in done.stderr


def test_work_goes_on_where_nobody_reads_the_messages() -> None:
    code = (
        "from hyperfab.console import Console\n"
        "Console().note('a note')\n"
        "Console().table('a table', ['effect', 'score'], [['rate', 3.2]])\n"
        "print('written')\n"
    )
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=writing, check=False)
    os.close(writing)
    assert (done.returncode, done.stdout) == (0, b"written\n")


def test_a_full_disk_behind_the_messages_costs_no_result(tmp_path: Path) -> None:
    # Status 1 would say that the verdict is negative.
    with open("/dev/full", "wb") as full:
        done = hf([*FIT, "-o", "fabric.json"], tmp_path, stderr=full)
    assert done.returncode == 0
    assert (tmp_path / "fabric.json").exists()


def test_closed_standard_streams_are_no_traceback(tmp_path: Path) -> None:
    for closed in ("<&-", ">&-", "2>&-", "<&- >&- 2>&-"):
        command = f"exec {sys.executable} -m hyperfab {' '.join(FIT)} -o fabric.json {closed}"
        done = hf_shell(command, tmp_path)
        assert done.returncode == 0, (closed, done.stderr)
        assert b"Traceback" not in done.stderr
        assert json.loads((tmp_path / "fabric.json").read_bytes())["model"] == "yeoh-3"
        (tmp_path / "fabric.json").unlink()
    done = hf_shell(f"exec {sys.executable} -m hyperfab {' '.join(FIT)} >&-", tmp_path)
    assert done.returncode == 5
    assert b"Traceback" not in done.stderr


def hf_shell(command: str, folder: Path) -> subprocess.CompletedProcess[bytes]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(["bash", "-c", command], cwd=folder, env=environment, capture_output=True, check=False)


@pytest.mark.slow
def test_killed_at_any_moment_the_document_is_old_or_new(tmp_path: Path) -> None:
    target = tmp_path / "fabric.json"
    assert hf([*FIT, "-o", "fabric.json"], tmp_path).returncode == 0
    new = target.read_bytes()
    old = new.replace(b"yeoh-3", b"neo-haakeon")
    start = time.perf_counter()
    assert hf([*FIT, "-o", "fabric.json"], tmp_path).returncode == 0
    whole = time.perf_counter() - start
    for step in range(4):
        target.write_bytes(old)
        process = subprocess.Popen(
            [sys.executable, "-m", "hyperfab", *FIT, "-o", "fabric.json"],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stderr=subprocess.DEVNULL,
        )
        time.sleep(whole * (0.6 + 0.1 * step))
        process.kill()
        process.wait()
        assert target.read_bytes() in (old, new)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_a_device_or_a_pipe_gets_no_files_beside_it(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(UsageError, match="write - for standard output"):
        Output(str(tmp_path / "pipe"), (".csv",))
