"""However a testing machine writes a test, the constants are the same."""

from __future__ import annotations

import codecs
import json
from pathlib import Path
from typing import Any

import machine_exports
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
        document["setup"].pop("sha256")
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


def test_files_of_machines_stand_as_plain_arguments_and_give_the_constants_of_their_twins(
    hf: Run, tmp_path: Path
) -> None:
    """A twin in force and extension, and machines' exports of the same pull: the same constants and figures."""
    machines = {
        "k17.csv": machine_exports.bluehill3_spanish(),
        "zwick.txt": machine_exports.testxpert2(),
        "b.csv": machine_exports.bluehill2(),
    }
    (tmp_path / "twin.csv").write_text(machine_exports.plain_force())
    for name, data in machines.items():
        (tmp_path / name).write_bytes(data)
    law = ("--model", "yeoh-3", "-o")
    assert hf("fit", "twin.csv", *law, "twin.json", cwd=tmp_path).returncode == 0
    twin = json.loads((tmp_path / "twin.json").read_text())
    for name in machines:
        done = hf("fit", name, *law, "found.json", cwd=tmp_path)
        assert done.returncode == 0, done.stderr.decode()
        found = json.loads((tmp_path / "found.json").read_text())
        assert found["parameters"] == twin["parameters"]
        assert found["fit"] == twin["fit"]
        [read] = [line for line in found["preparation"] if line.startswith(f"{name}: head in line")]
        assert read in done.stderr.decode()
        assert "width 50 mm" in read
    # Beside k17.csv a document k17.json finds its place.
    assert hf("fit", "k17.csv", *law, "k17.json", cwd=tmp_path).returncode == 0
    assert {"k17.json", "k17.out.csv"} <= {path.name for path in tmp_path.iterdir()}


def test_the_loop_reads_as_the_fit_does(hf: Run, tmp_path: Path) -> None:
    """A bare export with its sizes as options, and the plain file: the same finding, to the digit."""
    pull = [(f"{k / 100:.2f}", f"{k / 100 + (k / 100) ** 2:.6f}") for k in range(1, 31)]
    raw = [(machine_exports.shifted(e, 2), machine_exports.times(s, 25)) for e, s in pull]
    head = "# test: uniaxial\n# gauge length: 100 mm\n# width: 50 mm\n# thickness: 0.5 mm\nextension [mm],force [N]\n"
    (tmp_path / "plain.csv").write_text(head + "".join(f"{x},{f}\n" for x, f in raw))
    bare = ["Lab 3;;", "", "Weg;Kraft;Bemerkung", "mm;N;", *(f"{x};{f};".replace(".", ",") for x, f in raw)]
    (tmp_path / "bare.csv").write_text("\n".join([*bare, "Mittelwert;3;"]))
    law = ("--model", "neo-hookean", "--accept", "9", "-o", "m.json")
    assert hf("fit", "plain.csv", *law, cwd=tmp_path).returncode == 0
    sizes = ("--gauge-length", "100mm", "--width", "50mm", "--thickness", "0.5mm")
    noise = ("--noise", "0.5kPa", "-o", "-")
    refused = hf("close-loop", "m.json", "bare.csv", *noise, cwd=tmp_path)
    assert refused.returncode == 3
    assert "--uniaxial bare.csv" in refused.stderr.decode()
    one = hf("close-loop", "m.json", "plain.csv", *noise, cwd=tmp_path)
    other = hf("close-loop", "m.json", "--uniaxial", "bare.csv", *sizes, *noise, cwd=tmp_path)
    first, second = json.loads(one.stdout), json.loads(other.stdout)
    for key in ("verdict", "effects", "constants", "error", "noise"):
        assert first[key] == second[key]
    assert any("Kraft is force [N]" in line for line in second["preparation"])
    chosen = hf("close-loop", "m.json", "--uniaxial", "bare.csv", *sizes, "--preload", "2N", *noise, cwd=tmp_path)
    assert any("slack taken out" in line for line in json.loads(chosen.stdout)["preparation"])
