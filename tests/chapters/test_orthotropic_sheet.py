"""One energy for the sheet, from its tests to the sphere and the mold."""

from __future__ import annotations

import json

import numpy as np
import pytest

from hyperfab.materials.orthotropic import Orthotropic
from hyperfab.materials.orthotropic.specimen import held, strip

KNIT = {
    "C10_MPa": 0.05, "C20_MPa": 0.01, "k1_warp_MPa": 0.08, "k2_warp": 0.3, "k1_weft_MPa": 0.02, "k2_weft": 0.1,
    "nu": 0.4, "G_MPa": 0.03,
}  # fmt: skip
LAM = np.linspace(1.02, 1.5, 14)


def _write(folder, name, test, direction, stretch, stress, second=None):
    head = f"# test: {test}\n# thickness: 0.6 mm\n" + (f"# direction: {direction}\n" if direction else "")
    columns = "stretch,stress [MPa]" + (",stretch 2" if second is not None else "")
    rows = zip(stretch, stress, *([second] if second is not None else []), strict=True)
    text = head + columns + "\n" + "\n".join(",".join(f"{float(v):.12g}" for v in row) for row in rows) + "\n"
    (folder / name).write_text(text)


@pytest.fixture(scope="module")
def fitted(hf, tmp_path_factory):
    folder = tmp_path_factory.mktemp("sheet")
    law = Orthotropic.of(KNIT)
    for name, angle in (("warp", 0.0), ("weft", 90.0), ("45 deg", 45.0)):
        pulled = strip(law, angle, LAM)
        width = pulled.width if angle != 45.0 else None
        _write(folder, f"{name.split()[0]}.csv", "uniaxial", name, LAM, pulled.stress, width)
    run = hf("fit", "--uniaxial", "warp.csv", "--uniaxial", "weft.csv", "--uniaxial", "45.csv", "--model",
             "orthotropic", "--stable", "-o", "sheet.json", cwd=folder, timeout=600)  # fmt: skip
    assert run.returncode == 0, run.stderr.decode()
    return folder


def test_the_document_carries_the_sheet_and_what_its_tests_leave_open(fitted):
    document = json.loads((fitted / "sheet.json").read_text())
    assert document["model"] == "orthotropic"
    assert document["accepted"] is True
    assert document["stable"] is True
    for name, value in KNIT.items():
        assert document["parameters"][name] == pytest.approx(value, rel=1e-5)
    assert {one["constant"] for one in document["undetermined"]} == {"C2_MPa"}
    assert set(document["directions"]) == {"warp", "weft", "45 deg"}
    for one in document["directions"].values():
        assert one["fit"]["nrmse"] < 1e-6
        seen = one["fit"]["tests"]["uniaxial"]
        assert (seen["stretch_min"], seen["stretch_max"]) == (1.0, LAM[-1])
        # Looked at from rest to three times the data, or where no test went, to three times rest.
        for mode, reach in {"uniaxial": 3.0 * LAM[-1], "shear": 3.0, "biaxial": 3.0}.items():
            stable = one["stability"][mode]
            assert stable["stretch_min"] == 1.0
            if stable["ended_by"] == "scan":
                assert stable["stretch_max"] == pytest.approx(reach)
            assert LAM[-1] < stable["stretch_max"] < reach + 1e-9
    # The weft's constants are the sheet's turned by a quarter.
    assert document["directions"]["weft"]["parameters"]["k1_warp_MPa"] == pytest.approx(0.02, rel=1e-5)


def test_a_test_of_another_mode_is_predicted(fitted, hf):
    law = Orthotropic.of(KNIT)
    _write(fitted, "strip.csv", "shear", "warp", LAM, held(law, 0.0, LAM, np.ones_like(LAM))[0])
    run = hf("fit", "--uniaxial", "warp.csv", "--uniaxial", "weft.csv", "--uniaxial", "45.csv", "--shear", "strip.csv",
             "--fit-on", "uniaxial", "--model", "orthotropic", "-o", "-", cwd=fitted, timeout=600)  # fmt: skip
    assert run.returncode == 0, run.stderr.decode()
    shear = json.loads(run.stdout)["fit"]["tests"]["shear"]
    assert shear["predicted"] is True
    assert shear["nrmse"] < 1e-5


@pytest.mark.slow
def test_biaxial_tests_without_a_direction_tell_the_threads_of_their_axes(hf, tmp_path):
    """Protocols of a sheet as labs write them: two stretches, two stresses, and no word of a warp."""
    law = Orthotropic.of({**KNIT, "G_MPa": 0.0})
    q = np.linspace(0.02, 0.4, 14)
    for name, one, two in (("1-1", 1.0, 1.0), ("2-1", 1.0, 0.5), ("1-2", 0.5, 1.0), ("strip", 1.0, 0.0)):
        x, y = 1.0 + one * q, 1.0 + two * q
        rows = zip(x, y, *held(law, 0.0, x, y)[:2], strict=True)
        body = "".join(",".join(f"{float(v):.12g}" for v in row) + "\n" for row in rows)
        head = "Stretch X,Stretch Y,Membrane stress X (N/mm),Membrane stress Y (N/mm)\n"
        (tmp_path / f"{name}.csv").write_text(head + body)
    files = sorted(path.name for path in tmp_path.iterdir())
    run = hf("fit", *files, "--model", "orthotropic", "-o", "-", cwd=tmp_path, timeout=600)
    assert run.returncode == 0, run.stderr.decode()
    document = json.loads(run.stdout)
    said = "no direction is stated, the first axis is taken as the warp"
    assert said in document["preparation"][-1]
    assert said in run.stderr.decode()
    assert {one["constant"] for one in document["undetermined"]} == {"G_MPa"}
    for name in ("k1_warp_MPa", "k1_weft_MPa", "C10_MPa", "nu"):
        assert document["parameters"][name] == pytest.approx(KNIT[name], rel=1e-4)


def test_the_sphere_and_the_net_obey_it(fitted, hf, root):
    run = hf("fabric-contact", "sheet.json", "--shape", "square", "--size", "200mm", "--sphere-radius", "40mm",
             "--depth", "30mm", "--mesh-size", "12mm", "-o", "contact.json", cwd=fitted, timeout=600)  # fmt: skip
    assert run.returncode == 0, run.stderr.decode()
    contact = json.loads((fitted / "contact.json").read_text())
    assert contact["converged"] is True
    depth, force = np.array(contact["force_depth"]).T
    assert (np.diff(force[depth > 0.0]) > 0.0).all()
    assert any("C2_MPa" in text for text in contact["left_out"])
    run = hf("drape", "sheet.json", "--mold", root / "molds" / "cup-male.stl", "--grid", "21x21",
             "--size", "220mmx220mm", "--depth", "20mm", "-o", "drape.json", cwd=fitted, timeout=600)  # fmt: skip
    assert run.returncode == 0, run.stderr.decode()
    assert json.loads((fitted / "drape.json").read_text())["converged"] is True


def test_the_springs_of_a_net_follow_the_strips_of_the_sheet():
    from hyperfab.cloth.law import spring_law
    from hyperfab.materials.orthotropic.specimen import Along

    law = Orthotropic.of(KNIT)
    for angle in (0.0, 90.0):
        spring = spring_law(Along(law, angle))
        np.testing.assert_allclose(spring(LAM)[1], strip(law, angle, LAM).stress, rtol=1e-6)
