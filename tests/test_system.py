"""The program on a system that lacks what POSIX has: the parts that differ are asked for by name."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

#: Takes away, before hyperfab is loaded, what Windows does not have, and opens files there as text unless told not to.
WITHOUT_POSIX = """
import errno, os, signal, sys
for module, names in (
    (signal, ("SIGALRM", "setitimer", "ITIMER_REAL")),
    (os, ("O_CLOEXEC", "O_NONBLOCK", "O_DIRECTORY", "set_blocking", "sched_getaffinity", "sysconf", "memfd_create")),
    (errno, ("EDQUOT",)),
):
    for name in names:
        if hasattr(module, name):
            delattr(module, name)
os.O_BINARY = 1 << 26
opened, plain = [], os.open
def open_(path, flags, *more, **named):
    opened.append((os.fspath(path), flags & os.O_BINARY))
    return plain(path, flags & ~os.O_BINARY, *more, **named)
os.open = open_
from hyperfab.cli import main
sys.argv = ["hf", *sys.argv[1:]]
try:
    main()
finally:
    text = [path for path, binary in opened if not binary and path.startswith(os.getcwd())]
    assert not text, text
    assert any(binary for _, binary in opened)
"""


def without_posix(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    root = Path(__file__).parents[1]
    return subprocess.run(
        [sys.executable, "-c", WITHOUT_POSIX, *words],
        cwd=folder,
        env={
            "PYTHONPATH": str(root),
            "PATH": "",
            "NUMBA_CACHE_DIR": "",
            "MPLCONFIGDIR": str(folder / ".mpl"),
        },
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_fit_writes_its_document_and_its_picture_byte_by_byte(tmp_path: Path) -> None:
    rows = "\n".join(f"{1 + 0.1 * i},{0.4 * ((1 + 0.1 * i) - (1 + 0.1 * i) ** -2)}" for i in range(1, 8))
    (tmp_path / "pull.csv").write_text(f"stretch,stress [MPa]\n{rows}\n")
    done = without_posix(tmp_path, "fit", "--uniaxial", "pull.csv", "--model", "neo-hookean", "-o", "fit.json")
    assert done.returncode == 0, done.stderr
    assert b"\r" not in (tmp_path / "fit.json").read_bytes()
    assert (tmp_path / "fit.png").read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    again = without_posix(tmp_path, "export", "fit.json", "--to", "abaqus")
    assert again.returncode == 0, again.stderr
    assert "*HYPERELASTIC" in again.stdout.upper()


def test_a_missing_input_is_told_as_on_any_system(tmp_path: Path) -> None:
    done = without_posix(tmp_path, "summary", "none.json")
    assert done.returncode == 3
    assert "no such file" in done.stderr


def test_two_drives_share_no_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    import ntpath

    from hyperfab.documents import provenance

    monkeypatch.setattr(provenance.os, "path", ntpath)
    monkeypatch.setattr(ntpath, "abspath", ntpath.normpath)
    assert provenance.relative_name(r"D:\lab\pull.csv", r"C:\work\fit.json") == "pull.csv"
    assert provenance.relative_name(r"C:\pull.csv", r"D:\fit.json") == "pull.csv"


def test_one_driver_alone_holds_a_study(tmp_path: Path) -> None:
    from hyperfab.errors import UsageError
    from hyperfab.studies.store import Store

    with Store(tmp_path).held(), pytest.raises(UsageError, match="another hf sweep"), Store(tmp_path).held():
        pass
    with Store(tmp_path).held():
        pass


def test_a_mold_on_a_machine_without_the_mesher_says_what_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    from hyperfab.errors import UsageError
    from hyperfab.thermal import mesher, netgen_process
    from hyperfab.thermal.geometry import Body, Box, Geometry

    monkeypatch.setattr(netgen_process.importlib.util, "find_spec", lambda name: None)
    body = Body("plate", (Box((0.0, 0.0, 0.0), (10.0, 10.0, 10.0)),))
    with pytest.raises(UsageError, match="netgen-mesher"):
        mesher.make_mesh(Geometry((body,), (), ()), 5.0)
