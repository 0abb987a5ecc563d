"""The samples: the shipped files are exactly what the generator writes, and mean what they say."""

from pathlib import Path

import numpy as np
import pytest

from hyperfab.samples import sample_files
from hyperfab.samples.cup import female_cup, male_cup, male_point, normal_gap, plate
from hyperfab.samples.lycra import nominal_stress
from hyperfab.samples.torso import height, torso

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def samples():
    return sample_files()


def test_the_repository_ships_exactly_what_the_generator_writes(samples):
    shipped = {
        path.relative_to(ROOT).as_posix(): path.read_bytes()
        for folder in ("specimens", "molds")
        for path in (ROOT / folder).rglob("*")
        if path.is_file()
    }
    assert sorted(shipped) == sorted(samples)
    assert [name for name in samples if samples[name] != shipped[name]] == []


@pytest.mark.parametrize(
    "cup",
    [male_cup(), female_cup(), torso(), plate(-20.0, 0.0)],
    ids=["male", "female", "torso", "plate"],
)
def test_a_mold_is_closed_wound_outward_and_has_no_facet_without_area(cup):
    edges = np.concatenate([cup.faces[:, [0, 1]], cup.faces[:, [1, 2]], cup.faces[:, [2, 0]]])
    forward = {(int(a), int(b)) for a, b in edges}
    assert len(forward) == len(edges)
    assert {(b, a) for a, b in forward} == forward
    a, b, c = (cup.vertices[cup.faces[:, i]] for i in range(3))
    cross = np.cross(b - a, c - a)
    assert np.einsum("ij,ij->", a, cross) > 0.0
    assert np.linalg.norm(cross, axis=1).min() > 1e-3


def test_the_female_lies_at_the_stated_gap_along_the_males_normal():
    u, v = np.array([0.0, 0.4, 0.8, 1.01]), np.array([0.0, -0.3, 0.5, 0.1])
    points, normals = male_point(u, v)
    assert normal_gap(u, v)[[0, 3]].tolist() == [3.0, 6.0]
    fine = female_cup(400, 380).vertices
    target = points + normal_gap(u, v)[:, None] * normals
    distance = [np.linalg.norm(fine - point, axis=1).min() for point in target]
    assert max(distance) < 0.5


def test_the_torso_has_two_domes_and_a_valley_between_them():
    x = np.linspace(-42.0, 42.0, 85)
    ridge = height(x, np.full_like(x, -8.0))
    assert ridge[[0, -1]] == pytest.approx(ridge.max(), rel=0.02)
    assert ridge[42] < 0.6 * ridge.max()
    np.testing.assert_allclose(ridge, ridge[::-1], rtol=1e-12)
    # The file's vertices lie on it, its facets within the sagitta of their size.
    mold = torso()
    top = mold.vertices[mold.vertices[:, 2] > 1.0]
    np.testing.assert_allclose(height(top[:, 0], top[:, 1]), top[:, 2], atol=2e-5)


def test_the_normal_of_the_male_is_perpendicular_to_its_tangents():
    u, v, h = np.array([0.3, -0.6, 0.0]), np.array([0.2, 0.5, 0.7]), 1e-6
    _, normal = male_point(u, v)
    for du, dv in ((h, 0.0), (0.0, h)):
        tangent = (male_point(u + du, v + dv)[0] - male_point(u - du, v - dv)[0]) / (2 * h)
        assert np.abs(np.einsum("ij,ij->i", tangent, normal)).max() < 1e-6


def test_fabric_softens_with_temperature_and_is_softer_along_the_weft():
    assert nominal_stress("weft", 23, 0.5) < nominal_stress("warp", 23, 0.5)
    assert nominal_stress("warp", 105, 0.5) < nominal_stress("warp", 80, 0.5) < nominal_stress("warp", 23, 0.5)


def test_fabric_readings_scatter_about_the_law_they_are_built_on(samples):
    rows = np.loadtxt(samples["specimens/lycra/warp-23C.csv"].decode().splitlines()[8:], delimiter=",")
    law = np.array([nominal_stress("warp", 23, strain) for strain in rows[:, 1]])
    assert np.sqrt(np.mean((rows[:, 2] / law - 1.0)[rows[:, 1] > 0.1] ** 2)) < 0.03
    assert len(set(rows[:, 0])) == 3


def test_foam_curve_rises_throughout(samples):
    rows = np.loadtxt(samples["specimens/foam.csv"].decode().splitlines()[3:], delimiter=",")
    assert np.diff(rows, axis=0).min() > 0.0
    assert rows[0].tolist() == [0.0, 0.0]
