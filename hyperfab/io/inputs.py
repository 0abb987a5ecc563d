"""The files a command reads: each read once, whole, and known by the hash of the very bytes that were used."""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import stat
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from hyperfab.errors import InputError
from hyperfab.io.json_io import load_json
from hyperfab.io.toml_io import load_toml
from hyperfab.io.xlsx import split_sheet
from hyperfab.system import AT_ONCE, BINARY, wait_for_bytes

Parsed = TypeVar("Parsed")

#: No input of the toolchain is larger; a device or a runaway pipe must not fill the memory.
MAX_BYTES = 256 * 2**20
#: The line by which a TOML document says what it is, and no JSON does.
_TOML = re.compile(rb"^(?:\xef\xbb\xbf)?[ \t]*format[ \t]*=", re.MULTILINE)
#: The marks of text in UTF-16, which has zero bytes as a surface or a picture has.
_UTF16 = (b"\xff\xfe", b"\xfe\xff")


@dataclass(frozen=True)
class InputFile:
    """One file that was read: its name as given, and the SHA-256 of its bytes."""

    name: str
    sha256: str


class Inputs:
    """Reads input files and remembers what was read, for ``provenance``.

    >>> import tempfile, os
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "a.csv")
    ...     _ = open(path, "w").write("1")
    ...     inputs = Inputs()
    ...     inputs.read(path), len(inputs.files)
    (b'1', 1)
    """

    def __init__(self) -> None:
        self._files: dict[str, InputFile] = {}
        self._stdin: bytes | None = None

    @property
    def files(self) -> list[InputFile]:
        """What was read so far, in order, each file once."""
        return list(self._files.values())

    @property
    def given(self) -> Mapping[str, bytes]:
        """Files that do not lie on disk, by name: none."""
        return {}

    def plain(self, name: str) -> Any:
        """Return the plain data of a JSON or a TOML document, told apart by how it says what it is where the name
        does not; InputError where it is none.
        """
        data = self.read(name)
        toml = name.endswith(".toml") or _TOML.search(data)
        if b"\x00" in data[:2048] and not data.startswith(_UTF16):
            raise InputError("is no text, so no document", file=name, remedy="give a document that a command wrote")
        return load_toml(data, name) if toml else load_json(data, name)

    def parsed(self, name: str, kind: object, parse: Callable[[Any], Parsed]) -> Parsed:
        """Return the document of a ``kind`` that ``parse`` makes of the plain data of a file."""
        return parse(self.plain(name))

    def read(self, name: str, limit: int = MAX_BYTES) -> bytes:
        """Return the bytes of file ``name``; ``-`` is standard input, ``FILE.xlsx:SHEET`` the workbook.

        Raises InputError where the file is missing, a folder, unreadable, or larger than ``limit`` bytes.
        """
        if name == "-":
            return self._read_stdin(limit)
        name, _ = split_sheet(name)
        try:
            # A named pipe nobody writes to must not hang the command while it is opened.
            descriptor = os.open(name, os.O_RDONLY | AT_ONCE | BINARY)
            try:
                found = os.fstat(descriptor)
                if stat.S_ISDIR(found.st_mode):
                    raise InputError("is a folder, not a file", file=name, remedy="name a file in it")
                if found.st_size > limit:
                    raise _too_large(name, limit)
                wait_for_bytes(descriptor)
                with os.fdopen(descriptor, "rb", closefd=False) as stream:
                    data = stream.read(limit + 1)
            finally:
                os.close(descriptor)
        except FileNotFoundError as error:
            raise InputError("no such file", file=name, remedy=_nearby(name)) from error
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise InputError(
                f"cannot be read: {reason}", file=name, remedy="check the path and its permissions"
            ) from error
        return self._take(name, data, limit)

    def _read_stdin(self, limit: int) -> bytes:
        if self._stdin is None:
            if sys.stdin is None or sys.stdin.closed:
                raise InputError("is closed", file="-", remedy="pipe a document into the command")
            self._stdin = self._take("-", sys.stdin.buffer.read(limit + 1), limit)
        return self._stdin

    def _take(self, name: str, data: bytes, limit: int) -> bytes:
        if len(data) > limit:
            raise _too_large(name, limit)
        self._files.setdefault(name, InputFile(name, hashlib.sha256(data).hexdigest()))
        return data

    @staticmethod
    def beside(document: str, relative: str) -> str:
        """Return the path of a file that ``document`` names: relative names count from the document's folder."""
        if document == "-" or os.path.isabs(relative):
            return relative
        return os.path.normpath(os.path.join(os.path.dirname(document), relative))


def _too_large(name: str, limit: int) -> InputError:
    return InputError(
        f"is larger than {limit // 2**20} MiB", file=name, remedy="split or thin it out; nothing was read"
    )


def _nearby(name: str) -> str:
    """Suggest files of the same kind in the folder that was asked for."""
    folder = Path(name).parent
    found: list[str] = []
    with contextlib.suppress(OSError, ValueError):
        found = sorted(entry.name for entry in folder.iterdir() if entry.suffix == Path(name).suffix)[:3]
    return f"the folder has {', '.join(found)}" if found else "check the path"
