"""Provenance tells what a result was made from, and nothing about the machine."""

from __future__ import annotations

from pathlib import Path

import pytest

from hyperfab import __version__
from hyperfab.documents.provenance import record, relative_name
from hyperfab.io.inputs import Inputs


def test_the_hash_is_that_of_the_bytes_that_were_read(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_bytes(b"abc")
    inputs = Inputs()
    inputs.read(str(file))
    found = record("fit", ["--uniaxial", str(file), "--model", "gent"], inputs.files, str(tmp_path / "fit.json"))
    assert found.hf == __version__
    assert found.arguments == ["--uniaxial", "a.csv", "--model", "gent"]
    # FIPS 180-2, appendix B.1
    assert found.inputs[0].sha256 == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"


def test_no_absolute_path_enters(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    outside = tmp_path / "data" / "a.csv"
    (tmp_path / "some" / "where" / "else").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "some" / "where" / "else")
    assert relative_name(str(outside), "fit.json") == "a.csv"
    assert relative_name(str(outside), str(tmp_path / "out" / "fit.json")) == "../data/a.csv"
    assert relative_name("-", "fit.json") == "-"


def test_an_option_that_looks_like_a_path_is_kept_as_typed() -> None:
    assert record("x", ["12 W/m^2/K", "60mm"], [], "build/x.json").arguments == ["12 W/m^2/K", "60mm"]
