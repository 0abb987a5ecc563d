"""Cards in Abaqus' convention mean the same law to a solver that reads them: CalculiX stretches one brick."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from hyperfab.materials.export import Settings, formats
from tests.materials.test_export import FOAMS, law_of

pytestmark = pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")

STRETCH = 1.8
#: Laws CalculiX can read. It has no Marlow law (gent, arruda-boyce-langevin).
READ = sorted(formats()["abaqus"].writers.keys() - {"gent", "arruda-boyce-langevin"})
BRICK = """*NODE, NSET=ALL
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
*ELEMENT, TYPE=C3D8, ELSET=BRICK
1, 1, 2, 3, 4, 5, 6, 7, 8
*NSET, NSET=HELD
1, 4, 5, 8
*NSET, NSET=PULLED
2, 3, 6, 7
*NSET, NSET=SIDE
1, 2, 5, 6
*NSET, NSET=BOTTOM
1, 2, 3, 4
"""
PULL = f"""*SOLID SECTION, ELSET=BRICK, MATERIAL=fabric
*BOUNDARY
HELD, 1, 1
SIDE, 2, 2
BOTTOM, 3, 3
*STEP, NLGEOM, INC=100
*STATIC
0.1, 1.0
*BOUNDARY
PULLED, 1, 1, {STRETCH - 1.0}
*NODE PRINT, NSET=PULLED, TOTALS=ONLY
RF
*END STEP
"""


def nominal_stress(folder, law, bulk_modulus):
    """Force on the pulled face of the unit brick [N], equal to the nominal stress [MPa]."""
    settings = Settings(bulk_modulus=bulk_modulus)
    folder.mkdir()
    (folder / "brick.inp").write_text(BRICK + formats()["abaqus"].card(law, settings) + PULL)
    subprocess.run(["ccx", "brick"], cwd=folder, check=True, capture_output=True, timeout=60)
    totals = (folder / "brick.dat").read_text().split("total force")[-1].splitlines()
    return float(next(line for line in totals[1:] if line.strip()).split()[0])


@pytest.mark.parametrize("name", READ)
def test_calculix_finds_our_uniaxial_stress_on_the_card(name, tmp_path):
    law = law_of(name)
    ours = float(law.uniaxial(STRETCH).P)
    if name.startswith("blatz-ko"):
        assert nominal_stress(tmp_path / "foam", law, None) == pytest.approx(ours, rel=1e-6)
        return
    # The card's finite bulk modulus K costs O(1/K) of the stress: two of them lead to the incompressible limit.
    soft, hard = (nominal_stress(tmp_path / f"K{K}", law, K) for K in (500.0, 1000.0))
    assert 2.0 * hard - soft == pytest.approx(ours, rel=1e-5)


@pytest.mark.parametrize("name", FOAMS)
def test_calculix_finds_the_stress_of_a_foam(name, tmp_path):
    law = FOAMS[name]
    ours = float(law.stress("uniaxial", [STRETCH])[0])
    assert nominal_stress(tmp_path / "foam", law, None) == pytest.approx(ours, rel=1e-6)
