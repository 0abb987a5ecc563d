"""Every form and constant of the catalogue is explained to users, and every entry stands in the tables."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import hyperfab.loop.catalogue as catalogue

ENTRIES = sorted(
    path
    for path in Path(catalogue.__file__).parent.glob("*/*.py")
    if path.name not in ("__init__.py", "scene.py")
)
DOCS = Path(__file__).parents[2] / "docs"
#: Names that are put together from others: written out on the page.
_MADE_UP = re.compile(r"[{}]")


@pytest.mark.parametrize("path", ENTRIES, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_the_page_of_laws_explains(path: Path) -> None:
    page = (DOCS / "close-loop-laws.md").read_text()
    text = path.read_text()
    assert f"`{path.stem.replace('_', '-')}`" in page
    names = re.findall(r'(?:Form|Constant|branch)\(\s*f?"([^"]+)"', text)
    assert names
    missing = [name for name in names if not _MADE_UP.search(name) and name not in page]
    assert not missing


@pytest.mark.parametrize("path", ENTRIES, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_the_tables_of_entries_are_whole(path: Path) -> None:
    page = "close-loop.md" if path.parent.name in ("fabric", "heat") else "close-loop-shapes.md"
    assert f"| `{path.stem.replace('_', '-')}` |" in (DOCS / page).read_text()
