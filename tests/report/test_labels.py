"""Names that end in their unit, as people read them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from hyperfab.documents.base import KINDS, document_class
from hyperfab.report.labels import parted

#: What a unit begins with, as a name has it.
_UNIT = {"N", "MPa", "mm", "mm2", "K", "J", "W", "s", "kg", "degC", "deg", "m2", "m2K", "kN", "g"}


def _names(schema: Any) -> Iterator[str]:
    if isinstance(schema, dict):
        for key, value in schema.items():
            if key == "properties":
                yield from value
            yield from _names(value)
    elif isinstance(schema, list):
        for one in schema:
            yield from _names(one)


@pytest.mark.parametrize("kind", KINDS)
def test_a_unit_of_a_document_is_read_as_a_whole(kind: str) -> None:
    names = {name: parted(name) for name in _names(document_class(kind).model_json_schema())}
    torn = {name: told for name, told in names.items() if told[1] and told[0].split()[-1] in _UNIT}
    assert torn == {}


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("slip_mm2_N", ("slip", "mm²/N")),
        ("back_W_K", ("back", "W/K")),
        ("compliance_mm_kN", ("compliance", "mm/kN")),
        ("activation_J_mol", ("activation", "J/mol")),
        ("drift_K_s2", ("drift", "K/s²")),
    ],
)
def test_a_unit_of_a_constant_is_read_as_a_whole(name: str, told: tuple[str, str]) -> None:
    assert parted(name) == told
