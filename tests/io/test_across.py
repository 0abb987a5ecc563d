"""What widens or narrows across the load, as laboratories call it, is the second direction of a uniaxial test."""

import pytest

from hyperfab.io.headings import heading, meaning


@pytest.mark.parametrize(
    ("title", "name"),
    [
        ("lateral strain [-]", "strain"), ("Transverse Strain (%)", "strain"), ("Querdehnung [%]", "strain"),
        ("déformation transversale [%]", "strain"), ("Deformación transversal [%]", "strain"),
        ("transverse_stretch", "stretch"), ("Lateral stretch [-]", "stretch"), ("strain 2 [-]", "strain"),
    ],
)  # fmt: skip
def test_a_column_across_the_load_is_the_second_direction(title, name):
    found = meaning(heading(title, 0))
    assert found is not None
    assert (found.name, found.axis, found.compressive) == (name, "2", False)


@pytest.mark.parametrize("title", ["lateral strain [mm]", "Querdehnung [mm]"])
def test_a_change_of_width_without_the_width_is_left_aside(title):
    assert meaning(heading(title, 0)).name == "aside"


@pytest.mark.parametrize("title", ["lateral contraction [-]", "Querkontraktion [-]"])
def test_what_may_count_narrowing_as_positive_is_not_guessed(title):
    assert meaning(heading(title, 0)) is None
