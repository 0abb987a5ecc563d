"""``hf summary`` rounds constants and gaps by what is known of their deviations."""

from __future__ import annotations

from hyperfab.chapters.summary import paragraph

MATERIAL = {
    "format": "hyperfab.material/1",
    "model": "mooney-rivlin-2",
    "parameters": {"C10_MPa": 0.123456, "C01_MPa": 0.0456789},
    "fit": {
        "relative_rms": 0.02,
        "points": 30,
        "tests": {},
        "parameters_sd": {"C10_MPa": 0.0042},
        "uncertainty": {"source": "readings"},
    },
}
PRESS = {
    "format": "hyperfab.press/1",
    "contact_fraction": 0.5,
    "contact_area_mm2": 1000.0,
    "force_N": 50.0,
    "pressure_max_MPa": 0.002,
    "male": {"temperature_degC": 200.0},
    "female": {"temperature_degC": 200.0},
    "gap_min_mm": 0.61234,
    "gap_mean_mm": 2.5,
    "gap_max_mm": 4.0,
}


def test_constants_are_rounded_by_their_deviations_and_say_what_these_are_of() -> None:
    first = paragraph(MATERIAL)[0]
    assert "C10_MPa 0.123 ± 0.004, C01_MPa 0.045679 (± one sd of the readings alone);" in first
    specimens = MATERIAL | {"fit": MATERIAL["fit"] | {"uncertainty": {"source": "replicates"}}}
    assert "of the readings" not in paragraph(specimens)[0]
    bare = MATERIAL | {"fit": MATERIAL["fit"] | {"parameters_sd": None}}
    assert "C10_MPa 0.12346, C01_MPa 0.045679; relative rms" in paragraph(bare)[0]


def test_the_gap_is_told_with_its_band() -> None:
    assert "gap at 200 degC 0.61 mm to 4.00 mm, mean 2.50 mm" in paragraph(PRESS)
    known = {"gap_min_mm": {"sd": 0.021, "budget": []}}
    press = PRESS | {"uncertainty": {"method": "linear", "quantities": known}}
    assert "gap at 200 degC 0.612 ± 0.021 mm to 4.00 mm, mean 2.50 mm" in paragraph(press)
