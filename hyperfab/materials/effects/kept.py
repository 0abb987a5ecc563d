"""The last few answers of what is asked again and again with much the same constants."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hyperfab.arrays import Array

#: How many answers are kept.
_MOST = 12


class Kept:
    """The last few answers, arrays that nobody may change, each by all that it depends on.

    >>> import numpy as np
    >>> answers, asked = Kept(), []
    >>> for constant in (1.0, 2.0, 1.0):
    ...     _ = answers.of((constant,), lambda: asked.append(constant) or (np.zeros(3),))
    >>> asked
    [1.0, 2.0]
    """

    def __init__(self) -> None:
        self._answers: dict[tuple[object, ...], tuple[Array | None, ...]] = {}

    def of(self, key: tuple[object, ...], make: Callable[[], tuple[Array | None, ...]]) -> Any:
        """Return the answer of a ``key``, made where it is not among those kept."""
        found = self._answers.get(key)
        if found is None:
            if len(self._answers) >= _MOST:
                del self._answers[next(iter(self._answers))]
            found = self._answers[key] = make()
            for one in found:
                if one is not None:
                    one.setflags(write=False)
        return found
