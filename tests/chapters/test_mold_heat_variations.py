"""hf mold-heat --variations: many settings on a reduced mold, near what full runs give."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.errors import InputError

from .test_mold_heat import PLATE, heat

FACTORS = "film [-],power [-]\n1,1\n1.6,1.4\n0.5,0.7\n"


@pytest.mark.slow
def test_variations_are_near_full_runs_of_the_same_settings(tmp_path):
    text = PLATE.replace('"300 s"', '"400 s"').replace("[run]", '[run]\ntarget = "60 degC"\ntolerance = "0.01 K"')
    text = text.replace('h = "12 W/m^2/K"', 'h = { table = "film.csv" }')
    (tmp_path / "film.csv").write_text("temperature [degC],h [W/m^2/K]\n20,30\n100,60\n")
    (tmp_path / "factors.csv").write_text(FACTORS)
    status, document, _ = heat(tmp_path, text, variations=str(tmp_path / "factors.csv"))
    assert status == 0
    found = document["variations"]
    assert found["difference_max_K"] < 0.02
    assert "heat.variations.csv" in document["files"]
    assert len((tmp_path / "heat.variations.csv").read_text().splitlines()) == 4
    for run in found["runs"]:
        film, power = run["factors"]["film"], run["factors"]["power"]
        rows = f"20,{30 * film}\n100,{60 * film}\n"
        (tmp_path / "film.csv").write_text("temperature [degC],h [W/m^2/K]\n" + rows)
        _, full, _ = heat(tmp_path, text.replace('"400 W"', f'"{400 * power} W"'), "full")
        final = full["probes"]["centre"]["final_degC"]
        assert run["probes_final_degC"]["centre"] == pytest.approx(final, abs=0.05)
        assert run.get("warmup_time_s") == pytest.approx(full.get("warmup_time_s"), rel=1e-3)
        if "warmup_time_s" in full:
            spread = full["work_surface"]["at_warmup"]["spread_K"]
            assert run["work_surface_spread_K"] == pytest.approx(spread, abs=0.05)


@pytest.mark.parametrize(
    ("table", "mold", "words"),
    [
        ("film [-]\n-1\n", PLATE, "is no factor"),
        ("wind [-]\n1\n", PLATE, "no variation"),
        (FACTORS, PLATE.replace('until = "300 s"', "steady = true"), "steady state"),
        (FACTORS, PLATE + '[[temperature]]\non = "plate.x-"\nvalue = "25 degC"\n', "held temperatures"),
    ],
)
def test_variations_that_make_no_sense_are_refused(tmp_path, table, mold, words):
    (tmp_path / "factors.csv").write_text(table)
    with pytest.raises(InputError, match=words):
        heat(tmp_path, mold, variations=str(tmp_path / "factors.csv"))


def test_points_of_a_face_keep_their_area_their_mean_and_what_is_of_second_degree():
    from hyperfab.thermal.lumping import lumped

    generator = np.random.default_rng(3)
    rows, weights = generator.normal(size=(500, 4)), generator.uniform(0.5, 1.5, 500)
    few, total = lumped(rows, weights, 40)
    assert len(total) == 40
    assert total.sum() == pytest.approx(weights.sum())
    np.testing.assert_allclose(total @ few, weights @ rows)
    np.testing.assert_allclose(few.T @ (total[:, None] * few), rows.T @ (weights[:, None] * rows), atol=1e-9)


@pytest.mark.slow
def test_a_hundred_variations_of_the_original_mold(tmp_path):
    from hyperfab.samples import sample_files

    files = sample_files()
    for folder in ("specimens", "molds"):
        (tmp_path / folder).mkdir()
    (tmp_path / "specimens/film.csv").write_bytes(files["specimens/film.csv"])
    generator = np.random.default_rng(1)
    rows = [f"{a:.3f},{b:.3f}" for a, b in generator.uniform(0.6, 1.5, (100, 2))]
    (tmp_path / "molds/factors.csv").write_text("film [-],power [-]\n" + "\n".join(rows) + "\n")
    text = files["molds/original.toml"].decode()
    _, document, _ = heat(tmp_path / "molds", text, variations=str(tmp_path / "molds/factors.csv"))
    assert len(document["variations"]["runs"]) == 100
    assert document["variations"]["difference_max_K"] < 0.05
