"""The one CSV writer: whatever stands in a name or cell, every reader finds the same cells again."""

from __future__ import annotations

import ast
import csv
import io
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from builders import plate
from hypothesis import given
from hypothesis import strategies as st
from sources import parsed

from hyperfab.io.csv_write import csv_bytes

Run = Callable[..., object]

words = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), max_size=12)
numbers = st.one_of(st.floats(allow_nan=False, allow_infinity=False), st.integers(-(10**9), 10**9), st.none())


@given(st.lists(words, min_size=1, max_size=4), st.data())
def test_cells_are_what_the_standard_reader_finds(header: list[str], data: st.DataObject) -> None:
    width = len(header)
    rows = data.draw(st.lists(st.lists(st.one_of(words, numbers), min_size=width, max_size=width), max_size=5))
    found = list(csv.reader(io.StringIO(csv_bytes(header, rows).decode("utf-8"), newline="")))
    assert len(found) == len(rows) + 1
    for cells, row in zip(found, [header, *rows], strict=True):
        assert len(cells) == width
        for cell, value in zip(cells, row, strict=True):
            if isinstance(value, str):
                assert cell == " ".join(value.split())
            elif value is None:
                assert cell == ""
            else:
                assert float(cell) == value


def test_a_row_of_another_length_is_no_table() -> None:
    with pytest.raises(ValueError, match="3 cells under a header of 2"):
        csv_bytes(["a", "b"], [[1, 2, 3]])


NAMES = ("cup, left", 'the "good" one; b', "# 7 [top]")
MOLD = (
    plate(60, 40, 10)
    + """[[heater]]
on = "plate.z-"
power = "100 W"
[[convection]]
on = "exposed"
h = "12 W/m^2/K"
ambient = "25 degC"
PROBES[[probe]]
name = "middle"
at = ["30 mm", "20 mm", "10 mm"]
[work_surface]
on = "plate.z+"
[run]
start = "25 degC"
until = "120 s"
mesh_size = "20 mm"
"""
)


@pytest.mark.slow
def test_curves_of_probes_of_any_name_are_read_again(hf: Run, tmp_path: Path) -> None:
    probes = [
        f"[[probe]]\nname = '''{name}'''\nat = [\"{i + 1} mm\", \"1 mm\", \"10 mm\"]\n" for i, name in enumerate(NAMES)
    ]
    (tmp_path / "mold.toml").write_text(MOLD.replace("PROBES", "".join(probes)))
    done = hf("mold-heat", "mold.toml", "-o", "heat.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    frame = pd.read_csv(tmp_path / "heat.csv")
    assert list(frame.columns) == ["time_s", *(f"{name}_degC" for name in NAMES), "middle_degC"]
    assert frame["middle_degC"].between(24.9, 400.0).all()
    assert frame["time_s"].iloc[-1] == pytest.approx(120.0)
    done = hf(
        "close-loop",
        "mold.toml",
        "--measured",
        "heat.csv",
        "--noise",
        "0.5K",
        "-o",
        "loop.json",
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    frame = pd.read_csv(tmp_path / "loop.csv")
    wanted = [f"{name}_{what}_degC" for name in NAMES for what in ("measured", "before", "after")]
    assert list(frame.columns)[1 : 1 + len(wanted)] == wanted
    page = hf("report", "heat.json", "loop.json", "-o", "page.html", cwd=tmp_path)
    assert page.returncode == 0, page.stderr
    assert b"is no table" not in (tmp_path / "page.html").read_bytes()


def test_no_other_place_writes_csv() -> None:
    """No function joins cells by commas and rows by line breaks, or has a writer of its own."""
    found = []
    for path, tree in parsed().items():
        if path == Path("io/csv_write.py") or "materials/export" in str(path):  # cards are no CSV
            continue
        for function in ast.walk(tree):
            if not isinstance(function, ast.FunctionDef):
                continue
            calls = [node for node in ast.walk(function) if isinstance(node, ast.Call)]
            methods = [call.func for call in calls if isinstance(call.func, ast.Attribute)]
            joined = {one.value.value for one in methods if one.attr == "join" and isinstance(one.value, ast.Constant)}
            owns = any(one.attr in ("writer", "DictWriter", "to_csv", "savetxt") for one in methods)
            if owns or {",", "\n"} <= joined:
                found.append(f"{path}: {function.name}")
    assert found == []
