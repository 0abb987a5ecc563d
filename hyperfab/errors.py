"""Everything that can go wrong, each with the exit status it ends the command with."""

from __future__ import annotations

import contextlib
import difflib
from collections.abc import Iterable, Iterator


class HyperfabError(Exception):
    """Base of all errors that are told to the user in one message, without a traceback."""

    exit_status = 70


class UsageError(HyperfabError):
    """The command was called in a way it cannot mean: exit status 2."""

    exit_status = 2


class InputError(HyperfabError):
    """An input file or document is wrong: exit status 3.

    The message names the place (file, then line, column, key or facet) and the way out.

    >>> print(InputError("not a number: 'abc'", file="warp.csv", line=7, column="stress",
    ...                  remedy="correct the cell or delete the row"))
    warp.csv, line 7, column "stress": not a number: 'abc'; correct the cell or delete the row
    """

    exit_status = 3

    def __init__(
        self,
        message: str,
        *,
        file: str | None = None,
        line: int | None = None,
        column: str | None = None,
        key: str | None = None,
        facet: int | None = None,
        remedy: str | None = None,
    ) -> None:
        places = [] if file is None else ["standard input" if file == "-" else _shown(file)]
        quoted = None if column is None else f'"{column}"'
        named = [("line", line), ("column", quoted), ("key", key), ("facet", facet)]
        places += [f"{name} {value}" for name, value in named if value is not None]
        text = f"{', '.join(places)}: {message}" if places else message
        super().__init__(f"{text}; {remedy}" if remedy else text)
        self.message = message
        self.file = file
        self.line = line
        self.column = column
        self.key = key
        self.facet = facet
        self.remedy = remedy


@contextlib.contextmanager
def placed(file: str | None = None, key: str | None = None, remedy: str | None = None) -> Iterator[None]:
    """Give errors of readers and of the physics, which know no files, their place.

    A ``remedy`` is that of errors without one; where it is given, a ValueError too becomes an error of the file.
    """
    try:
        yield
    except InputError as error:
        if error.file is not None:
            raise
        raise InputError(
            error.message,
            file=file,
            line=error.line,
            column=error.column,
            key=error.key or key,
            facet=error.facet,
            remedy=error.remedy or remedy,
        ) from None
    except ValueError as error:
        if remedy is None:
            raise
        raise InputError(str(error), file=file, key=key, remedy=remedy) from None


def _shown(name: str) -> str:
    """A name of thousands of characters would hide what is said about it."""
    return name if len(name) <= 200 else f"{name[:100]}...{name[-50:]}"


class NotConverged(HyperfabError):
    """No solution was found, or the constants are unstable where they were used: exit status 4."""

    exit_status = 4

    def __init__(self, message: str, *, remedy: str | None = None) -> None:
        super().__init__(f"{message}; {remedy}" if remedy else message)
        self.remedy = remedy


class OutputError(HyperfabError):
    """The output could not be written: exit status 5. What was there before is still there."""

    exit_status = 5


def near(word: str, known: Iterable[str]) -> str:
    """Return ``did you mean X?`` for a misspelt ``word``, or nothing.

    >>> near("yeoh3", ["gent", "yeoh-2", "yeoh-3"]), near("mooney", ["gent", "mooney-rivlin-2"]), near("x", ["gent"])
    ('did you mean yeoh-3?', 'did you mean mooney-rivlin-2?', '')
    """
    names = {name.casefold().replace("-", "").replace("_", ""): name for name in reversed(list(known))}
    plain = word.casefold().replace("-", "").replace("_", "")
    begun = [name for name in names if len(plain) > 2 and name.startswith(plain)][-1:]
    found = difflib.get_close_matches(plain, names, 1, 0.7) or begun
    return f"did you mean {names[found[0]]}?" if found else ""
