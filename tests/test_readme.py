"""What README.md and docs/ say is what the program does."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(page: Path, language: str) -> list[str]:
    """Return the fenced blocks of one language."""
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def shop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An engineer's folder: the samples, and `hf` on the path."""
    folder = tmp_path_factory.mktemp("shop")
    (folder / "bin").mkdir()
    (folder / "bin" / "hf").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m hyperfab "$@"\n')
    (folder / "bin" / "hf").chmod(0o755)
    for name in ("specimens", "molds"):
        shutil.copytree(ROOT / name, folder / name)
    return folder


#: Pages whose commands take longest.
LONG = (
    "close-loop.md",
    "close-loop-shapes.md",
    "drape.md",
    "fabric-contact.md",
    "press-contact.md",
    "uncertainty.md",
)


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=[pytest.mark.slow] if page.name in LONG else [], id=page.name)
        for page in PAGES
        if blocks(page, "sh")
    ],
)
def test_shell_blocks_run(page: Path, shop: Path, tmp_path: Path) -> None:
    # Who follows the README begins with nothing; the other pages are read by who has the samples.
    folder = tmp_path if page.name == "README.md" else shop
    path = f"{shop / 'bin'}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)}
    for block in blocks(page, "sh"):
        done = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", block],
            cwd=folder,
            env=environment,
            capture_output=True,
            check=False,
        )
        assert done.returncode == 0, f"{block}\n{done.stderr.decode()}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_make_targets_that_are_named_exist(page: Path) -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for block in blocks(page, "console"):
        for line in block.splitlines():
            words = line.split("#")[0].split()
            for target in words[1:] if words[:1] == ["make"] else []:
                assert re.search(rf"^{re.escape(target)}:", makefile, re.MULTILINE), line


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#\s]+)\)", page.read_text(encoding="utf-8")):
        if "://" not in target:
            assert (page.parent / target).exists(), target


def test_every_command_has_a_page() -> None:
    for command in ("fit", "fabric-contact", "drape", "mold-heat", "press-contact"):
        assert f"docs/{command}.md" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_every_option_stands_on_its_page() -> None:
    import typer.main

    from hyperfab.cli import COMMANDS, app

    group: Any = typer.main.get_command(app)
    for name in COMMANDS:
        command = group.get_command(None, name)
        page = ROOT / "docs" / f"{name}.md"
        if not page.exists():
            continue
        text = page.read_text(encoding="utf-8")
        for parameter in command.params:
            option = max(parameter.opts, key=len)
            if option.startswith("--") and parameter.name not in (
                "like",
                "output",
                "quiet",
                "debug",
                "strict",
                "help",
                "stl_unit",
            ):
                assert f"`{option}" in text, f"{page.name} does not explain {option}"
