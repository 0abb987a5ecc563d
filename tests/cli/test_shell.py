"""What the shell meets: a summary on a terminal, help in words, hints for misspelt names, completion, a manual page."""

from __future__ import annotations

import json
import os
import pty
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from hyperfab.cases.fit import LAWS
from hyperfab.cli import COMMANDS
from hyperfab.documents.base import KINDS
from hyperfab.materials.hyperfoam import ORDERS
from hyperfab.materials.registry import laws

Run = Callable[..., "subprocess.CompletedProcess[bytes]"]
TEST = "specimens/treloar-1944/uniaxial.csv"
FIT = ("fit", "--uniaxial", TEST, "--model", "yeoh-1")


def on_a_terminal(root: Path, *arguments: str) -> str:
    """Return what a command prints where standard output is a terminal."""
    own, other = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "hyperfab", *arguments], stdout=other, stderr=subprocess.PIPE, cwd=root
    )
    os.close(other)
    found = b""
    while True:
        try:
            part = os.read(own, 65536)
        except OSError:  # how a terminal says that nobody writes any more
            break
        if not part:
            break
        found += part
    said = process.communicate()[1]
    os.close(own)
    assert process.returncode in (0, 1), said
    return found.decode().replace("\r\n", "\n") + "\n---\n" + said.decode()


def test_a_person_gets_a_summary_and_is_told_how_to_keep_the_document(root: Path) -> None:
    said = on_a_terminal(root, *FIT)
    shown, told = said.split("\n---\n")
    assert shown.startswith("yeoh-1: C10_MPa")
    assert len(shown.splitlines()) < 20
    assert "-o material.json keeps it" in told


def test_who_asks_for_the_document_gets_it_on_a_terminal_too(root: Path) -> None:
    shown = on_a_terminal(root, *FIT, "-o", "-").split("\n---\n")[0]
    assert json.loads(shown)["format"] == "hyperfab.material/1"


def test_a_pipe_gets_the_document(hf: Run) -> None:
    assert json.loads(hf(*FIT).stdout)["format"] == "hyperfab.material/1"


def test_success_is_told_in_one_line_and_quiet_says_nothing(hf: Run, root: Path, tmp_path: Path) -> None:
    arguments = ("fit", "--uniaxial", root / TEST, "--model", "yeoh-1", "-o", "fabric.json")
    assert b"written: fabric.json and 2 files beside it" in hf(*arguments, cwd=tmp_path).stderr
    assert b"written" not in hf(*arguments, "--quiet", cwd=tmp_path).stderr


@pytest.mark.parametrize("command", COMMANDS)
def test_help_is_in_words(command: str, hf: Run) -> None:
    done = hf("help", command)
    assert done.returncode == 0
    assert done.stdout == hf(command, "--help").stdout
    assert not re.search(rb"<(str|int|float|list)\b", done.stdout)


def test_help_and_version_are_found_where_people_look(hf: Run) -> None:
    assert hf("help").stdout == hf("--help").stdout
    assert hf("-V").stdout == hf("--version").stdout
    assert hf("help", "nothing").returncode == 2


def test_the_manual_page_has_every_command(hf: Run) -> None:
    page = hf("help", "--man").stdout.decode()
    assert page.startswith(".TH HF 1")
    for command in COMMANDS:
        assert f'.SH "HF {str(command).upper()}"' in page
    if shutil.which("man"):
        read = subprocess.run(["man", "-l", "-"], input=page.encode(), capture_output=True, check=True)
        assert b"fabric-contact" in read.stdout


def test_completion_can_be_installed(hf: Run) -> None:
    done = hf("dr", env={"_HF_COMPLETE": "complete_bash", "COMP_WORDS": "hf dr", "COMP_CWORD": "1"})
    assert done.stdout.split() == [b"drape"]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_both_ways_to_ask_for_the_script_of_completion_give_it(shell: str, hf: Run) -> None:
    asked, turned = (
        hf(env={"_HF_COMPLETE": f"{one}_{other}"}) for one, other in (("source", shell), (shell, "source"))
    )
    assert b"_hf_completion" in asked.stdout or b"complete" in asked.stdout
    assert turned.stdout == asked.stdout


def test_help_names_all_laws_and_all_kinds(hf: Run) -> None:
    assert LAWS.removesuffix(".").split(", ") == [*laws(), "orthotropic", *ORDERS]
    said = hf("schema", "--help").stdout.decode()
    assert all(kind in said for kind in KINDS)


@pytest.mark.parametrize(
    ("typed", "meant"), [("yeoh3", "yeoh-3"), ("mooney", "mooney-rivlin-2"), ("Ogden-2", "ogden-2")]
)
def test_a_misspelt_law_is_met_with_the_right_one(typed: str, meant: str, hf: Run) -> None:
    said = hf(*FIT[:-1], typed).stderr.decode()
    assert f"did you mean {meant}?" in said


def test_a_misspelt_key_and_option_are_met_with_the_right_ones(hf: Run, root: Path, tmp_path: Path) -> None:
    text = (root / "molds/original.toml").read_text().replace("specific_heat", "spcific_heat")
    (tmp_path / "mold.toml").write_text(text)
    said = hf("mold-heat", "mold.toml", cwd=tmp_path).stderr.decode()
    assert "spcific_heat" in said
    assert "did you mean specific_heat?" in said
    assert "--uniaxial" in hf("fit", "--unaxial", TEST).stderr.decode()


def test_an_option_of_another_command_is_said_to_be_of_that_one(hf: Run) -> None:
    for words in (["--mesh-size", "3mm"], ["--mesh-size=3mm"]):
        done = hf("drape", "fabric.json", *words)
        assert done.returncode == 2
        assert "No such option: --mesh-size; it is one of hf fabric-contact" in done.stderr.decode()
    assert "; it is one of hf fit, close-loop" in hf("drape", "--noise", "1kPa").stderr.decode()
    assert "one of" not in hf("drape", "--msh-size", "3mm").stderr.decode()


@pytest.mark.parametrize("option", ["--output", "--like"])
def test_an_empty_name_of_a_file_is_refused(option: str, hf: Run, root: Path) -> None:
    """``-o "$NAME"`` of a variable that is not set wrote a file called .json."""
    done = hf("fit", "specimens/treloar-1944/uniaxial.csv", "--model", "yeoh-2", option, "", cwd=root)
    assert done.returncode == 2
    assert f'{option} "": is empty; name a file' in done.stderr.decode()


def test_warnings_are_counted_at_the_end(hf: Run, root: Path, tmp_path: Path) -> None:
    rows = "".join(f"{1 + k / 20},{k * 0.01 * (1.5 if k == 5 else 1)}\n" for k in range(20))
    for name in "ab":
        (tmp_path / f"{name}.csv").write_text(f"# test: uniaxial\n# direction: {name}\nstretch,stress [MPa]\n{rows}")
    done = hf("fit", "--uniaxial", "a.csv", "--uniaxial", "b.csv", "--model", "ogden-3", cwd=tmp_path)
    warned = done.stderr.count(b"hf: warning:")
    assert (f"{warned} warnings".encode() in done.stderr) == (warned > 1)
