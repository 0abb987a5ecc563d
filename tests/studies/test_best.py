"""The best case of a study is the best by what the study wants of a figure."""

from __future__ import annotations

from types import SimpleNamespace

from hyperfab.chapters.sweep.result import _best, _senses
from hyperfab.documents.study import LimitSection, ParetoSection
from hyperfab.studies.table import Table


def test_contact_to_be_maximised_is_best_where_it_is_most() -> None:
    columns = {
        "case": ["a", "b", "c"],
        "status": [0, 1, 0],
        "force_N": [3.0, 1.0, 2.0],
        "contact_fraction": [0.9, 0.5, 0.7],
        "stretch": [1.3, 1.2, 1.4],
        "gap_mm": [2.0, 3.0, 4.0],
        "energy_J": [1.0, 3.0, 2.0],
    }
    table = Table(columns, {}, [name for name in columns if name not in ("case", "status")])
    study = SimpleNamespace(
        pareto=ParetoSection(minimize=["force_N"], maximize=["contact_fraction"]),
        limit={
            "stretch": LimitSection(most=1.5),
            "gap_mm": LimitSection(least=1.0),
            "energy_J": LimitSection(least=0.0, most=9.0),
        },
    )
    senses = _senses(SimpleNamespace(study=study), table)
    assert senses == {
        "force_N": "least", "contact_fraction": "greatest", "stretch": "least", "gap_mm": "greatest",
    }  # fmt: skip
    best = _best(table, senses)
    assert {name: row["case"] for name, row in best.items()} == {
        "force_N": "b", "contact_fraction": "a", "stretch": "b", "gap_mm": "c", "energy_J": "a",
    }  # fmt: skip
