"""How sure a heated mold is: on the states of its run, against runs of their own, and exact answers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from builders import PLATE

from hyperfab.cases.options import read
from hyperfab.cases.registry import case_class
from hyperfab.chapters.mold_heat import nearby as beside
from hyperfab.chapters.mold_heat import problem, recipe
from hyperfab.chapters.mold_heat.meshing import mesh_mold
from hyperfab.chapters.rerun import Made, rerun
from hyperfab.io.vtu_read import read_vtu

#: Small steps: their own errors are to be less than what is compared.
FINE = PLATE.replace("[run]", '[run]\ntolerance = "0.01 K"')
UNSURE = (
    FINE.replace('power = "3000 W"', 'power = "3000 W +- 2 %"')
    .replace('"237 W/m/K"', '"237 W/m/K +- 3 %"')
    .replace('"903 J/kg/K"', '"903 J/kg/K +- 1 %"')
    .replace('"25 degC"', '"25 degC +- 2 K"')
)
FILM = '{ table = "film.csv" }'


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with the film's table; the plate is meshed once for all."""
    monkeypatch.setattr(problem, "mesh_mold", lambda *given: meshed(*given[:2], given))
    (tmp_path / "film.csv").write_text("temperature [degC],h [W/m^2/K]\n25,5\n100,9\n250,13\n")
    monkeypatch.chdir(tmp_path)


MESHES: dict[float, Any] = {}


def meshed(geometry: Any, size: float, given: tuple[Any, ...]) -> Any:
    """Return the plate's mesh, made where it is not there yet."""
    if size not in MESHES:
        MESHES[size] = mesh_mold(*given)
    return MESHES[size]


def heated(mold: str, *words: str, target: str = "-") -> Made:
    """Return what the heating of a mold would write."""
    return rerun(read(case_class("mold-heat"), ["mold.toml", *words]), target, {"mold.toml": mold.encode()})


@pytest.mark.parametrize(
    ("end", "h"),
    [
        ('target = "200 degC"', FILM),
        pytest.param('until = "15 s"', '"9 W/m^2/K +- 20 %"', marks=pytest.mark.slow),
        pytest.param('target = "200 degC"', '"9 W/m^2/K +- 20 %"', marks=pytest.mark.slow),
        pytest.param('until = "15 s"', FILM, marks=pytest.mark.slow),
    ],
)
def test_on_the_states_of_a_run_as_in_runs_of_their_own(h: str, end: str, monkeypatch: pytest.MonkeyPatch) -> None:
    mold = UNSURE.replace(FILM, h).replace('target = "200 degC"', end)
    near = heated(mold, "--uncertainty", "linear").document["uncertainty"]["quantities"]
    monkeypatch.setattr(recipe.nearby, "beside", lambda *given: None)
    anew = heated(mold, "--uncertainty", "linear").document["uncertainty"]["quantities"]
    assert set(near) == set(anew)
    for name, band in anew.items():
        # Runs of their own choose their own steps, which err by 10 mK.
        steps = 1e-3 if name.startswith("work_surface") else 0.0
        # Where a film's table has corners, what is lost at them falls into other steps.
        rel = 0.02 if h == FILM and name in ("energy.lost_J", "efficiency") else 5e-3
        assert near[name]["sd"] == pytest.approx(band["sd"], rel=rel, abs=steps), name


def test_the_field_says_how_sure_it_is() -> None:
    """Start and surroundings that are one room and warmer by as much: all of the mold is, and nothing else."""
    mold = FINE.replace(FILM, '"9 W/m^2/K"').replace("25 degC", "25 degC +- 3 K")
    made = heated(mold.replace('target = "200 degC"', 'until = "60 s"'), target="heat.json")
    field = read_vtu(made.siblings[".vtu"], "heat.vtu").point_data["temperature_degC_sd"]
    assert field == pytest.approx(3.0, rel=1e-6)
    plain = heated(FINE.replace('target = "200 degC"', 'until = "60 s"'), target="heat.json")
    assert list(read_vtu(plain.siblings[".vtu"], "heat.vtu").point_data) == ["temperature_degC"]


def test_no_mold_is_meshed_again_for_its_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    meshed: list[Any] = []
    build = recipe.MoldBuilder.build
    monkeypatch.setattr(recipe.MoldBuilder, "build", lambda *given: (meshed.append(1), build(*given))[1])
    assert heated(UNSURE).document["uncertainty"]["quantities"]
    assert len(meshed) == 1


SURE_FILM = "temperature [degC],h [W/m^2/K],h sd [W/m^2/K]\n25,5,{0}\n100,9,{1}\n250,13,{2}\n"


def filmed(rows: str, *words: str, mold: str = FINE) -> dict[str, Any]:
    """Return the document of a mold whose film's table has these rows."""
    case = read(case_class("mold-heat"), ["mold.toml", *words])
    return rerun(case, "-", {"mold.toml": mold.encode(), "film.csv": rows.encode()}).document


@pytest.mark.parametrize("way", ["on the states of the run", "run anew"])
def test_a_table_of_films_that_says_how_sure_it_is_errs_as_one(way: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """All rows by their standard deviations at once: the half difference of two runs with other tables."""
    if way == "run anew":
        monkeypatch.setattr(recipe.nearby, "beside", lambda *given: None)
    mold = FINE.replace('target = "200 degC"', 'until = "900 s"').replace("3000 W", "300 W")
    sure = filmed(SURE_FILM.format(1, 2, 1.5), "--uncertainty", "linear", mold=mold)["uncertainty"]["quantities"]
    plain = "temperature [degC],h [W/m^2/K]\n"
    up, down = (filmed(plain + rows, mold=mold) for rows in ("25,6\n100,11\n250,14.5\n", "25,4\n100,7\n250,11.5\n"))
    for group, key in (("energy", "lost_J"), ("work_surface", "mean_degC")):
        band, exact = sure[f"{group}.{key}"], 0.5 * abs(up[group][key] - down[group][key])
        assert band["sd"] == pytest.approx(exact, rel=0.01)
        assert band["budget"] == [{"source": "film.csv: h", "share": pytest.approx(1.0)}]


def test_a_table_without_a_column_of_standard_deviations_says_nothing() -> None:
    assert "uncertainty" not in filmed("temperature [degC],h [W/m^2/K]\n25,5\n100,9\n250,13\n")


@pytest.mark.slow
def test_draws_are_those_of_full_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two heaters that err apart: the evenness bends, as which end is the warmer one changes from draw to draw."""
    heater = '[[heater]]\non = "plate.{0}"\npower = "300 W +- 4 %"\n'
    mold = FINE.replace('[[heater]]\non = "plate.z-"\npower = "3000 W"\n', heater.format("x-") + heater.format("x+"))
    mold = mold.replace(FILM, '"9 W/m^2/K +- 20 %"')
    told = heated(mold).document["uncertainty"]
    assert told["method"] == "sampled"
    assert "work_surface.spread_K" in told["reason"]
    monkeypatch.setattr(beside.Beside, "samples", 64)
    near = heated(mold, "--uncertainty", "sampled").document["uncertainty"]["quantities"]
    monkeypatch.setattr(recipe.nearby, "beside", lambda *given: None)
    anew = heated(mold, "--uncertainty", "sampled").document["uncertainty"]
    assert anew["samples"] == 64
    for name, band in anew["quantities"].items():
        for key in ("sd", "low", "high"):
            steps = 1e-3 if name.startswith(("work_surface", "probes")) else 0.0
            assert near[name][key] == pytest.approx(band[key], abs=max(0.05 * band["sd"], steps)), (name, key)
