"""Pictures left blank: most tests run a command for its figures, and to draw its picture would be most of the wait.

All that a picture holds is put into it, from the same values; what draws it (labels measured out, lines made pixels)
is left out. Tests that look at a picture ask for it with ``@pytest.mark.pictures``, and one in eight of the others
draws too, at the size of a stamp; the pages of docs/ and whatever else begins from nothing (tests/faults,
tests/test_readme.py) draw whole ones.
"""

from __future__ import annotations

import os
import zlib
from typing import Any

import pytest
from matplotlib.figure import Figure
from PIL import Image

#: Set in the environment where pictures are drawn, in commands of their own too: ``whole``, or as a ``stamp``.
DRAWN = "TEST_PICTURES"


def drawn(item: pytest.Item) -> str | None:
    """Return how the pictures of a test are drawn."""
    if item.get_closest_marker("pictures") or item.get_closest_marker("slow"):
        return "whole"
    return "stamp" if zlib.crc32(item.nodeid.encode()) % 8 == 0 else None


def blanked() -> None:
    """Draw pictures as :data:`DRAWN` says from now on."""
    whole = Figure.savefig

    def save(figure: Figure, target: Any, **options: Any) -> None:
        how = os.environ.get(DRAWN)
        if how is None:
            Image.new("L", (8, 8)).save(target, "PNG")
            return
        if how == "stamp":
            figure.set_layout_engine("none")
            options["dpi"] = 12
        whole(figure, target, **options)

    Figure.savefig = save  # type: ignore[method-assign]
