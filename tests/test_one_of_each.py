"""What the program knows of one thing stands in one place."""

from __future__ import annotations

import ast
from collections.abc import Iterator

import pytest
from sources import PACKAGE, parsed

#: Rows of several curves stacked for a solver, what a law answers, and the lines of a picture.
NO_CURVE = {"Rows", "_Rows", "Strip", "Line"}


def classes() -> Iterator[tuple[str, ast.ClassDef]]:
    for path, tree in parsed().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                yield str(path), node


def test_a_measured_curve_is_held_by_one_class() -> None:
    found = []
    for path, node in classes():
        fields = {
            one.target.id for one in node.body if isinstance(one, ast.AnnAssign) and isinstance(one.target, ast.Name)
        }
        if {"stretch", "stress"} <= fields and node.name not in NO_CURVE:
            found.append((path, node.name))
    assert found == [("curve.py", "TestCurve")]


def called(tree: ast.Module) -> set[str]:
    """Return what a module calls, as it is written."""
    return {ast.unparse(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}


@pytest.mark.parametrize("law", ["Orthotropic.of", "Hyperfoam.of"])
def test_constants_of_a_document_become_a_law_in_one_reader(law: str) -> None:
    readers = [path.name for path, tree in parsed().items() if "chapters" in path.parts and law in called(tree)]
    assert readers == ["fabric.py"]


def test_no_chapter_is_imported_by_a_name_made_of_text_and_no_words_are_read_but_by_the_command_line() -> None:
    """What import-linter cannot see, it cannot hold; what argv says is in the case."""
    for path, tree in parsed().items():
        text = (PACKAGE / path).read_text(encoding="utf-8")
        # What is compiled ahead is listed by a tool of the build, which is no command.
        assert "sys.argv" not in text or path.name == "ahead.py", path
        if {"chapters", "studies"} & {*path.parts}:
            assert not {one for one in called(tree) if one.endswith("import_module")}, path
