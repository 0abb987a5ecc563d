"""The mark of terms beside which something stays unexplained: in the extended model, and in words."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from hyperfab.loop.engine import Finding


def mark(records: Iterable[dict[str, Any]], found: Finding) -> None:
    """Mark the terms of a model's ``effects`` that were added though something stays unexplained; unmark all where
    nothing does."""
    for record in records:
        if found.verdict != "unexplained":
            record.pop("tentative", None)
        elif record.get("id") in found.after.ids:
            record["tentative"] = True


def caution(found: Finding) -> str:
    """Return what is to be said of a model with such terms; empty where it has none."""
    if found.verdict != "unexplained" or not found.after.ids:
        return ""
    names = list(found.after.ids)
    are = "are the nearest" if len(names) > 1 else "is the nearest"
    return (
        f"{', '.join(names)} {are} that the catalogue has, though something stays unexplained: constants of the "
        "extended model may stand for what is not in it, and it is no better than these data beyond them"
    )


def noted(text: str, toml: bytes) -> bytes:
    """Return a TOML document with ``text`` as a comment at its head.

    >>> noted("take care", b"a = 1"), noted("", b"a = 1")
    (b'# take care\\na = 1', b'a = 1')
    """
    return f"# {text}\n".encode() + toml if text else toml
