"""A case and the words of a command line: the only place that takes them apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any, TypeVar

from hyperfab.cases.case import Case, tolerances
from hyperfab.errors import UsageError

CaseT = TypeVar("CaseT", bound=Case)


def given(cls: type[Case], words: Sequence[str]) -> dict[str, Any]:
    """Return the options that ``words`` give, by field name, as people write them.

    Raises UsageError where an option is unknown or lacks its value.
    """
    settings = cls.settings()
    named = {one.option: one for one in settings.values() if not one.argument}
    places = [one for one in settings.values() if one.argument]
    found: dict[str, Any] = {}

    def put(name: str, value: Any, repeated: bool) -> None:
        found[name] = [*found.get(name, []), value] if repeated else value

    rest = list(words)
    alone = False
    while rest:
        word = rest.pop(0)
        if word == "--" and not alone:
            alone = True
            continue
        option, mark, value = word.partition("=")
        if alone or not word.startswith("-") or word == "-":
            if not places:
                raise UsageError(f"hf {cls.COMMAND} takes no argument {word!r}")
            one = places[0] if places[0].kind.repeated else places.pop(0)
            put(one.name, word, one.kind.repeated)
        elif option.startswith("--no-") and f"--{option[5:]}" in named:
            found[named[f"--{option[5:]}"].name] = False
        elif option not in named:
            near = get_close_matches(option, named, 1)
            meant = f"; {near[0]} may be meant" if near else ""
            raise UsageError(f"hf {cls.COMMAND} has no option {option}{meant}")
        elif not named[option].metavar:
            found[named[option].name] = True
        else:
            if not mark and not rest:
                raise UsageError(f"{option} needs a value: {option} {named[option].metavar}")
            put(named[option].name, value if mark else rest.pop(0), named[option].kind.repeated)
    return found


def shown(cls: type[Case], found: Mapping[str, Any]) -> list[str]:
    """Return options that are given as words again, in the order of the help page."""
    words: list[str] = []
    for one in cls.settings().values():
        if one.name not in found:
            continue
        value = found[one.name]
        for item in value if isinstance(value, (list, tuple)) else [value]:
            if isinstance(item, bool):
                words.append(one.option if item else f"--no-{one.option[2:]}")
            else:
                words += [item] if one.argument else [one.option, item]
    return words


def read(cls: type[CaseT], words: Sequence[str]) -> CaseT:
    """Return the case of a command's words."""
    return cls.of(given(cls, words))


def words(case: Case) -> list[str]:
    """Return the shortest words that give the case: ``read`` takes them back to it."""
    found: list[str] = []
    for one in case.settings().values():
        value = getattr(case, one.name)
        if value is None or (not one.required and value == one.default and not tolerances(value, one.key)):
            continue
        if isinstance(value, bool):
            found.append(one.option if value else f"--no-{one.option[2:]}")
            continue
        texts = one.kind.words(value)
        for text in texts if one.kind.repeated else [texts]:
            found += [text] if one.argument else [one.option, text]
    return found
