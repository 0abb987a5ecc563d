"""A document with other constants says nothing any more of those it had."""

from __future__ import annotations

from hyperfab.documents.material import MaterialDocument

FIT = {"E2": 1.0, "relative_rms": 0.1, "nrmse": 0.1, "points": 9}
RANGE = {"stretch_min": 0.5, "stretch_max": 2.0, "ended_by": "scan"}
PLANE = {"stretch_min": 0.5, "stretch_max": 2.0, "stable_fraction": 1.0}
ROW = {"temperature_degC": 23.0, "parameters": {"C10_MPa": 0.2}, "fit": FIT}
DIRECTION = {
    "parameters": {"C10_MPa": 0.2}, "fit": FIT, "stability": {"shear": RANGE}, "stability_plane": PLANE, "stable": True,
    "temperatures": [ROW], "tested": {"uniaxial": {"stretch": [1.0, 1.8]}},
}  # fmt: skip
FULL = {
    "format": "hyperfab.material/1", "model": "neo-hookean", "parameters": {"C10_MPa": 0.2}, "thickness_mm": 0.6,
    "thickness_nominal": True, "temperature_degC": 23.0, "directions": {"warp": DIRECTION}, "temperatures": [ROW],
    "fit": FIT, "stability": {"shear": RANGE}, "stability_plane": PLANE, "stable": True, "accepted": True,
    "accepted_by": "relative_rms", "carry_over": 0.2,
    "objective": "relative", "fit_on": ["uniaxial"], "left_out": {"zero": 1}, "preparation": ["zeroed"],
    "replicates": [{"test": "uniaxial", "specimens": 3, "scatter": 0.01}], "bulk_modulus_MPa": 5.0,
    "warnings": ["weak"], "models": [{"model": "gent"}], "effects": [{"id": "rate", "parameters_sd": {"g": 0.1}}],
    "tested": {"uniaxial": {"stretch": [1.0, 1.8]}}, "files": ["a.csv"],
    "joint_uncertainty": {"order": ["parameters.C10_MPa"], "covariance": [[1e-4]], "specimens": 3,
                          "degrees_of_freedom": 2.0, "source": "specimens"},
    "undetermined": [{"constant": "G_MPa", "value": 0.0, "test": "a slanted one"}],
}  # fmt: skip
#: Keys that other constants leave true.
KEPT = {
    "format", "model", "parameters", "thickness_mm", "thickness_nominal", "temperature_degC", "directions",
    "temperatures", "bulk_modulus_MPa", "effects", "tested", "files",
}  # fmt: skip


def test_every_key_of_the_document_is_in_this_test() -> None:
    """A key added later must be judged here: true of the sheet whatever its constants, or of these alone."""
    assert set(MaterialDocument.model_fields) - set(FULL) <= {
        "provenance",
        "validity",
        "uncertainty",
        "setup",
    }


def test_nothing_said_of_the_old_constants_is_left() -> None:
    found = MaterialDocument.model_validate(FULL).refitted().to_json()
    assert set(found) == KEPT
    assert found["files"] == []
    assert found["effects"] == [{"id": "rate"}]
    assert set(found["directions"]["warp"]) == {"parameters", "temperatures", "tested"}
    assert found["directions"]["warp"]["temperatures"] == found["temperatures"] == [
        {"temperature_degC": 23.0, "parameters": {"C10_MPa": 0.2}}
    ]  # fmt: skip
