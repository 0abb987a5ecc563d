"""A foam from its tests to the press."""

from __future__ import annotations

import json

import numpy as np
import pytest

from hyperfab.materials.hyperfoam import Hyperfoam

COLD, HOT = Hyperfoam((0.02,), (6.0,), (0.15,)), Hyperfoam((0.01,), (6.0,), (0.15,))


def _write(folder, name, test, stretch, stress, temperature=None, second=None):
    sheared = test == "simple-shear"
    head = f"# test: {test}\n# thickness: 4.5 mm\n" + (f"# temperature: {temperature} degC\n" if temperature else "")
    head += "shear strain [-],shear stress [MPa]" if sheared else "stretch [-],stress [MPa]"
    columns = [stretch, stress] + ([second] if second is not None else [])
    head += ",stretch 2 [-]\n" if second is not None else "\n"
    (folder / name).write_text(
        head + "".join(",".join(f"{v:.12g}" for v in row) + "\n" for row in zip(*columns, strict=True))
    )


@pytest.fixture(scope="module")
def foam(hf, tmp_path_factory):
    folder = tmp_path_factory.mktemp("foam")
    down, up, shear = np.linspace(1.0, 0.4, 25), np.linspace(1.0, 1.3, 16), np.linspace(-0.2, 0.2, 21)
    for law, degrees in ((COLD, 20), (HOT, 200)):
        tests = {
            "down": ("uniaxial", down),
            "up": ("uniaxial", up),
            "shear": ("simple-shear", shear),
            "plates": ("confined-compression", down),
        }
        for name, (test, stretch) in tests.items():
            second = law.lateral(test, stretch) if test == "uniaxial" else None
            _write(folder, f"{name}-{degrees}.csv", test, stretch, law.stress(test, stretch), degrees, second)
    files = [f"{name}-{degrees}.csv" for degrees in (20, 200) for name in ("down", "up", "shear", "plates")]
    run = hf("fit", *files, "--model", "hyperfoam-1", "--stable", "-o", "foam.json", cwd=folder)
    assert run.returncode == 0, run.stderr.decode()
    return folder


def test_one_law_carries_every_test_of_the_foam(foam) -> None:
    document = json.loads((foam / "foam.json").read_text())
    assert document["model"] == "hyperfoam-1"
    assert document["stable"] is document["accepted"] is True
    assert document["parameters"] == pytest.approx(COLD.parameters, rel=1e-6)
    assert document["temperatures"][1]["parameters"] == pytest.approx(HOT.parameters, rel=1e-6)
    tests = document["fit"]["tests"]
    assert set(tests) == {"uniaxial", "compression", "tension", "simple-shear", "confined-compression"}
    assert max(one["nrmse"] for one in tests.values()) < 1e-8
    assert tests["compression"]["stretch_min"] == pytest.approx(0.4)
    assert tests["tension"]["stretch_max"] == pytest.approx(1.3)
    assert {"foam.csv", "foam.png"} == set(document["files"])


@pytest.mark.slow
def test_the_press_takes_the_fitted_foam_at_its_temperature(foam, hf) -> None:
    from hyperfab.io.stl_write import stl_bytes
    from hyperfab.samples import cup

    for name, solid in (("male", cup.male_cup(16, 17)), ("female", cup.female_cup(17, 16))):
        (foam / f"{name}.stl").write_bytes(stl_bytes(solid.vertices, solid.faces))
    kept = (
        'format = "hyperfab.foam/1"\nthickness = "4.5 mm"\nexpansion = { male = "0 1/K", female = "0 1/K" }\n'
        "compression = "
    )
    own = '{ law = "hyperfoam", mu = ["0.015 MPa"], alpha = [6.0], nu = [0.15] }\n'
    (foam / "half.toml").write_text(kept + own)
    (foam / "fitted.toml").write_text(kept + '{ material = "foam.json" }\n')
    force = {}
    for sandwich, degrees in (
        ("half.toml", 20),
        ("fitted.toml", 110),
        ("fitted.toml", 250),
        ("foam.json", 110),
    ):
        run = hf("press-contact", "--male", "male.stl", "--female", "female.stl", "--foam", sandwich, "--gap", "3mm",
                 "--temperature", f"{degrees}degC", "-o", "press.json", cwd=foam)  # fmt: skip
        assert run.returncode in (0, 1), run.stderr.decode()
        force[sandwich, degrees] = json.loads((foam / "press.json").read_text())["force_N"]
        assert (b"used beyond what is known" in run.stderr) == (degrees == 250)
    # Half way between the tested temperatures its stresses are their mean; beyond, those of the hotter test.
    assert force["fitted.toml", 110] == pytest.approx(force["half.toml", 20], rel=1e-6)
    assert force["fitted.toml", 250] == pytest.approx(force["half.toml", 20] * 10.0 / 15.0, rel=1e-6)
    # Alone it is a foam without fabric, between molds of aluminium, which grow into the gap.
    assert 1.0 < force["foam.json", 110] / force["half.toml", 20] < 2.0


@pytest.mark.slow
def test_strips_too_stiff_beside_shear_for_any_isotropic_law_are_told(hf, tmp_path) -> None:
    """Two measured foams are so: their fits were bad and their loops unexplained without a word why."""
    law, stretch = Hyperfoam((0.1, 0.05), (6.0, -3.0), (0.3, 0.3)), np.linspace(0.0, 0.3, 30)
    for name, heads, at, factor in (
        ("uniaxial", "stretch [-],stress [MPa]", 1.0, 1.6),
        ("simple-shear", "shear strain [-],shear stress [MPa]", 0.0, 1.0),
    ):
        stress = factor * law.stress(name, at + stretch)
        rows = "".join(f"{a:.6g},{b:.6g}\n" for a, b in zip(at + stretch, stress, strict=True))
        (tmp_path / f"{name}.csv").write_text(f"# test: {name}\n{heads}\n{rows}")
    files = ("uniaxial.csv", "simple-shear.csv")
    fitted = hf("fit", *files, "--model", "hyperfoam-1", "-o", "foam.json", cwd=tmp_path)
    closed = hf("close-loop", "foam.json", *files, "-o", "loop.json", cwd=tmp_path)
    for run in (fitted, closed):
        assert b"E/G = 4.1, where an isotropic law has 2 (Poisson's ratio 0) to 3 (0.5)" in run.stderr


def test_a_foam_is_no_fabric(foam, hf) -> None:
    run = hf("fabric-contact", "foam.json", "--shape", "disc", "--size", "100mm", "--sphere-radius", "20mm",
             "--depth", "10mm", cwd=foam)  # fmt: skip
    assert run.returncode == 3
    assert b"the law of a foam" in run.stderr


@pytest.mark.parametrize("name", ["foam-turbo", pytest.param("foam-leap", marks=pytest.mark.slow)])
def test_a_measured_foam_is_carried_in_all_its_tests(name, data_dir, hf, tmp_path) -> None:
    files = [data_dir / name / f"{test}.csv" for test in ("compression", "tension", "simple-shear")]
    if not all(file.exists() for file in files):
        pytest.skip(f"{name} is not among the measured data")
    model = "hyperfoam-1" if name == "foam-turbo" else "hyperfoam-3"
    run = hf("fit", *files, "--model", model, "-o", "foam.json", cwd=tmp_path, timeout=600)
    assert run.returncode == 0, run.stderr.decode()
    document = json.loads((tmp_path / "foam.json").read_text())
    assert document["stable"] is True
    errors = {test: one["nrmse"] for test, one in document["fit"]["tests"].items()}
    assert max(errors.values()) <= 0.05, errors


def test_the_summary_tells_the_figure_the_foam_was_judged_by(foam, hf) -> None:
    told = hf("summary", "foam.json", cwd=foam)
    assert b"rms error 0.0 % of the largest stress" in told.stderr + told.stdout
    assert b"relative rms" not in told.stderr + told.stdout


@pytest.mark.slow
@pytest.mark.parametrize(
    ("heads", "told"),
    [
        ("displacement [mm],force [N]", True),
        ("compressive extension [mm],compressive force [N]", False),
    ],
)
def test_a_foam_that_nothing_presses_is_told(hf, tmp_path, heads, told) -> None:
    """A machine that counts pushing as positive without saying so: the block seems to be pulled."""
    stretch = np.linspace(1.0, 0.5, 12)
    rows = "\n".join(
        f"{50.0 * (1.0 - one):.6g},{2500.0 * -stress:.6g}"
        for one, stress in zip(stretch, COLD.stress("uniaxial", stretch), strict=True)
    )
    sizes = "# gauge length: 50 mm\n# width: 50 mm\n# thickness: 50 mm\n"
    (tmp_path / "block.csv").write_text(f"{sizes}{heads}\n{rows}\n")
    run = hf("fit", "--uniaxial", "block.csv", "--model", "hyperfoam-1", "-o", "block.json", cwd=tmp_path)
    assert (b"no row presses the foam" in run.stderr) is told
    if not told:
        found = json.loads((tmp_path / "block.json").read_text())["parameters"]
        assert found == pytest.approx(COLD.parameters, rel=1e-4)


def _there_and_back(stretch, stress):
    """A test loaded and, softer, unloaded."""
    return np.append(stretch, stretch[-2::-1]), np.append(stress, 0.7 * stress[-2::-1])


def test_the_loading_branch_of_every_test_is_kept_and_nothing_else(hf, tmp_path) -> None:
    tests = {
        "down": ("uniaxial", np.linspace(1.0, 0.4, 25)),
        "up": ("uniaxial", np.linspace(1.0, 1.3, 25)),
        "shear": ("simple-shear", np.linspace(0.0, 0.5, 25)),
        "back": ("simple-shear", np.linspace(0.0, -0.5, 25)),
        "plates": ("confined-compression", np.linspace(1.0, 0.4, 25)),
    }
    for name, (test, stretch) in tests.items():
        _write(tmp_path, f"{name}.csv", test, *_there_and_back(stretch, COLD.stress(test, stretch)))
    files = [f"{name}.csv" for name in tests]
    run = hf("fit", *files, "--model", "hyperfoam-1", "--branch", "load", "-o", "foam.json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr.decode()
    document = json.loads((tmp_path / "foam.json").read_text())
    assert document["parameters"] == pytest.approx(COLD.parameters, rel=1e-6)
    assert document["fit"]["tests"]["simple-shear"]["points"] == 50
    assert b"120 rows left out: not on the load branch" in run.stderr


def test_rest_is_counted_from_in_shear_and_in_compression_too(hf, tmp_path) -> None:
    """Readings that begin beside zero, and platens that come down on the block a little late."""
    shear, down = np.linspace(0.0, 0.5, 25), np.linspace(1.0, 0.4, 60)
    _write(tmp_path, "shear.csv", "simple-shear", shear + 0.07, COLD.stress("simple-shear", shear) + 3e-4)
    _write(tmp_path, "down.csv", "confined-compression", down, COLD.stress("confined-compression", down))
    run = hf("fit", "shear.csv", "down.csv", "--model", "hyperfoam-1", "--zero", "-o", "zero.json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr.decode()
    found = json.loads((tmp_path / "zero.json").read_text())["parameters"]
    assert found == pytest.approx(COLD.parameters, rel=1e-6)
    late, no = np.append(np.linspace(1.03, 1.001, 5), down), np.zeros(5)
    _write(tmp_path, "late.csv", "confined-compression", late / 1.03,
           np.append(no, COLD.stress("confined-compression", down)) * 1.03)  # fmt: skip
    run = hf("fit", "late.csv", "--model", "hyperfoam-1", "--preload", "1e-7MPa", "-o", "late.json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr.decode()
    document = json.loads((tmp_path / "late.json").read_text())
    assert document["fit"]["nrmse"] < 0.02
    assert b"slack, before the preload" in run.stderr


def test_a_block_that_does_not_widen_is_told_of_as_it_is(hf, tmp_path) -> None:
    """Where its sides were read, a Poisson's ratio of nought is told; and a flat block is no strip to pull."""
    law, stretch = Hyperfoam((0.02,), (6.0,), (0.0,)), np.linspace(1.0, 0.4, 25)
    rows = "".join(
        f"{40.0 * (a - 1.0):.9g},{40.0**2 * b:.9g},{across:.9g}\n"
        for a, b, across in zip(stretch, law.stress("uniaxial", stretch), law.lateral("uniaxial", stretch), strict=True)
    )
    sizes = "# test: uniaxial\n# gauge length: 40 mm\n# width: 40 mm\n# thickness: 40 mm\n"
    (tmp_path / "block.csv").write_text(sizes + "extension [mm],force [N],stretch 2\n" + rows)
    run = hf("fit", "block.csv", "--model", "hyperfoam-1", "-o", "block.json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr.decode()
    assert b"times as long as wide" not in run.stderr
    assert b"not told" not in run.stderr
    assert json.loads((tmp_path / "block.json").read_text())["parameters"]["nu1"] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(("power", "told"), [(0.0, True), (-0.5, True), (-1.1, False), (-2.0, False)])
def test_a_plateau_that_no_stable_law_has_is_told(power, told) -> None:
    """Stress as a power of the stretch: in logarithmic strains it must grow faster than 1 / stretch."""
    from hyperfab.chapters.fit.hyperfoam import plateau
    from hyperfab.curve import TestCurve

    down = np.linspace(1.0, 0.4, 60)
    rise = -np.expm1(-(1.0 - down) / 0.02)
    curve = TestCurve("uniaxial", down, -0.01 * rise * down**power, source="block.csv")
    assert bool(plateau([curve])) is told
    back = TestCurve(
        "uniaxial",
        np.append(down, down[::-1]),
        np.append(curve.stress, 0.3 * curve.stress[::-1]),
        source="block.csv",
    )
    assert bool(plateau([back])) is told
    assert bool(plateau([curve.take(np.arange(60)[::-1])])) is told


def test_scatter_on_a_low_plateau_is_no_plateau_that_falls() -> None:
    from hyperfab.chapters.fit.hyperfoam import plateau
    from hyperfab.curve import TestCurve

    down, random = np.linspace(1.0, 0.3, 80), np.random.default_rng(3)
    stress = 0.004 * -np.expm1(-(1.0 - down) / 0.03) * down**-1.3 + 0.03 * (1.0 - down) ** 8
    for _ in range(20):
        noisy = stress + 0.015 * stress.max() * random.standard_normal(80)
        assert plateau([TestCurve("uniaxial", down, -noisy, source="block.csv")]) is None


@pytest.mark.slow
def test_a_plateau_that_no_law_has_is_pressed_as_the_table_that_is_named(hf, tmp_path) -> None:
    """Raw blocks whose force falls behind a peak: the table and command that hf fit names bear what was measured."""
    from hyperfab.io.stl_write import stl_bytes
    from hyperfab.samples.cup import plate

    def stress(e):  # MPa: a peak, a plateau that falls by a tenth, densification
        return 0.004 * (-np.expm1(-e / 0.02) - 0.2 * e) + 1e-4 * (e / (1.0 - e)) ** 3

    random = np.random.default_rng(5)
    e = np.concatenate([np.linspace(0.0, 0.7, 400), np.linspace(0.7, 0.0, 400)])
    for name in ("one", "two"):
        force = 2500.0 * stress(e) * np.repeat([1.0, 0.6], 400) + 0.1 * random.standard_normal(800)
        head = f"# test: uniaxial\n# specimen: {name}\n# gauge length: 25 mm\n# width: 50 mm\n# thickness: 50 mm\n"
        rows = "".join(f"{-25.0 * a:.9g},{-b:.9g}\n" for a, b in zip(e, force, strict=True))
        (tmp_path / f"{name}.csv").write_text(f"{head}extension [mm],force [N]\n{rows}")
    words = ("one.csv", "two.csv", "--model", "hyperfoam-1", "--branch", "load")
    run = hf("fit", *words, "-o", "pu.json", cwd=tmp_path)
    assert b"no stable law has a plateau so flat" in run.stderr
    document = json.loads((tmp_path / "pu.json").read_text())
    assert set(document["files"]) == {"pu.compression.csv", "pu.csv", "pu.png"}
    said = " ".join(run.stderr.decode().split())
    law = said[said.index("compression = {") : said.index(" and thickness =")]
    command = said[said.index("hf press-contact") :].split(" --gap 3mm")[0].split()
    (tmp_path / "foam.toml").write_text(f'format = "hyperfab.foam/1"\nthickness = "4 mm"\n{law}\n')
    for name, solid in (("m", plate(-30.0, 0.0)), ("f", plate(10.0, 40.0))):
        (tmp_path / f"{name}.stl").write_bytes(stl_bytes(solid.vertices, solid.faces))
    for gap in (3.6, 2.8, 1.6):
        pressed = hf(*command[1:], "--gap", f"{gap}mm", "-o", "press.json", cwd=tmp_path)
        assert pressed.returncode == 0, pressed.stderr.decode()
        found = json.loads((tmp_path / "press.json").read_text())
        assert found["pressure_max_MPa"] == pytest.approx(stress(1.0 - gap / 4.0), rel=0.03)


def test_a_table_of_several_loadings_is_their_mean_and_never_falls() -> None:
    from hyperfab.chapters.fit.hyperfoam import table_of
    from hyperfab.curve import TestCurve

    down = np.linspace(1.0, 0.3, 700)
    curves = [TestCurve("uniaxial", down, -share * (1.0 - down)) for share in (0.9, 1.1)]
    strain, stress, levelled = table_of(curves, "uniaxial")
    assert stress == pytest.approx(strain, abs=2e-3)
    assert (strain[-1], levelled) == (pytest.approx(0.7, abs=0.01), pytest.approx(0.0, abs=1e-12))
    humped = TestCurve("uniaxial", down, -np.sin(4.0 * (1.0 - down)))
    assert (np.diff(table_of([humped], "uniaxial")[1]) >= 0.0).all()
    assert table_of([humped], "uniaxial")[2] > 0.2


def test_a_foam_is_cut_into_blocks_and_strips_of_any_thickness(hf, tmp_path) -> None:
    down, up = np.linspace(1.0, 0.4, 25), np.linspace(1.0, 1.3, 25)
    rows = "".join(
        f"{50.0 * (a - 1.0):.9g},{2500.0 * b:.9g}\n" for a, b in zip(down, COLD.stress("uniaxial", down), strict=True)
    )
    sizes = "# test: uniaxial\n# gauge length: 50 mm\n# width: 50 mm\n# thickness: 50 mm\n"
    (tmp_path / "block.csv").write_text(f"{sizes}extension [mm],force [N]\n{rows}")
    _write(tmp_path, "strip.csv", "uniaxial", up, COLD.stress("uniaxial", up))
    run = hf("fit", "block.csv", "strip.csv", "--model", "hyperfoam-1", "-o", "foam.json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr.decode()
    document = json.loads((tmp_path / "foam.json").read_text())
    assert document["parameters"] == pytest.approx(COLD.parameters, rel=1e-6)
    assert "thickness_mm" not in document  # neither is that of the foam in the press


def test_blocks_and_strips_of_a_foam_tell_how_sure_its_constants_are(tmp_path, hf) -> None:
    """Three pressed, three pulled, each stiffer than the mean by a share of its own; of one of each nothing is known
    of how specimens scatter, and what the readings leave is told."""
    gains, files = (0.95, 1.0, 1.05), []
    for name, stretch in (("down", np.linspace(0.97, 0.4, 20)), ("up", np.linspace(1.02, 1.3, 15))):
        for number, gain in enumerate(gains):
            files.append(f"{name}{number}.csv")
            stress = gain * COLD.stress("uniaxial", stretch)
            _write(tmp_path, files[-1], "uniaxial", stretch, stress, second=COLD.lateral("uniaxial", stretch))
    run = hf("fit", *files, "--model", "hyperfoam-1", "-o", "foam.json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr.decode()
    assert b"takes no part" not in run.stderr  # the lateral stretch does
    document = json.loads((tmp_path / "foam.json").read_text())
    fit, known = document["fit"], document["fit"]["uncertainty"]
    assert (known["source"], known["specimens"], known["degrees_of_freedom"]) == ("specimens", 6, 4)
    assert fit["parameters_sd"].keys() == document["parameters"].keys()
    # Both kinds together as far apart as either: 5 % of three, and the mean of six is surer than one of them.
    assert 0.05 / np.sqrt(6.0) < fit["parameters_sd"]["mu1_MPa"] / COLD.mu[0] < 0.05
    assert fit["parameters_sd"]["nu1"] < 1e-3
    assert 1.0 < fit["condition_number"] < 10.0
    assert [(one["test"], one["specimens"]) for one in document["replicates"]] == [("uniaxial", 3)] * 2
    assert hf("fit", "down1.csv", "up1.csv", "--model", "hyperfoam-1", "-o", "two.json", cwd=tmp_path).returncode == 0
    two = json.loads((tmp_path / "two.json").read_text())["fit"]["uncertainty"]
    assert (two["source"], two["specimens"]) == ("readings", 2)


def test_a_gauge_length_read_short_makes_no_test_in_tension(hf, tmp_path) -> None:
    foam = Hyperfoam((0.02,), (6.0,), (0.15,))
    true = np.linspace(1.0, 0.5, 400)
    stretch = 1.004 * true
    _write(tmp_path, "down.csv", "uniaxial", stretch, foam.stress("uniaxial", true))
    assert (stretch > 1.0).sum() > 2
    run = hf("fit", "down.csv", "--model", "hyperfoam-1", "-o", "foam.json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr.decode()
    tests = json.loads((tmp_path / "foam.json").read_text())["fit"]["tests"]
    assert set(tests) == {"uniaxial"}
    assert tests["uniaxial"]["nrmse"] < 0.01
