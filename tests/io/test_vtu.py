"""VTU files say what they were given, to another program's reader, and say it in the same bytes each time."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

from hyperfab.io.vtu import CELL_TYPES, collection, unstructured

RANDOM = np.random.default_rng(5)
POINTS = RANDOM.random((40, 3))


@pytest.mark.parametrize("kind", CELL_TYPES)
def test_every_cell_type_reads_back_in_meshio(kind: str, tmp_path: Path) -> None:
    nodes = RANDOM.integers(0, 40, (7, CELL_TYPES[kind][1]))
    fields = {"a_mm": POINTS[:, 0], "b": POINTS, "n": np.arange(40)}
    (tmp_path / "a.vtu").write_bytes(unstructured(POINTS, {kind: nodes}, fields, {"c": np.arange(7.0)}))
    mesh = meshio.read(tmp_path / "a.vtu")
    assert np.array_equal(mesh.points, POINTS)
    [block] = mesh.cells
    assert block.type == kind
    assert np.array_equal(block.data, nodes)
    for name, values in fields.items():
        assert np.array_equal(mesh.point_data[name], values)
    assert np.array_equal(mesh.cell_data["c"][0], np.arange(7.0))


def test_mixed_cells_and_more_than_one_block_of_data(tmp_path: Path) -> None:
    points = RANDOM.random((150_000, 2))
    cells = {
        "triangle": RANDOM.integers(0, 150_000, (100_000, 3)),
        "quad": RANDOM.integers(0, 150_000, (9, 4)),
    }
    data = unstructured(points, cells, cell_data={"slack": np.arange(100_009) % 2 == 0})
    (tmp_path / "a.vtu").write_bytes(data)
    mesh = meshio.read(tmp_path / "a.vtu")
    assert np.array_equal(mesh.points[:, :2], points)
    assert not mesh.points[:, 2].any()
    assert [np.array_equal(block.data, cells[block.type]) for block in mesh.cells] == [True, True]
    assert np.concatenate(mesh.cell_data["slack"]).tolist() == [1 - i % 2 for i in range(100_009)]
    assert data == unstructured(points, cells, cell_data={"slack": np.arange(100_009) % 2 == 0})


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((POINTS[:, :1], {"triangle": [[0, 1, 2]]}), "points"),
        ((POINTS * np.nan, {"triangle": [[0, 1, 2]]}), "points"),
        ((POINTS, {"triangle": [[0, 1, 40]]}), "do not exist"),
        ((POINTS, {"triangle": [[0, 1, -1]]}), "do not exist"),
        ((POINTS, {"quad": [[0, 1, 2]]}), "quad"),
        ((POINTS, {"hexagon": [[0, 1, 2]]}), "hexagon"),
        ((POINTS, {}), "needs cells"),
        ((POINTS, {"triangle": [[0, 1, 2]]}, {"T_degC": [1.0, 2.0]}), "T_degC"),
        ((POINTS, {"triangle": [[0, 1, 2]]}, {}, {"t_mm": [1.0, 2.0]}), "t_mm"),
        ((POINTS, {"triangle": [[0, 1, 2]]}, {"name": ["a"] * 40}), "name"),
    ],
)
def test_arrays_that_do_not_fit_are_refused_by_name(arguments: tuple, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        unstructured(*arguments)


def test_a_series_names_its_files_and_times() -> None:
    text = collection([0, 0.1], ["a&b.0.vtu", "a.1.vtu"]).decode()
    assert 'timestep="0.1" part="0" file="a.1.vtu"' in text
    assert "a&amp;b" in text
