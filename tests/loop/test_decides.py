"""The page that names every threshold of the loop is the program's."""

from __future__ import annotations

import ast
import importlib
import re
from pathlib import Path

import pytest

import hyperfab.loop as loop

PAGE = (Path(__file__).parents[2] / "docs" / "close-loop-decides.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| `(\w+)\.(\w+)` \| ([^ |]+) \|", PAGE, re.MULTILINE)
#: The modules that decide; those that estimate noise and fit have constants of their methods beside those told.
DECIDE = ("judge", "score", "search", "engine", "heldout", "mimic", "known", "design")


@pytest.mark.parametrize(
    ("module", "name", "value"), ROWS, ids=[f"{module}.{name}" for module, name, _ in ROWS]
)
def test_a_threshold_is_as_told(module: str, name: str, value: str) -> None:
    assert getattr(importlib.import_module(f"hyperfab.loop.{module}"), name) == float(value)


@pytest.mark.parametrize("module", DECIDE)
def test_no_threshold_is_left_out(module: str) -> None:
    tree = ast.parse((Path(loop.__file__).parent / f"{module}.py").read_text(encoding="utf-8"))
    names = {
        name.id
        for node in tree.body
        if isinstance(node, ast.Assign)
        for target in node.targets
        for name in ast.walk(target)
        if isinstance(name, ast.Name)
    }
    found = importlib.import_module(f"hyperfab.loop.{module}")
    numbers = {name for name in names if isinstance(getattr(found, name), (int, float))}
    assert numbers == {name for one, name, _ in ROWS if one == module}
