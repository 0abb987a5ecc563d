"""A curve is looked at before models: what no specimen gives is told, what every test shows draws no word."""

from __future__ import annotations

import numpy as np
import pytest

from hyperfab.arrays import Array
from hyperfab.numerics.doubt import Doubt
from hyperfab.numerics.hygiene import branches, cycles, look, turns


def pull(count: int = 240, seed: int = 0, noise: float = 0.003) -> tuple[np.ndarray, np.ndarray]:
    """A stiffening pull to a stretch of 1.5 with the noise of a load cell and of an extensometer."""
    rng = np.random.default_rng(seed)
    way = np.linspace(0.0, 0.5, count)
    stress = 0.3 * (np.exp(2.0 * way) - 1.0)
    peak = stress[-1]
    return 1.0 + way + 1e-4 * rng.standard_normal(count), stress + noise * peak * rng.standard_normal(count)


def kinds(found: list[Doubt]) -> set[str]:
    return {doubt.kind for doubt in found}


@pytest.mark.parametrize("count", [8, 25, 240, 3000])
@pytest.mark.parametrize("noise", [0.0, 0.002, 0.01])
def test_a_noisy_pull_draws_no_remark(count: int, noise: float) -> None:
    for seed in range(12):
        stretch, stress = pull(count, seed, noise)
        assert look(stretch, stress) == []


def test_noise_of_the_load_cell_at_rest_draws_no_remark() -> None:
    stretch, stress = pull()
    rng = np.random.default_rng(5)
    rest = 0.003 * stress.max() * rng.standard_normal(30)
    assert look(np.concatenate([np.ones(30), stretch]), np.concatenate([rest, stress])) == []


def test_a_coarse_reading_is_no_saturation() -> None:
    stretch, stress = pull(400, noise=0.0)
    assert look(stretch, np.round(stress / stress.max() * 20.0)) == []


def test_an_extensometer_that_slips_is_told_by_its_row() -> None:
    stretch, stress = pull()
    stretch = np.where(np.arange(240) >= 120, stretch - 0.03, stretch)
    [found] = look(stretch, stress)
    assert (found.kind, found.rows) == ("step-back", (120,))
    assert found.size == pytest.approx(0.03 / np.ptp(stretch), rel=0.1)


@pytest.mark.parametrize("row", [3, 21])
def test_two_steps_on_either_side_are_enough_to_tell_a_slip(row: int) -> None:
    """Two whole steps before the slip, or two after it. One alone could be the end of an unloading."""
    stretch, stress = pull(24, noise=0.0)
    stretch = np.where(np.arange(24) >= row, stretch - 0.035, stretch)
    [found] = look(stretch, stress)
    assert (found.kind, found.rows) == ("step-back", (row,))
    assert "step-back" not in kinds(look(stretch[row - 2 :], stress[row - 2 :]))
    assert "step-back" not in kinds(look(stretch[: row + 2], stress[: row + 2]))


@pytest.mark.parametrize("count", [60, 240])
def test_a_slip_is_told_however_the_readings_beside_it_scatter(count: int) -> None:
    """One noisy reading beside the slip neither hides it in one file of three, nor makes one of a curve retraced."""
    told = retraced = 0
    for seed in range(50):
        stretch, stress = pull(count, seed, noise=0.006)
        slipped = np.where(np.arange(count) >= 2 * count // 3, stretch - 0.03, stretch)
        told += kinds(look(slipped, stress)) == {"step-back"}
        back = np.concatenate([np.arange(2 * count // 3), np.arange(2 * count // 3 - count // 15, count)])
        noise = 0.006 * stress.max() * np.random.default_rng(100 + seed).standard_normal(len(back))
        clean = pull(count, seed, noise=0.0)[1]
        retraced += "step-back" in kinds(look(stretch[back], clean[back] + noise))
    assert told == 50
    assert retraced == 0


def test_small_unloadings_in_mid_pull_are_no_slip() -> None:
    way = np.concatenate([np.linspace(0.0, 0.3, 100), np.linspace(0.3, 0.25, 12), np.linspace(0.25, 0.5, 90)])
    assert look(1.0 + way, way**2 + way) == []


def test_a_load_cell_at_its_range_is_told() -> None:
    stretch, stress = pull(noise=0.001)
    top = 0.8 * stress.max()
    [found] = look(stretch, np.minimum(stress, top))
    assert found.kind == "saturation"
    assert found.rows[0] == int(np.argmax(stress >= top))
    # By the clock of a crosshead too; what slows down under one load creeps.
    [found] = look(stretch, np.minimum(stress, top), time=np.linspace(0.0, 60.0, len(stretch)))
    assert found.kind == "saturation"
    beyond = np.maximum(stretch - stretch[found.rows[0]], 0.0) / (stretch[-1] - stretch[found.rows[0]])
    creeping = np.linspace(0.0, 60.0, len(stretch)) + np.expm1(8.0 * beyond)
    assert look(stretch, np.minimum(stress, top), time=creeping) == []


def test_a_load_cell_at_its_range_is_told_in_every_cycle() -> None:
    """The rows of a second pull were kept as readings, and the law bent for them."""
    stretch, stress = pull(noise=0.001)
    way, force = np.tile(np.r_[stretch, stretch[::-1]], 2), np.tile(np.r_[stress, stress[::-1]], 2)
    top = 0.8 * stress.max()
    [found] = [one for one in look(way, np.minimum(force, top)) if one.kind == "saturation"]
    assert found.rows == tuple(np.flatnonzero(force >= top).tolist())


def test_rows_in_which_a_camera_lost_its_marks_are_told_and_no_others() -> None:
    """Those given as 0 were told as one slip of an extensometer, and all behind the first was left out."""
    stretch, stress = pull()
    rows = [70, 120, 121, 122, 200]
    for value in (1.0, 0.0):
        zeros = stretch.copy()
        zeros[rows] = value
        [found] = look(zeros, stress)
        assert (found.kind, found.rows) == ("lost", tuple(rows))
    last = stretch.copy()
    for row in rows:
        last[row] = last[row - 1]
    [found] = look(last, stress)
    assert (found.kind, found.rows) == ("lost", tuple(rows))
    # What else is odd is told by its own rows still.
    zeros[rows] = 1.0
    spiked = stress.copy()
    spiked[150] += 0.2 * stress.max()
    assert [(one.kind, one.rows) for one in look(zeros, spiked)] == [("lost", tuple(rows)), ("spike", (150,))]


def test_a_stretch_that_stands_for_another_reason_is_not_lost() -> None:
    """A coarse scale at an uneven clock, a scale slower than the log, steps that are held, a step and its way back."""
    rng = np.random.default_rng(3)
    stretch, stress = pull(noise=0.0)
    uneven = 1.0 + 0.5 * np.cumsum(rng.uniform(0.5, 1.5, 240)) / 240.0
    for way in (np.round(uneven, 3), np.round(stretch, 2), stretch[np.arange(240) // 3 * 3]):
        assert "lost" not in kinds(look(way, stress))
    stairs = 1.0 + 0.1 * (np.arange(60) // 10)
    assert "lost" not in kinds(look(stairs, stairs - 1.0 + 0.01 * np.exp(-(np.arange(60) % 10))))
    # The stress goes along: the specimen was there.
    step = np.where(np.arange(240) == 120, 1.0, stretch)
    assert "lost" not in kinds(look(step, 0.3 * (np.exp(2.0 * (step - 1.0)) - 1.0)))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_spike_and_a_slip_in_the_grips_are_told_apart(sign: float) -> None:
    stretch, stress = pull()
    spiked = stress.copy()
    spiked[100] += sign * 0.2 * stress.max()
    [found] = look(stretch, spiked)
    assert (found.kind, found.rows) == ("spike", (100,))
    slipped = np.where(np.arange(240) >= 150, stress - 0.1 * stress.max(), stress)
    [found] = look(stretch, slipped)
    assert (found.kind, found.rows) == ("drop", (150,))


def test_rows_that_stand_twice_are_told() -> None:
    stretch, stress = pull()
    twice = look(np.tile(stretch, 2), np.tile(stress, 2))
    assert twice[0].kind == "doubled"
    assert twice[0].rows == tuple(range(240, 480))
    assert look(np.repeat(stretch, 2), np.repeat(stress, 2))[0].kind == "doubled"


def test_rows_written_again_at_the_same_time_are_told_from_three_on() -> None:
    """A logger that writes a row twice; two such rows may be chance, where the reading is coarse."""
    stretch, stress = pull()
    time = np.linspace(0.0, 60.0, 240)
    for again in ((50, 120, 200), (50, 120)):
        columns = np.insert(
            np.stack([stretch, stress, time]), again, np.stack([stretch, stress, time])[:, again], axis=1
        )
        found = [doubt for doubt in look(columns[0], columns[1], time=columns[2]) if doubt.kind == "doubled"]
        rows = tuple(row + k + 1 for k, row in enumerate(again))
        assert [doubt.rows for doubt in found] == ([rows] if len(again) == 3 else [])


def test_a_stress_before_the_pull_is_told() -> None:
    stretch, stress = pull()
    rest = np.full(20, 0.05 * stress.max())
    [found] = look(np.concatenate([np.ones(20), stretch]), np.concatenate([rest, stress + rest[0]]))
    assert found.kind == "offset"


def test_loading_unloading_and_cycles_are_told_with_their_distance() -> None:
    up = np.linspace(0.0, 0.5, 50)
    way = np.concatenate([up, up[::-1], up, up[::-1], up, up[::-1]])
    stress = np.concatenate([f * (up if k % 2 == 0 else up[::-1]) for k, f in enumerate((1, 0.7, 0.9, 0.7, 0.85, 0.7))])
    found = {doubt.kind: doubt for doubt in look(1.0 + way, stress)}
    assert set(found) == {"unloading", "cycles"}
    assert found["cycles"].size == pytest.approx(0.075, rel=0.1)  # 15 % of a line's mean, half its peak
    number = cycles(1.0 + way)
    assert [int((number == k).sum()) for k in (1, 2, 3)] == [100, 100, 100]
    assert (branches(1.0 + way)[:50] == 1).all()


def test_pulls_at_several_rates_are_told_with_their_rates() -> None:
    up = np.linspace(0.0, 0.5, 50)
    way, stress = np.concatenate([up, up]), np.concatenate([up, 1.2 * up])
    time = np.concatenate([up / 0.01, 60.0 + up / 0.5])
    [found] = look(1.0 + way, stress, time=time)
    assert found.text.endswith("; they were pulled at 0.01 and 0.5 1/s")
    [found] = look(1.0 + way, stress, time=np.arange(100.0))
    assert "pulled" not in found.text


def test_a_loss_too_small_to_matter_draws_no_remark() -> None:
    up = np.linspace(0.0, 0.5, 50)
    way = np.concatenate([up, up[::-1]])
    assert look(1.0 + way, way * np.where(np.arange(100) < 50, 1.0, 0.99)) == []


def test_a_hold_is_no_turn() -> None:
    way = np.concatenate([np.linspace(1.0, 1.5, 40), np.full(200, 1.5)])
    assert turns(way) == [slice(0, 240)]
    assert (branches(way) == 1).all()


def test_compression_is_loading_too() -> None:
    way = np.concatenate([np.linspace(1.0, 0.4, 40), np.linspace(0.4, 1.0, 40)])
    assert (branches(way)[:40] == 1).all()
    assert (branches(way)[41:] == -1).all()


def test_a_held_axis_is_looked_at_along_the_other() -> None:
    across, stress = pull()
    assert look(np.ones(240), stress, stretch2=across) == []


def held(seed: int, count: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """A pull to 1.5 that is held and relaxes by a half."""
    rng = np.random.default_rng(seed)
    way = np.concatenate([np.linspace(1.0, 1.5, 40), np.full(count, 1.5)])
    stress = np.concatenate([np.linspace(0.0, 1.0, 40), 0.5 + 0.5 * np.exp(-np.arange(count) / 6.0)])
    return way, stress + 0.004 * rng.standard_normal(40 + count)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("seed", range(4))
def test_a_glitch_of_two_rows_in_a_hold_is_told_and_what_relaxes_is_not(seed: int, sign: float) -> None:
    stretch, stress = held(seed)
    assert "spike" not in kinds(look(stretch, sign * stress))
    stress[[70, 71]] = -0.4, 0.1
    [found] = [one for one in look(stretch, sign * stress) if one.kind == "spike"]
    assert found.rows == (70, 71)


def test_a_knock_on_every_tenth_row_of_a_hold_is_noise() -> None:
    stretch, stress = held(0)
    stress[45::6] += 0.3
    assert "spike" not in kinds(look(stretch, stress))


@pytest.mark.parametrize("rows", [1, 3])
def test_a_first_row_that_reads_what_no_row_behind_it_does_is_no_offset(rows: int) -> None:
    stretch, stress = pull(noise=0.001)
    stretch, stress = np.concatenate([np.ones(rows), stretch]), np.concatenate([np.zeros(rows), stress])
    assert look(stretch, stress) == []
    stress[0] = 5.0 * stress.max()
    [found] = look(stretch, stress)
    assert (found.kind, found.rows) == ("spike", (0,))
    assert found.size == pytest.approx(5.0, rel=1e-2)
    # One that is there in all rows at rest is an offset still.
    taut = np.concatenate([np.full(3, 0.2 * stress[1:].max()), stress[rows:]])
    assert kinds(look(np.concatenate([np.ones(3), stretch[rows:]]), taut)) == {"offset"}


@pytest.mark.parametrize("noise", [0.0, 0.004])
@pytest.mark.parametrize("begun", [0.08, 0.4, 4.0])
def test_a_stretch_that_was_not_set_to_zero_is_told(begun: float, noise: float) -> None:
    stretch, stress = pull(noise=noise)
    [found] = look(stretch + begun, stress)
    assert (found.kind, found.rows) == ("unzeroed", (0,))
    assert "--zero" in found.remedy


def test_a_curve_whose_first_points_lack_is_counted_from_its_rest() -> None:
    strain = np.linspace(0.1, 0.6, 60)
    for stiffening in (0.1, 3.0, 15.0):
        assert look(1.0 + strain, np.exp(stiffening * strain) - 1.0) == []
    # A knit that is slack at first carries next to nothing there.
    assert look(1.0 + strain, 1e-3 * strain + np.maximum(strain - 0.2, 0.0) ** 2) == []


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("noise", [0.0, 0.004])
def test_a_specimen_that_tears_layer_by_layer_is_told_from_its_peak_on(sign: float, noise: float) -> None:
    way = np.linspace(0.0, 1.0, 101)
    rng = np.random.default_rng(3)
    stress = np.minimum(way / 0.7, 1.0 - 1.2 * (way - 0.7)) + noise * rng.standard_normal(101)
    [found] = look(1.0 + sign * 0.6 * way, sign * stress)
    assert found.kind == "failing"
    assert abs(found.rows[0] - 71) <= 2
    assert found.rows[-1] == 100
    assert found.size == pytest.approx(0.36, abs=0.03)
    # A plateau that dips and climbs again, a relaxation and a softer second cycle are none.
    assert look(1.0 + 0.6 * way, way + 0.2 * np.sin(3.0 * np.pi * way)) == []
    assert "failing" not in kinds(look(*held(0)))
    creeping = 1.0 + np.concatenate([0.5 * way, 0.5 + 0.02 * way[1:]])
    relaxing = np.concatenate([way, 0.6 + 0.4 * np.exp(-4.0 * way[1:])])
    told = kinds(look(1.0 + sign * (creeping - 1.0), sign * relaxing, time=np.arange(201.0)))
    assert "failing" not in told
    again = np.concatenate([way, way[::-1], way])
    softer = again * np.repeat([1.0, 0.8, 0.7], 101)
    assert "failing" not in kinds(look(1.0 + again * np.repeat([1.0, 1.0, 1.001], 101), softer))


def test_a_test_that_is_pressed_and_then_pulled_tears_nowhere() -> None:
    """A rubber from half its length to twice: the largest stress is the first, and all that follows is larger."""
    stretch = np.linspace(0.49, 2.17, 40)
    assert look(stretch, 0.3 * (stretch - stretch**-2)) == []
    assert look(stretch[::-1], 0.3 * (stretch - stretch**-2)[::-1]) == []
    torn = 0.3 * (stretch - stretch**-2) * np.where(stretch > 1.8, 1.0 - 2.5 * (stretch - 1.8), 1.0)
    assert "failing" not in kinds(look(stretch, torn))  # what is pressed carries more
    assert "failing" in kinds(look(stretch[12:], torn[12:]))


def ramp_and_hold(rows: int, dt: float) -> tuple[Array, Array, Array]:
    """Time (n,), stretch (n,) of a fast ramp to 3 whose crosshead swings past its stop, and a stress that relaxes."""
    time = dt * np.arange(rows)
    stop = 100 * dt
    past = np.where(time > stop, 0.04 * np.exp(-(time - stop) / (2 * dt)) * np.sin((time - stop) / (2 * dt)), 0.0)
    stretch = 1.0 + 2.0 * np.minimum(time / stop, 1.0) + past
    elastic = 0.5 * (np.minimum(stretch, 3.0) - np.minimum(stretch, 3.0) ** -2)
    return time, stretch, elastic * np.where(time > stop, 0.6 + 0.4 * np.exp(-(time - stop) / (20 * dt)), 1.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_machine_that_rings_at_its_start_and_stop_is_told_and_what_relaxes_is_not(sign: float) -> None:
    time, stretch, stress = ramp_and_hold(300, 0.02)
    assert not [doubt for doubt in look(stretch, sign * stress, time=time) if doubt.kind in ("ringing", "drop")]
    since = np.arange(7.0)
    swing = 0.35 * np.exp(-since / 4.0) * np.cos(np.pi * since / 2.0)
    rung = stress.copy()
    rung[2:9] += swing
    rung[102:109] -= swing
    found = {doubt.kind: doubt for doubt in look(stretch, sign * rung, time=time)}
    [told] = [found[kind] for kind in ("ringing", "drop") if kind in found]
    assert told.kind == "ringing"
    assert set(np.flatnonzero(np.abs(rung - stress) > 0.1)) <= set(told.rows)
    assert all(1 <= row < 13 or 100 <= row < 113 for row in told.rows)


def test_steps_of_a_hand_with_waits_between_are_no_ringing() -> None:
    draw = np.random.default_rng(5)
    stretch = 1.0 + 0.1 * np.repeat(np.arange(1.0, 13.0), 4)
    time = np.cumsum(np.tile([1.0, 2.0, 4.0, 8.0], 12))
    relaxed = np.tile([1.2, 1.1, 1.04, 1.0], 12)
    stress = (stretch - stretch**-2) * relaxed * (1.0 + draw.normal(0.0, 0.005, 48))
    assert not [doubt for doubt in look(stretch, stress, time=time) if doubt.kind == "ringing"]


@pytest.mark.parametrize("noise", [0.002, 0.02])
def test_fast_cycles_do_not_ring(noise: float) -> None:
    draw = np.random.default_rng(6)
    time = 0.05 * np.arange(400.0)
    stretch = 1.0 + 0.5 * np.abs((time / 5.0) % 2.0 - 1.0)
    loading = np.gradient(stretch) > 0.0
    stress = (stretch - stretch**-2) * np.where(loading, 1.0, 0.7) + noise * draw.normal(size=400)
    assert not [doubt for doubt in look(stretch, stress, time=time) if doubt.kind == "ringing"]


@pytest.mark.parametrize("resolution", [0.0, 0.013])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_hangs_on_the_load_cell_is_told_where_fast_cycles_turn(sign: float, resolution: float) -> None:
    time = 0.02 * np.arange(460.0)
    turn = 4.0
    phase = (time / turn) % 2.0
    # A crosshead turns within some rows.
    stretch = 1.0 + 0.44 * np.convolve(np.pad(1.0 - np.abs(phase - 1.0), 1, mode="edge"), [0.25, 0.5, 0.25], "valid")
    up = np.gradient(stretch) > 0.0
    stress = (stretch - stretch**-2) * np.where(up, 1.0, 0.95)
    read = stress.copy()
    for row, push in ((199, -1.0), (399, 1.0)):  # it slows down in the row in which it still goes on
        read[row : row + 3] += 0.15 * stress.max() * push * np.array([0.95, 1.0, 0.25])

    def coarse(values: Array) -> Array:
        step = resolution * stress.max()
        return values if step == 0.0 else step * np.round(values / step)

    assert not [one for one in look(stretch, sign * coarse(stress), time=time) if one.kind == "ringing"]
    [told] = [one for one in look(stretch, sign * coarse(read), time=time) if one.kind == "ringing"]
    assert {199, 200, 201, 399, 400, 401} <= set(told.rows)
    assert all(197 <= row < 206 or 397 <= row < 406 for row in told.rows)


def test_an_axis_that_is_drawn_in_while_the_other_is_pulled_does_not_tear() -> None:
    """A weave pulled along the weft twice as hard: the warp shortens, and at the greatest load less than on the way."""
    weft = 1.0 + 0.05 * np.concatenate([np.linspace(0.0, 1.0, 30), np.linspace(1.0, 0.0, 30)[1:]])
    load = (weft - 1.0) / 0.05
    warp = 1.0 - 0.04 * load * (1.0 - 0.7 * load) * np.repeat([1.0, 1.02], [30, 29])
    said = {doubt.kind for doubt in look(warp, 10.0 * load, stretch2=weft, time=np.arange(59.0))}
    assert not said & {"failing", "cycles", "unloading"}
