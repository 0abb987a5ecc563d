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


DRAPE = {
    "format": "hyperfab.drape/1",
    "converged": True,
    "sheet": "membrane",
    "contact_nodes": 33,
    "force_N": 1.255,
    "thickness_min_mm": 0.425,
    "slack_springs": 0,
    "stress_warp_max_MPa": 0.0484,
    "stress_weft_max_MPa": 0.0416,
    "residual_relative": 3e-8,
    "penetration_max_mm": 0.26,
    "stretch_max": 1.0887,
    "stretch_max_at_mm": {"flat": [25.7, -3.7], "draped": [27.0, -3.8, 34.5]},
    "warp": {"stretch_max": 1.0865},
    "weft": {"stretch_max": 1.0864},
}


def test_the_greatest_stretch_of_a_membrane_is_the_documents_own_and_along_no_thread() -> None:
    assert paragraph(DRAPE)[0] == "stretched to 1.089 at most at (26, -4) mm of the flat sheet"
    net = DRAPE | {"sheet": "net", "stretch_max": 1.0865}
    assert paragraph(net)[0] == "stretched to 1.087 at most, along warp at (26, -4) mm of the flat sheet"
    older = {key: value for key, value in net.items() if key not in ("sheet", "stretch_max", "stretch_max_at_mm")}
    assert paragraph(older)[0] == "stretched to 1.087 at most, along warp"
