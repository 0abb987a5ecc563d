"""Where the places of a reading in a press were taken: on the male, on the female, or counted from elsewhere."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest
import trimesh
from loop.generators import press as caps

from hyperfab.arrays import Array
from hyperfab.cases.options import read
from hyperfab.cases.press import PressCase
from hyperfab.chapters.close_loop.press import closed_press
from hyperfab.chapters.close_loop.press_places import on_front, told_of_places, with_heights
from hyperfab.chapters.job import Job
from hyperfab.chapters.press_contact.result import PressResult
from hyperfab.console import Console
from hyperfab.errors import InputError
from hyperfab.loop.press_reading import Reading

#: How much further [mm] the female is drawn than she is pressed to.
_DRAWN = 4.0


@cache
def told() -> PressResult:
    """A cap of 70 mm in a bowl of 80 mm: its gap is 3 mm at the top, and twice that at its rim."""
    folder = Path(mkdtemp())
    (folder / "male.stl").write_bytes(caps.stl("male"))
    female = trimesh.load(trimesh.util.wrap_as_stream(caps.stl("female")), file_type="stl")
    female.apply_translation([0.0, 0.0, _DRAWN])
    female.export(folder / "female.stl")
    (folder / "foam.toml").write_text(caps.FOAM_TOML)
    words = [f"--male={folder}/male.stl", f"--female={folder}/female.stl", f"--foam={folder}/foam.toml"]
    return closed_press(Job("press-contact", [], Console(True)), read(PressCase, [*words, "--gap", f"{caps.GAP}mm"]))[0]


def male(count: int = 60) -> Array:
    """Places on the male, in its STL's coordinates."""
    random = np.random.default_rng(3)
    radius, angle = caps.REACH * 0.9 * np.sqrt(random.random(count)), 2.0 * np.pi * random.random(count)
    return np.column_stack([
        radius * np.cos(angle), radius * np.sin(angle), np.sqrt(caps.MALE**2 - radius**2)
    ])  # fmt: skip


def facing(places: Array) -> Array:
    """Where the bowl stands nearest to places of the cap, in the closed press."""
    centre = np.array([0.0, 0.0, caps.MALE + caps.GAP - caps.FEMALE])
    away = places - centre
    return np.asarray(centre + caps.FEMALE * away / np.linalg.norm(away, axis=1, keepdims=True))


def film(places: Array) -> Reading:
    return Reading("film.csv", "pressure", np.ones(len(places)), places=places)


def taken(places: Array) -> Array:
    """Return the places of the male that readings at others are taken for."""
    found = on_front(told(), film(places))
    assert found.corners is not None
    assert found.weights is not None
    return np.asarray(np.einsum("mk,mkc->mc", found.weights, told().closed.cold[found.corners]))


@pytest.mark.parametrize("raised", [0.0, _DRAWN])
def test_places_on_the_female_are_those_of_the_male_that_face_them(raised: float) -> None:
    places = facing(male()) + np.array([0.0, 0.0, raised])
    # The male's place that is nearest to a place of the female is not quite that which she is nearest to.
    assert np.max(np.linalg.norm(taken(places) - male(), axis=1)) < 0.5
    said, warned = told_of_places(told(), film(places))
    assert "lie on the female" in said[0]
    assert not warned


def test_places_that_are_counted_from_elsewhere_are_refused_with_their_shift() -> None:
    with pytest.raises(InputError, match=r"look shifted by \(1\.8.,") as refused:
        on_front(told(), film(male() + np.array([1.8, 0.0, 0.0])))
    assert refused.value.file == "film.csv"


@pytest.mark.parametrize("shift", [(0.8, 0.0, 0.0), (0.0, 0.0, 2.0)])
def test_a_small_shift_is_warned_of(shift: tuple[float, ...]) -> None:
    said, [warned] = told_of_places(told(), film(male() + np.array(shift)))
    by = [float(one) for one in warned.split("(")[1].split(")")[0].split(",")]
    assert np.max(np.abs(np.subtract(by, shift))) < 0.1
    assert not said


@pytest.mark.parametrize("kind", ["even", "random", "few"])
def test_what_is_no_shift_is_not_told(kind: str) -> None:
    random = np.random.default_rng(8)
    places = {
        "even": male() * (1.0 + 1.2 / caps.MALE),
        "random": male() + 0.5 * random.standard_normal((60, 3)),
        "few": male(6) + 0.5 * random.standard_normal((6, 3)),
    }[kind]
    assert told_of_places(told(), film(places)) == ([], [])


def test_places_without_a_height_are_those_of_the_male_seen_along_the_press() -> None:
    flat = male() * [1.0, 1.0, np.nan]
    found = with_heights(told(), film(flat)).places
    assert found is not None
    assert found[:, :2].tolist() == flat[:, :2].tolist()
    # Within the facets of the STL, which lie below the cap.
    assert np.max(np.abs(found - male())) < 0.05
    whole = film(male())
    assert with_heights(told(), whole) is whole


def test_what_the_male_cannot_tell_of_a_place_is_refused() -> None:
    beyond = male()
    beyond[7] = [0.0, 1.5 * caps.REACH, np.nan]
    with pytest.raises(InputError, match=r"the place \(0, [\d.]+\) mm is beyond the molding surface .* along z"):
        with_heights(told(), film(beyond * [1.0, 1.0, np.nan]))
    with pytest.raises(InputError, match="only a place's z, along which the press closes"):
        with_heights(told(), film(male() * [np.nan, 1.0, 1.0]))
