"""Every figure of heat.json on molds whose answer is a formula: a wall in steady conduction, a lump that warms up."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from hyperfab.chapters.summary import paragraph

from .test_mold_heat import heat

#: A wall 60 mm long of two materials; heated at one end, a film at the other, all else insulated.
WALL = """
format = "hyperfab.mold/1"
[material.steel]
density = "7800 kg/m^3"
conductivity = "50 W/m/K"
specific_heat = "470 J/kg/K"
[material.aluminium]
density = "2700 kg/m^3"
conductivity = "200 W/m/K"
specific_heat = "900 J/kg/K"
[[part]]
name = "hot"
material = "steel"
box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["20 mm", "20 mm", "10 mm"] }
[[part]]
name = "cold"
material = "aluminium"
box = { origin = ["20 mm", "0 mm", "0 mm"], size = ["40 mm", "20 mm", "10 mm"] }
[[heater]]
on = "hot.x-"
power = "8 W"
[[convection]]
on = "cold.x+"
h = "400 W/m^2/K"
ambient = "25 degC"
[[probe]]
name = "joint"
at = ["20 mm", "10 mm", "5 mm"]
[work_surface]
on = "cold.y+"
[run]
start = "25 degC"
steady = true
mesh_size = "20 mm"
"""
AREA = 0.02 * 0.01
FLUX = 8.0 / AREA
#: Ends and joint, by the resistances in a row.
END = 25.0 + FLUX / 400.0
JOINT = END + FLUX * 0.04 / 200.0
HOT = JOINT + FLUX * 0.02 / 50.0


def test_a_wall_in_steady_conduction(tmp_path):
    status, found, _ = heat(tmp_path, WALL)
    assert status == 0
    assert found["steady"] is True
    assert "steady state on 8 W, mass 0.1 kg" in paragraph(found)
    assert found["hottest"]["temperature_degC"] == pytest.approx(HOT, rel=1e-8)
    assert found["hottest"]["at_mm"][0] == pytest.approx(0.0, abs=1e-9)
    assert found["coldest"]["temperature_degC"] == pytest.approx(END, rel=1e-8)
    assert found["coldest"]["at_mm"][0] == pytest.approx(60.0, rel=1e-9)
    assert found["probes"]["joint"] == pytest.approx({"final_degC": JOINT, "max_degC": JOINT}, rel=1e-8)
    surface = found["work_surface"]
    assert surface["area_mm2"] == pytest.approx(400.0, rel=1e-9)
    even = {
        "mean_degC": 0.5 * (JOINT + END), "min_degC": END, "max_degC": JOINT, "spread_K": JOINT - END,
    }  # fmt: skip
    assert {key: surface[key] for key in even} == pytest.approx(even, rel=1e-8)
    assert surface["at_end"] == pytest.approx(even, rel=1e-8)
    assert found["flux_max_W_m2"] == pytest.approx(FLUX, rel=1e-7)
    assert found["power_supplied_W"] == pytest.approx(8.0, rel=1e-12)
    assert found["power_lost_W"] == pytest.approx({"convection cold.x+": 8.0}, rel=1e-8)
    assert found["conditions"]["convection cold.x+"] == pytest.approx({"area_mm2": 200.0, "power_W": -8.0}, rel=1e-8)
    assert found["conditions"]["heater hot.x-"]["power_W"] == pytest.approx(8.0, rel=1e-12)
    mass = {"hot": 7800.0 * AREA * 0.02, "cold": 2700.0 * AREA * 0.04}
    assert found["mass_by_part_kg"] == pytest.approx(mass, rel=1e-9)
    assert found["mass_kg"] == pytest.approx(sum(mass.values()), rel=1e-9)
    capacity = {"hot": 470.0 * mass["hot"], "cold": 900.0 * mass["cold"]}
    assert found["heat_capacity_J_K"] == pytest.approx(sum(capacity.values()), rel=1e-9)
    stored = capacity["hot"] * (0.5 * (HOT + JOINT) - 25.0) + capacity["cold"] * (0.5 * (JOINT + END) - 25.0)
    assert found["energy"]["stored_J"] == pytest.approx(stored, rel=1e-7)
    assert found["energy"]["imbalance_relative"] < 1e-9


#: A lump: a metal that conducts so well that it is of one temperature.
LUMP = """
format = "hyperfab.mold/1"
[material.metal]
density = "2000 kg/m^3"
conductivity = "1e6 W/m/K"
specific_heat = "500 J/kg/K"
[[part]]
name = "lump"
material = "metal"
box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["20 mm", "20 mm", "20 mm"] }
[[heater]]
on = "lump.z-"
power = "20 W"
[[convection]]
on = "lump.z+"
h = "500 W/m^2/K"
ambient = "25 degC"
[[probe]]
name = "core"
at = ["10 mm", "10 mm", "10 mm"]
[work_surface]
on = "lump.z+"
[run]
start = "25 degC"
until = "60 s"
target = "75 degC"
tolerance = "0.001 K"
mesh_size = "20 mm"
"""
CAPACITY, LOSS = 2000.0 * 500.0 * 8e-6, 500.0 * 4e-4


def warmed(seconds, power=20.0, loss=LOSS, capacity=CAPACITY):
    """Rise [K] of ``C T' = P - G T``."""
    return power / loss * (1.0 - math.exp(-loss * seconds / capacity))


def warmup(rise, power=20.0, loss=LOSS, capacity=CAPACITY):
    return -capacity / loss * math.log(1.0 - loss * rise / power)


def test_a_lump_that_warms_up(tmp_path):
    status, found, _ = heat(tmp_path, LUMP)
    assert status == 0
    rise, time = warmed(60.0), warmup(50.0)
    assert found["end_time_s"] == 60.0
    assert found["target_degC"] == 75.0
    assert found["target_reached"] is True
    assert found["warmup_time_s"] == pytest.approx(time, rel=3e-4)
    assert found["probes"]["core"] == pytest.approx({"final_degC": 25.0 + rise, "max_degC": 25.0 + rise}, abs=0.02)
    surface = found["work_surface"]
    for part in (surface, surface["at_end"]):
        assert [part[key] for key in ("mean_degC", "min_degC", "max_degC")] == pytest.approx(
            [25.0 + rise] * 3, abs=0.02
        )
    assert surface["at_warmup"]["mean_degC"] == pytest.approx(75.0, abs=1e-6)
    energy = found["energy"]
    assert energy["supplied_J"] == pytest.approx(20.0 * 60.0, rel=1e-12)
    assert energy["stored_J"] == pytest.approx(CAPACITY * rise, rel=1e-4)
    assert energy["lost_J"] == pytest.approx(1200.0 - CAPACITY * rise, rel=2e-4)
    # What entered: the heater's is gained, the film's is lost.
    assert energy["by_condition_J"] == pytest.approx(
        {"heater lump.z-": 1200.0, "convection lump.z+": CAPACITY * rise - 1200.0}, rel=2e-4
    )
    at_warmup = {
        "supplied_J": 20.0 * time,
        "stored_J": CAPACITY * 50.0,
        "lost_J": 20.0 * time - CAPACITY * 50.0,
    }
    assert energy["at_warmup"] == pytest.approx(at_warmup, rel=1e-3)
    assert found["efficiency"] == pytest.approx(CAPACITY * 50.0 / (20.0 * time), rel=2e-4)
    assert found["power_supplied_W"] == 20.0
    assert found["power_lost_W"]["convection lump.z+"] == pytest.approx(LOSS * rise, rel=1e-4)
    assert found["residual_max_K"] < 1e-3


def test_a_film_and_a_heat_capacity_that_follow_temperature(tmp_path):
    """The time a lump takes is the integral of C(T) / (P - h(T) A (T - 25) - radiation), by quadrature."""
    (tmp_path / "film.csv").write_text("temperature [degC],h [W/m^2/K]\n25,100\n40,400\n60,450\n90,700\n")
    (tmp_path / "cp.csv").write_text("temperature [degC],specific heat [J/kg/K]\n20,400\n50,900\n55,500\n90,600\n")
    text = LUMP.replace('h = "500 W/m^2/K"', 'h = { table = "film.csv" }')
    text = text.replace('specific_heat = "500 J/kg/K"', 'specific_heat = { table = "cp.csv" }')
    radiation = '[[radiation]]\non = "lump.x+"\nemissivity = 0.8\nambient = "25 degC"\n'
    _, found, _ = heat(tmp_path, text.replace("[[probe]]", radiation + "[[probe]]"))

    def lost(celsius):
        film = np.interp(celsius, [25.0, 40.0, 60.0, 90.0], [100.0, 400.0, 450.0, 700.0]) * (celsius - 25.0)
        return 4e-4 * (film + 0.8 * 5.670374419e-8 * ((celsius + 273.15) ** 4 - 298.15**4))

    def heavy(celsius):
        return 0.016 * np.interp(celsius, [20.0, 50.0, 55.0, 90.0], [400.0, 900.0, 500.0, 600.0])

    def took(celsius):
        corners = [corner for corner in (40.0, 50.0, 55.0, 60.0) if corner < celsius]
        return quad(lambda t: heavy(t) / (20.0 - lost(t)), 25.0, celsius, points=corners, epsrel=1e-11)[0]

    assert found["warmup_time_s"] == pytest.approx(took(75.0), rel=3e-4)
    final = brentq(lambda celsius: took(celsius) - 60.0, 76.0, 90.0)
    assert found["probes"]["core"]["final_degC"] == pytest.approx(final, abs=0.01)
    stored = quad(heavy, 25.0, final, points=[50.0, 55.0])[0]
    assert found["energy"]["stored_J"] == pytest.approx(stored, rel=3e-4)
    assert found["energy"]["lost_J"] == pytest.approx(1200.0 - stored, rel=1e-3)
    assert found["energy"]["imbalance_relative"] < 1e-12


def test_a_heater_that_is_turned_off(tmp_path):
    """The probe's greatest is when the power ends, the final one later; a probe that lags shows less and less late."""
    (tmp_path / "power.csv").write_text("time [s],power [W]\n0,20\n20,20\n20.001,0\n60,0\n")
    text = LUMP.replace('power = "20 W"', 'schedule = "power.csv"').replace('target = "75 degC"\n', "")
    text = text.replace("[work", '[[probe]]\nname = "late"\nlag = "5 s"\nat = ["10 mm", "10 mm", "10 mm"]\n[work')
    _, found, _ = heat(tmp_path, text)
    peak, rate = warmed(20.0), LOSS / CAPACITY
    core = found["probes"]["core"]
    assert core["max_degC"] == pytest.approx(25.0 + peak, abs=0.01)
    assert core["final_degC"] == pytest.approx(25.0 + peak * math.exp(-40.0 * rate), abs=0.01)
    # lag q' = T - q on the rise P/G (1 - e^-rt) and on the fall peak e^-rt, r the rate.
    lag, level = 5.0, 20.0 / LOSS
    shape = 1.0 / (1.0 - lag * rate)
    shown = level * (1.0 - shape * math.exp(-20.0 * rate) + (shape - 1.0) * math.exp(-20.0 / lag))
    end = peak * shape * math.exp(-40.0 * rate) + (shown - peak * shape) * math.exp(-40.0 / lag)
    assert found["probes"]["late"]["final_degC"] == pytest.approx(25.0 + end, abs=0.03)
    assert found["power_supplied_W"] == 0.0
    # Without a warm-up the efficiency is that of the end.
    assert found["efficiency"] == pytest.approx(CAPACITY * peak * math.exp(-40.0 * rate) / 400.0, rel=1e-3)
    assert "target_reached" not in found


def test_a_held_temperature_supplies_what_a_steady_mold_loses(tmp_path):
    """A bar held at 100 degC at its foot loses h A (T - 25) through a film at its end: P L / (k A) lower there."""
    text = LUMP.replace('target = "75 degC"\n', "").replace('until = "60 s"\n', "steady = true\n")
    head, _, tail = text.partition("[[heater]]")
    text = head + '[[temperature]]\non = "lump.z-"\nvalue = "100 degC"\n' + tail[tail.index("[[") :]
    _, found, _ = heat(tmp_path, text)
    lost = found["power_lost_W"]
    assert list(lost) == ["convection lump.z+"]
    assert found["power_supplied_W"] == pytest.approx(lost["convection lump.z+"], rel=1e-9)
    assert found["power_supplied_W"] > 0.0


def test_where_all_is_constant_the_temperatures_are_told_and_no_range(tmp_path):
    _, found, _ = heat(tmp_path, LUMP)
    (entry,) = found["validity"]
    assert entry["of"] == "temperature_degC"
    assert entry["used"] == pytest.approx([25.0, 25.0 + warmed(60.0)], abs=0.1)
    assert "known" not in entry


def test_a_schedule_that_ends_before_the_run_is_told(tmp_path):
    """Its last power goes on; and a power beside a schedule counts for nothing, which is said."""
    (tmp_path / "power.csv").write_text("time [s],power [W]\n0,20\n40,20\n")
    plain = heat(tmp_path, LUMP)[1]
    status, found, _ = heat(tmp_path, LUMP.replace('power = "20 W"', 'power = "1 W"\nschedule = "power.csv"'))
    (entry,) = [one for one in found["validity"] if one["of"] == "power.csv"]
    assert (entry["used"], entry["known"], entry["within"]) == ([0.0, 60.0], [0.0, 40.0], False)
    assert status == 0
    assert found["notes"] == ["heater.0: its schedule says the power, power beside it is not used"]
    assert found["probes"]["core"]["final_degC"] == pytest.approx(plain["probes"]["core"]["final_degC"], abs=0.01)


def test_a_film_table_used_beyond_its_rows_is_told(tmp_path):
    (tmp_path / "film.csv").write_text("temperature [degC],h [W/m^2/K]\n30,500\n40,500\n")
    _, found, _ = heat(tmp_path, LUMP.replace('h = "500 W/m^2/K"', 'h = { table = "film.csv" }'))
    (entry,) = found["validity"]
    assert (entry["of"], entry["known"], entry["within"]) == ("film.csv", [30.0, 40.0], False)
    assert entry["used"] == pytest.approx([25.0, 25.0 + warmed(60.0)], abs=0.1)


def test_power_is_found_for_a_wanted_warm_up(tmp_path):
    text = LUMP.replace('until = "60 s"\n', "")
    _, found, _ = heat(tmp_path, text, warmup_in="30 s")
    wanted = LOSS * 50.0 / (1.0 - math.exp(-LOSS * 30.0 / CAPACITY))
    chosen = found["design"]
    assert chosen["warmup_wanted_s"] == 30.0
    assert chosen["power_factor"] == pytest.approx(wanted / 20.0, rel=1e-3)
    assert chosen["power_W"] == pytest.approx({"heater lump.z-": wanted}, rel=1e-3)
    assert chosen["runs"] >= 1


def test_variations_of_a_lump(tmp_path):
    """Factors on film, power and specific heat, each followed for the whole time; the warm-up by the same formula."""
    (tmp_path / "factors.csv").write_text("film [-],power [-],specific heat [-]\n1,1,1\n2,1.5,0.5\n1,0.4,1\n")
    _, found, _ = heat(tmp_path, LUMP, variations=str(tmp_path / "factors.csv"))
    told = found["variations"]
    assert told["duration_s"] == 60.0
    assert told["difference_max_K"] < 0.01
    assert len(told["runs"]) == 3
    for run, (film, power, heavier) in zip(told["runs"], ((1, 1, 1), (2, 1.5, 0.5), (1, 0.4, 1)), strict=True):
        now = {"power": 20.0 * power, "loss": LOSS * film, "capacity": CAPACITY * heavier}
        assert list(run["factors"].values()) == [film, power, heavier]
        final = 25.0 + warmed(60.0, **now)
        assert run["probes_final_degC"]["core"] == pytest.approx(final, abs=0.02)
        assert run["probes_max_degC"]["core"] == pytest.approx(final, abs=0.02)
        if 20.0 * power / (LOSS * film) > 50.0 and warmup(50.0, **now) < 60.0:
            assert run["warmup_time_s"] == pytest.approx(warmup(50.0, **now), rel=1e-3)
            assert run["work_surface_mean_degC"] == pytest.approx(75.0, abs=0.02)
        else:
            assert "warmup_time_s" not in run
            assert run["work_surface_mean_degC"] == pytest.approx(final, abs=0.02)
        assert run["work_surface_spread_K"] == pytest.approx(0.0, abs=0.01)


def test_power_is_shared_so_that_a_wall_is_even(tmp_path):
    """Two equal heaters at the ends of a wall that loses heat over its top: half of it each, by symmetry."""
    text = (
        WALL.split("[[part]]")[0]
        + """
[[part]]
name = "bar"
material = "steel"
box = { origin = ["0 mm", "0 mm", "0 mm"], size = ["60 mm", "20 mm", "10 mm"] }
[[heater]]
on = "bar.x-"
power = "9 W"
[[heater]]
on = "bar.x+"
power = "3 W"
[[convection]]
on = "bar.z+"
h = "100 W/m^2/K"
ambient = "25 degC"
[work_surface]
on = "bar.z+"
[run]
start = "25 degC"
steady = true
mesh_size = "10 mm"
"""
    )
    _, found, _ = heat(tmp_path, text, share_power=True)
    chosen = found["design"]
    assert chosen["power_W"] == pytest.approx({"heater bar.x-": 6.0, "heater bar.x+": 6.0}, rel=1e-2)
    # One-dimensional fin, heated at both ends: T = q/(k m) (cosh(m x) + cosh(m (L - x)))/sinh(m L).
    m = math.sqrt(100.0 / (50.0 * 0.01))

    def rise(x, left=6.0, right=6.0):
        ends = left * math.cosh(m * (0.06 - x)) + right * math.cosh(m * x)
        return ends / (AREA * 50.0 * m * math.sinh(m * 0.06))

    assert chosen["steady_spread_K"] == pytest.approx(rise(0.0) - rise(0.03), rel=0.05)
    assert chosen["steady_mean_degC"] == pytest.approx(25.0 + 12.0 / (100.0 * 0.06 * 0.02), rel=1e-3)
    least = min(rise(0.0005 * i, 9.0, 3.0) for i in range(121))
    assert chosen["steady_spread_before_K"] == pytest.approx(rise(0.0, 9.0, 3.0) - least, rel=0.05)


@pytest.mark.parametrize(("size", "told"), [("15 mm", True), ("8 mm", False)])
def test_a_mesh_too_coarse_for_the_curves_of_a_part_says_so(tmp_path, size, told):
    """A ball of 30 mm: by its shape 4/3 pi r^3; what the mesh lacks of it lacks in mass and surface too."""
    text = (
        WALL[: WALL.index("[[part]]")]
        + f"""
[[part]]
name = "ball"
material = "steel"
ellipsoid = {{ centre = ["0 mm", "0 mm", "0 mm"], semi_axes = ["30 mm", "30 mm", "30 mm"] }}
[[heater]]
volume = "ball"
power = "9 W"
[run]
start = "25 degC"
until = "10 s"
mesh_size = "{size}"
"""
    )
    status, found, said = heat(tmp_path, text)
    off = 1.0 - found["mass_kg"] / (4.0 / 3.0 * math.pi * 0.03**3 * 7800.0)
    assert status == 0
    assert (off > 0.005) is told
    assert any("'ball'" in text and f"{100.0 * off:.2g} % less volume" in text for text in said) is told
    assert any("less volume" in text for text in found["notes"] or []) is told


#: A board for so short a time that heat has come 8 mm far: 2 sqrt(k t / rho c).
BOARD = """
format = "hyperfab.mold/1"
[material.board]
density = "1200 kg/m^3"
conductivity = "0.25 W/m/K"
specific_heat = "1000 J/kg/K"
[[part]]
name = "board"
material = "board"
box = {{ origin = ["0 mm", "0 mm", "0 mm"], size = ["30 mm", "30 mm", "60 mm"] }}
[[probe]]
name = "inside"
at = ["16 mm", "14 mm", "55 mm"]
{condition}
on = "board.z+"
[run]
start = "25 degC"
until = "60 s"
mesh_size = "{size}"
"""
DEEP = 0.005 / math.sqrt(4.0 * 0.25 / 1200.0 / 1000.0 * 60.0)


@pytest.mark.parametrize(
    ("condition", "rise", "which"),
    [
        # Carslaw and Jaeger: a semi-infinite body held by 175 K hotter, heated by 5 kW/m^2, held by 75 K colder.
        ('[[temperature]]\nvalue = "200 degC"', 175.0 * math.erfc(DEEP), "colder"),
        (
            '[[heater]]\nflux = "5000 W/m^2"',
            5000.0 / 0.25 * 0.005 * (math.exp(-(DEEP**2)) / math.sqrt(math.pi) / DEEP - math.erfc(DEEP)),
            "colder",
        ),
        ('[[temperature]]\nvalue = "-50 degC"', -75.0 * math.erfc(DEEP), "hotter"),
    ],
)
def test_elements_too_large_for_the_time_of_a_run_are_told(tmp_path, condition, rise, which):
    _, rough, said = heat(tmp_path, BOARD.format(condition=condition, size="20 mm"))
    assert len(said) == 1
    assert f"{which} at" in said[0]
    assert rough["notes"] == said
    # What is warned of is worse than a per cent of what the face goes through, what is advised is better.
    allowed = 0.01 * abs(rough["hottest"]["temperature_degC"] - rough["coldest"]["temperature_degC"])
    assert abs(rough["probes"]["inside"]["final_degC"] - 25.0 - rise) > allowed
    size = said[0].split('"')[1]
    assert size == "7.1 mm"
    _, fine, said = heat(tmp_path, BOARD.format(condition=condition, size=size), "fine")
    assert said == []
    assert fine["probes"]["inside"]["final_degC"] == pytest.approx(25.0 + rise, abs=allowed)
