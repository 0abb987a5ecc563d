"""The doors: help, version, usage errors, and what they load."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT, Run

COMMANDS = [
    "fit",
    "fabric-contact",
    "drape",
    "mold-heat",
    "press-contact",
    "close-loop",
    "report",
    "sweep",
    "export",
    "summary",
    "sample",
    "schema",
]


def test_help_names_every_command(hf: Run) -> None:
    done = hf("--help")
    assert done.returncode == 0
    listed = done.stdout.decode().split("Commands:")[1]
    assert [line.split()[0] for line in listed.splitlines() if line.strip()] == COMMANDS


@pytest.mark.parametrize("command", COMMANDS)
def test_help_page_of_a_command_shows_an_example(hf: Run, command: str) -> None:
    done = hf(command, "--help")
    assert done.returncode == 0
    assert f"hf {command} " in done.stdout.decode().split("Example:")[1]


def test_help_loads_neither_numpy_nor_rich_nor_pydantic() -> None:
    code = (
        "import sys\n"
        "sys.argv = ['hf', '--help']\n"
        "from hyperfab import cli\n"
        "try:\n    cli.main()\n"
        "except SystemExit as end:\n    assert end.code == 0\n"
        "heavy = {'numpy', 'rich', 'pydantic', 'scipy', 'hyperfab.cases.drape'}\n"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert done.stderr.decode().strip() == "[]"


@pytest.mark.parametrize("command", COMMANDS)
def test_help_page_of_a_command_loads_neither_numpy_nor_rich(command: str) -> None:
    code = (
        f"import sys\nsys.argv = ['hf', {command!r}, '--help']\nfrom hyperfab import cli\n"
        "try:\n    cli.main()\nexcept SystemExit as end:\n    assert end.code == 0\n"
        "print(sorted({'numpy', 'rich', 'scipy'} & set(sys.modules)), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert done.stderr.decode().strip() == "[]"


LYCRA = [str(ROOT / f"specimens/lycra/{way}-23C.csv") for way in ("warp", "weft")]


@pytest.mark.parametrize(
    ("words", "spared"),
    [
        (["fit", *LYCRA, "--model", "yeoh-3"], {"scipy.optimize", "scipy.stats", "numba", "pandas"}),
        (["close-loop", "fabric.json", *LYCRA], {"scipy.optimize", "scipy.spatial", "scipy.stats", "numba", "pandas"}),
    ],
)
def test_what_takes_long_to_load_is_spared_where_nothing_needs_it(
    hf: Run, tmp_path: Path, words: list[str], spared: set[str]
) -> None:
    fabric, found = (str(tmp_path / name) for name in ("fabric.json", "found.json"))
    assert hf("fit", LYCRA[0], "--model", "yeoh-3", "-o", fabric).returncode == 0
    words = [fabric if word == "fabric.json" else word for word in words]
    code = (
        f"import sys\nsys.argv = ['hf', *{words!r}, '-o', {found!r}]\nfrom hyperfab import cli\n"
        "try:\n    cli.main()\nexcept SystemExit as end:\n    assert end.code == 0\n"
        f"print(sorted({spared!r} & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert done.stdout.decode().strip() == "[]"


def test_a_misspelt_command_is_told_the_right_one(hf: Run) -> None:
    assert b"drape" in hf("drap").stderr


def test_version_is_the_package_version(hf: Run) -> None:
    from hyperfab import __version__

    assert hf("--version").stdout.decode() == f"hf {__version__}\n"


@pytest.mark.parametrize("arguments", [["nonsense"], ["fit", "--nonsense"], ["drape"], ["schema", "nonsense"], []])
def test_bad_usage_is_status_2_and_says_why(hf: Run, arguments: list[str]) -> None:
    done = hf(*arguments)
    assert done.returncode == 2
    assert done.stderr.strip() or not arguments
    assert b"Traceback" not in done.stderr


@pytest.mark.parametrize("arguments", [["--help"], ["fit", "--help"], ["schema", "material"], ["--version"]])
def test_full_disk_behind_standard_output_is_status_5(arguments: list[str], root: object) -> None:
    with open("/dev/full", "wb") as full:
        done = subprocess.run(
            [sys.executable, "-m", "hyperfab", *arguments],
            stdout=full,
            stderr=subprocess.PIPE,
            cwd=str(root),
            check=False,
        )
    assert done.returncode == 5
    assert b"No space left" in done.stderr
    assert b"Traceback" not in done.stderr


def test_a_long_run_on_a_dumb_terminal_says_once_a_minute_how_far_it_is(monkeypatch, capfd) -> None:
    from hyperfab import console

    clock = iter([0.0, 10.0, 59.0, 61.0, 62.0, 122.0, 130.0])
    monkeypatch.setattr(console.time, "monotonic", lambda: next(clock))
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "dumb")
    with console.Console().progress("Heating the mold") as advance:
        for done in range(6):
            advance(0.1 * done, f"{done} s")
    lines = capfd.readouterr().err.splitlines()
    assert lines == [
        "Heating the mold: 20 % after 1 min, 2 s",
        "Heating the mold: 40 % after 2 min, 4 s",
    ]
    with console.Console(quiet=True).progress("Heating the mold") as advance:
        advance(0.5)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    ("seconds", "said"),
    [
        # 2 % take 2 s, twice over.
        (
            [20.0 + 2.0 * k for k in range(9)],
            ["Heating the mold: 94528 unknowns, about 90 s more by its pace so far"],
        ),
        # Twenty seconds of compilation between two steps are no pace, and what is over soon is not announced.
        ([0.1, *[20.1 + 0.4 * k for k in range(30)]], []),
        ([1.0, 1.1, 1.2], []),
    ],
)
@pytest.mark.parametrize("dumb", [False, True])
def test_a_long_run_says_first_its_size_and_how_long_it_takes(
    monkeypatch, capfd, dumb: bool, seconds: list[float], said: list[str]
) -> None:
    from hyperfab import console

    now = [0.0]
    monkeypatch.setattr(console.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(console, "EVERY_S", 1000.0)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "dumb" if dumb else "xterm")
    with console.Console().progress("Heating the mold", "94528 unknowns") as advance:
        advance(0.0)
        for count, second in enumerate(seconds, 1):
            now[0] = second
            advance(0.02 * count)
    shown = capfd.readouterr().err.replace("\x1b[2K", "")
    lines = [line.strip() for line in shown.splitlines() if "about" in line]
    assert lines == said


@pytest.mark.parametrize("paced", [False, True])
def test_off_a_terminal_a_long_run_says_nothing_of_its_progress(monkeypatch, capfd, paced: bool) -> None:
    from hyperfab import console

    now = [0.0]
    monkeypatch.setattr(console.time, "monotonic", lambda: now[0])
    shown = console.Console()
    shown.passing("compiling")
    with shown.progress("Heating the mold", "94528 unknowns", paced=paced) as advance:
        for step in range(100):
            now[0] = 10.0 * step
            advance(0.01 * step, "100 degC")
    assert capfd.readouterr().err == ""


def test_what_passes_is_said_on_a_terminal_that_is_not_quiet(monkeypatch, capfd) -> None:
    from hyperfab import console

    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    console.Console(quiet=True).passing("compiling")
    console.Console().passing("compiling")
    assert capfd.readouterr().err == "compiling\n"


@pytest.mark.parametrize("dumb", [False, True])
def test_what_has_no_pace_is_given_no_forecast(monkeypatch, capfd, dumb: bool) -> None:
    from hyperfab import console

    now = [0.0]
    monkeypatch.setattr(console.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "dumb" if dumb else "xterm")
    with console.Console().progress("Meshing the mold", paced=False) as advance:
        for second in range(0, 70, 2):
            now[0] = float(second)
            advance(second / (second + 5.0))
    shown = capfd.readouterr().err
    assert "pace" not in shown
    assert not dumb or shown.splitlines() == ["Meshing the mold: after 1 min"]


@pytest.mark.parametrize("plain", [False, True])
def test_no_colour_means_plain_text_on_a_terminal(monkeypatch, capfd, plain: bool) -> None:
    from hyperfab import console

    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("NO_COLOR", "1" if plain else "")
    console.Console().table("The path", ["depth [mm]"], [["20"]])
    with console.Console().progress("Pressing") as advance:
        advance(0.5)
    # Colours and bold are one kind of escape; that of a line which moves is another.
    styled = re.search(r"\x1b\[[0-9;]*m", capfd.readouterr().err)
    assert (styled is None) is plain
