"""Pictures at the size of a stamp: most tests run a command for its figures, and its picture would be most of the wait.

All that a picture holds is drawn, from the same values; only the room for labels is not measured out, which draws it
twice, and there are few pixels. Tests that look at a picture ask for the whole one with ``@pytest.mark.pictures``; the
pages of docs/ and whatever else begins from nothing (tests/faults, tests/test_readme.py) draw none other.
"""

from __future__ import annotations

import os
from typing import Any

from matplotlib.figure import Figure

#: Set in the environment where pictures are to be whole, in commands of their own too.
WHOLE = "TEST_PICTURES_WHOLE"


def stamped() -> None:
    """Save pictures small from now on, unless :data:`WHOLE` is set."""
    whole = Figure.savefig

    def save(figure: Figure, target: Any, **options: Any) -> None:
        if WHOLE not in os.environ:
            figure.set_layout_engine("none")
            options["dpi"] = 12
        whole(figure, target, **options)

    Figure.savefig = save  # type: ignore[method-assign]
