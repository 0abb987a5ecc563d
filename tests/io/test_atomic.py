"""Files appear whole or not at all."""

from __future__ import annotations

import errno
import os
import signal
import stat
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from hyperfab.errors import OutputError
from hyperfab.io import atomic
from hyperfab.io.atomic import write_files

CALLS = ("write", "fsync", "replace", "open", "close", "link")


def everything(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def fail_at(monkeypatch: pytest.MonkeyPatch, call: str, number: int, code: int) -> list[int]:
    """Let the ``number``-th call of ``os.call`` fail; returns a list that grows with the calls."""
    real, calls = getattr(os, call), []

    def failing(*arguments: object, **keywords: object) -> object:
        calls.append(1)
        if len(calls) == number:
            if call == "close":
                real(*arguments)
            raise OSError(code, os.strerror(code))
        return real(*arguments, **keywords)

    monkeypatch.setattr(atomic.os, call, failing)
    return calls


def outcome(files: list[tuple[Path, bytes]]) -> OutputError | None:
    try:
        write_files(files)
    except OutputError as error:
        return error
    return None


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EIO, errno.EDQUOT])
@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("old", [True, False])
def test_whichever_call_fails_nothing_has_changed(
    call: str, code: int, old: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = [(tmp_path / name, name.encode() * 1000) for name in ("d.vtu", "d.csv", "d.json")]
    before = {path.name: b"old " + path.name.encode() for path, _ in files[1:]} if old else {}
    after = {path.name: data for path, data in files}
    for number in range(1, 40):
        for path in tmp_path.iterdir():
            path.unlink()
        for name, data in before.items():
            (tmp_path / name).write_bytes(data)
        with monkeypatch.context() as patch:
            calls = fail_at(patch, call, number, code)
            error = outcome(files)
        if error is not None:
            assert os.strerror(code) in str(error)
            assert str(tmp_path) in str(error)
            assert everything(tmp_path) == before
            continue
        assert everything(tmp_path) == after
        if len(calls) < number:
            break
        assert call == "link"  # a file system without hard links is no obstacle
    else:
        pytest.fail("never succeeded")
    assert number > 2 or call == "link"


def test_the_umask_decides_the_mode(tmp_path: Path) -> None:
    previous = os.umask(0o027)
    try:
        write_files([(tmp_path / "a.json", b"{}")])
    finally:
        os.umask(previous)
    assert stat.S_IMODE((tmp_path / "a.json").stat().st_mode) == 0o640


def test_a_link_is_followed_and_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link.json").symlink_to(tmp_path / "real" / "a.json")
    write_files([(tmp_path / "link.json", b"{}")])
    assert (tmp_path / "link.json").is_symlink()
    assert (tmp_path / "real" / "a.json").read_bytes() == b"{}"


@pytest.mark.parametrize("device", ["/dev/full", "/dev/null"])
def test_a_device_is_never_replaced(device: str, tmp_path: Path) -> None:
    (tmp_path / "a.json").symlink_to(device)
    with pytest.raises(OutputError, match="no ordinary file"):
        write_files([(tmp_path / "a.json", b"{}")])
    assert stat.S_ISCHR(os.stat(device).st_mode)


def test_a_missing_folder_and_a_long_name_are_named(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="No such file or directory"):
        write_files([(tmp_path / "none" / "a.json", b"")])
    with pytest.raises(OutputError, match="too long"):
        write_files([(tmp_path / ("a" * 300), b"")])
    write_files([(tmp_path / ("é" * 120 + ".json"), b"{}")])


def test_a_file_size_limit_ends_in_an_output_error(tmp_path: Path) -> None:
    script = (
        "import resource, sys\n"
        "from hyperfab.errors import OutputError\n"
        "from hyperfab.io.atomic import write_files\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))\n"
        "try:\n"
        "    write_files([(sys.argv[1] + '/a.vtu', b'1'), (sys.argv[1] + '/a.json', bytes(3_000_000))])\n"
        "except OutputError as error:\n"
        "    print(error)\n"
    )
    (tmp_path / "a.json").write_bytes(b"old")
    done = subprocess.run([sys.executable, "-c", script, tmp_path], capture_output=True, check=True, text=True)
    assert "File too large" in done.stdout
    assert everything(tmp_path) == {"a.json": b"old"}


def test_killed_at_any_moment_the_old_file_or_the_new_one_is_there(tmp_path: Path) -> None:
    script = (
        "import sys\n"
        "from hyperfab.io.atomic import write_files\n"
        "number = 0\n"
        "print('go', flush=True)\n"
        "while True:\n"
        "    number += 1\n"
        "    body = str(number).encode() * 200_000\n"
        "    write_files([(sys.argv[1] + '/a.vtu', body), (sys.argv[1] + '/a.json', body)])\n"
    )
    for pause in (0.0, 0.004, 0.009, 0.015, 0.022, 0.031, 0.043, 0.05):
        process = subprocess.Popen([sys.executable, "-c", script, tmp_path], stdout=subprocess.PIPE)
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(pause)
        process.kill()
        process.wait()
        process.stdout.close()
        for name in ("a.vtu", "a.json"):
            if (tmp_path / name).exists():
                body = (tmp_path / name).read_bytes()
                unit = body[: len(body) // 200_000]
                assert body == unit * 200_000


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Let SIGINT interrupt: whoever runs the tests in the background may have it ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_a_signal_waits_until_all_files_are_in_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = os.replace

    def interrupted(*arguments: object) -> None:
        real(*arguments)
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(atomic.os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_files([(tmp_path / "a.vtu", b"1"), (tmp_path / "a.json", b"2")])
    assert everything(tmp_path) == {"a.vtu": b"1", "a.json": b"2"}
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.usefixtures("interruptible")
def test_a_signal_before_that_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = os.write

    def interrupted(*arguments: object) -> int:
        os.kill(os.getpid(), signal.SIGINT)
        return real(*arguments)

    monkeypatch.setattr(atomic.os, "write", interrupted)
    (tmp_path / "a.json").write_bytes(b"old")
    with pytest.raises(KeyboardInterrupt):
        write_files([(tmp_path / "a.vtu", bytes(3 * 2**20)), (tmp_path / "a.json", b"2")])
    assert everything(tmp_path) == {"a.json": b"old"}


def test_other_threads_may_write_too(tmp_path: Path) -> None:
    thread = threading.Thread(target=write_files, args=([(tmp_path / "a.json", b"{}")],))
    thread.start()
    thread.join()
    assert everything(tmp_path) == {"a.json": b"{}"}


def test_one_name_twice_is_a_mistake_of_the_caller(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="stands twice"):
        write_files([(tmp_path / "a.json", b"1"), (tmp_path / "a.json", b"2")])
    assert everything(tmp_path) == {}


@pytest.mark.parametrize(
    ("code", "remedy"),
    [
        (errno.ENOSPC, "free some space"),
        (errno.EDQUOT, "free some of your quota"),
        (errno.EFBIG, "raise the file size limit"),
        (errno.EROFS, "choose a folder that can be written"),
        (errno.EACCES, "choose a folder you may write to"),
        (errno.EPERM, "choose a folder you may write to"),
        (errno.ENOENT, "make the folder first"),
        (errno.ENAMETOOLONG, "choose a shorter name"),
        (errno.EIO, "check the disk"),
    ],
)
def test_each_refusal_of_the_system_has_its_remedy(code: int, remedy: str) -> None:
    with pytest.raises(OutputError, match=f"out.csv: .*; {remedy}"), atomic._told(Path("out.csv")):
        raise OSError(code, os.strerror(code))
