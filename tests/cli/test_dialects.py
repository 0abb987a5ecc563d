"""However a testing machine writes a test, the constants are the same."""

from __future__ import annotations

import codecs
import json
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT, Run

MODES = ("uniaxial", "shear", "biaxial")


def rows(mode: str) -> list[tuple[str, str]]:
    """The readings as they are written in the sample: stretch, stress [MPa]."""
    lines = (ROOT / f"specimens/treloar-1944/{mode}.csv").read_text().splitlines()
    cells = [line.split(",") for line in lines if line and line[0].isdigit()]
    return [(cell[0], cell[1]) for cell in cells]


def constants(hf: Run, folder: Path, texts: dict[str, bytes]) -> dict[str, Any]:
    folder.mkdir()
    for mode, data in texts.items():
        (folder / f"{mode}.csv").write_bytes(data)
    options = [f"--{mode}={mode}.csv" for mode in texts]
    done = hf("fit", *options, "--model", "ogden-2", cwd=folder)
    assert done.returncode in (0, 1), done.stderr.decode()
    document: dict[str, Any] = json.loads(done.stdout)
    del document["provenance"]
    return document


def plain(mode: str) -> bytes:
    return "".join(["stretch [-],stress [MPa]\n", *(f"{a},{b}\n" for a, b in rows(mode))]).encode()


def test_an_export_gives_the_constants_of_its_plain_twin_bit_for_bit(hf: Run, tmp_path: Path) -> None:
    def export(mode: str) -> bytes:
        lines = ["# Prüfer: Jörg Weiß", "STRESS;Nr;Stretch", "[MPa];;[-]"]
        lines += [f"{b};{number};{a}".replace(".", ",") for number, (a, b) in enumerate(rows(mode), 1)]
        return codecs.BOM_UTF8 + "\r\n".join([*lines, ""]).encode("latin-1")

    twin = constants(hf, tmp_path / "a", {mode: plain(mode) for mode in MODES})
    found = constants(hf, tmp_path / "b", {mode: export(mode) for mode in MODES})
    for document in (twin, found):  # the export has a column more, and that is said
        document.pop("preparation", None)
    assert found == twin


def test_psi_and_inches_give_the_constants_to_1e_12(hf: Run, tmp_path: Path) -> None:
    def imperial(mode: str) -> bytes:
        # 1 psi is 4.4482216152605 N on a square inch of 25.4 mm
        psi = 25.4**2 / 4.4482216152605
        lines = [f"{2.0 * (float(a) - 1.0)!r},{float(b) * psi!r}" for a, b in rows(mode)]
        return "\n".join(["# gauge length: 2 inch", "extension [in],stress [psi]", *lines, ""]).encode()

    metric = constants(hf, tmp_path / "a", {mode: plain(mode) for mode in MODES})["parameters"]
    found = constants(hf, tmp_path / "b", {mode: imperial(mode) for mode in MODES})["parameters"]
    assert found == pytest.approx(metric, rel=1e-12)
