"""The same six files give the same hot fabric through a fit and through the loop."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.stats import t as student

from hyperfab.chapters.fabric import FabricDocument
from hyperfab.documents.material import MaterialDocument

STRETCH = 1.4


@pytest.mark.slow
def test_a_fit_and_the_loop_agree_within_the_fits_interval_at_every_tested_temperature(hf, root, tmp_path):
    files = sorted((root / "specimens/lycra").glob("*.csv"))
    cold = [file for file in files if "23C" in file.name]
    for name, tests in (("six.json", files), ("cold.json", cold)):
        done = hf("fit", *tests, "--model", "yeoh-3", "--quiet", "-o", name, cwd=tmp_path)
        assert done.returncode == 0, done.stderr.decode()
    measured = [word for file in files for word in ("--measured", file)]
    done = hf("close-loop", "cold.json", *measured, "--quiet", "-o", "loop.json", cwd=tmp_path, timeout=600)
    assert done.returncode == 0, done.stderr.decode()
    six, loop = (
        MaterialDocument.model_validate(json.loads((tmp_path / name).read_text()))
        for name in ("six.json", "loop.model.json")
    )
    for way in ("warp", "weft"):
        assert six.directions is not None
        for row in six.directions[way].temperatures or []:
            asked = row.temperature_degC
            one, other = (
                float(FabricDocument(document, "a", asked).material(way).uniaxial(STRETCH).P)
                for document in (six, loop)
            )
            assert row.fit is not None
            assert row.fit.uncertainty is not None
            # The stress is linear in the constants of Yeoh's law.
            I1 = STRETCH**2 + 2.0 / STRETCH - 3.0
            rates = 2.0 * (STRETCH - STRETCH**-2) * np.array([1.0, 2.0 * I1, 3.0 * I1**2])
            sd = np.sqrt(rates @ np.array(row.fit.uncertainty.covariance) @ rates)
            half = student.ppf(0.975, row.fit.uncertainty.degrees_of_freedom) * sd
            assert half < 0.08 * one
            assert abs(other - one) < half, (way, asked, one, other, half)
