"""A command's output: one JSON document, and its fields, curves and pictures beside it under the same stem."""

from __future__ import annotations

import contextlib
import json
import os
import re
from collections.abc import Sequence
from fnmatch import fnmatchcase
from glob import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hyperfab.errors import OutputError, UsageError
from hyperfab.io.atomic import write_files
from hyperfab.io.cells import is_number
from hyperfab.io.json_io import dump_json

if TYPE_CHECKING:
    from hyperfab.io.inputs import Inputs


#: What stands before the ending of a sibling whose own name is an input: ``k17.out.csv`` beside ``k17.csv``.
BESIDE_INPUT = ".out"
#: So much of a file is searched for a row of numbers.
_LOOKED_AT = 65536


class Output:
    """Collects what a command writes and writes it at the end: all files whole, the document last.

    ``target`` is ``NAME.json``, or ``-`` for standard output (then no other file is written); a name without an
    ending gets ``.json``; what goes to ``/dev/null`` is not kept. ``suffixes`` are the endings of the siblings the
    command may write (``.vtu``, ``.csv``, ``.png``), as patterns where their number is not known (``.*.vtu``).

    The place is tried at construction, before anything is computed: a folder that is missing or cannot be written is
    an OutputError. An output that is also an input is a UsageError as soon as both are known, at the latest before
    anything is written; only ``NAME.csv`` gives way to an input of its name, or to a table that hf did not write (the
    log that a mold of this name was measured with), and becomes ``NAME.out.csv``.
    """

    def __init__(self, target: str, suffixes: Sequence[str] = ()) -> None:
        if target not in ("-", os.devnull):
            if os.path.exists(target) and not os.path.isfile(target) and not os.path.isdir(target):
                raise UsageError(f"--output {target}: is a device and takes no files; write - for standard output")
            if not Path(target).suffix and not os.path.isdir(target):
                target += ".json"
        self.target = target
        self._siblings: dict[str, bytes] = {}
        self._suffixes = tuple(suffixes)
        if not self.wants_files:
            return
        if Path(target).suffix != ".json":
            raise UsageError(
                f"--output {target}: the document's name ends in .json; write {Path(target).stem or 'result'}.json"
            )
        check_place(target)

    @property
    def wants_files(self) -> bool:
        """Whether siblings are written: not where the document goes to standard output or nowhere."""
        return self.target not in ("-", os.devnull)

    @property
    def names(self) -> list[str]:
        """Names of the siblings queued so far."""
        return [self.path(suffix).name for suffix in self._siblings]

    def path(self, suffix: str) -> Path:
        """Return the path of the sibling with ``suffix``: ``out/drape.json`` and ``.vtu`` give ``out/drape.vtu``."""
        target = Path(self.target)
        return target.with_name(target.stem + suffix)

    def refuse_inputs(self, inputs: Inputs) -> None:
        """Refuse to overwrite a file that was read (also through a link, also by a sibling that may be written)."""
        if not self.wants_files:
            return
        self._refuse(Path(self.target), inputs)
        folder, stem = Path(self.target).parent, Path(self.target).stem
        for suffix in self._suffixes:
            if "*" not in suffix:
                self._name(suffix, inputs)
            else:
                for path in folder.glob(escape(stem) + suffix):
                    self._refuse(path, inputs)

    def add(self, suffix: str, data: bytes) -> None:
        """Queue the sibling with ``suffix``; nothing is written before ``finish``."""
        if not any(fnmatchcase(suffix, known) for known in self._suffixes):
            raise ValueError(f"sibling {suffix} was not declared")
        if self.wants_files:
            self._siblings[suffix] = data

    def finish(self, document: dict[str, Any], inputs: Inputs) -> None:
        """Write the siblings and then the document, with ``files`` filled in; OutputError where that fails.

        Siblings of an earlier run that this one does not write again are removed.
        """
        if self.target == "-":
            write_stdout(dump_json(document))
        if not self.wants_files:
            return
        self._refuse(Path(self.target), inputs)
        names = {suffix: self._name(suffix, inputs, data) for suffix, data in self._siblings.items()}
        earlier = self._written_earlier(document.get("format"))
        document = {**document, "files": sorted(path.name for path in names.values())}
        batch = [(names[suffix], data) for suffix, data in self._siblings.items()]
        write_files([*batch, (Path(self.target), dump_json(document))])
        for path in earlier - set(names.values()):
            if not is_input(path, inputs):
                # One that cannot be removed does no harm to what was written: the document does not list it.
                with contextlib.suppress(OSError, ValueError):
                    path.unlink()

    def _name(self, suffix: str, inputs: Inputs, data: bytes | None = None) -> Path:
        """Return the path of a sibling with this ``data``, once it is known; UsageError where it is an input."""
        path = self.path(suffix)
        if suffix == ".csv" and (is_input(path, inputs) or (data is not None and self._is_foreign(path, data))):
            path = self.path(BESIDE_INPUT + suffix)
        self._refuse(path, inputs)
        return path

    def _is_foreign(self, path: Path, data: bytes) -> bool:
        """Whether a table of numbers stands at ``path`` that hf did not write: the document there does not list it, and
        its head is another than that of ``data``."""
        if not (path.is_file() and os.access(path, os.R_OK)):
            return False
        with path.open("rb") as file:
            head, *rows = file.read(_LOOKED_AT).splitlines() or [b""]
        own = head == data.splitlines()[0] or path in self._written_earlier(None)
        return not own and any(map(_of_numbers, rows))

    def _refuse(self, path: Path, inputs: Inputs) -> None:
        if is_input(path, inputs):
            raise UsageError(f"--output {self.target}: {path} is an input of this command; choose another name")

    def _written_earlier(self, kind: object) -> set[Path]:
        """Return the siblings that the document of this kind (None: of any) lists which is about to be replaced.

        Those that are not written again would pass for this run's (a longer series of frames); nothing else goes.
        """
        try:
            found = json.loads(Path(self.target).read_bytes())
        except (OSError, ValueError, RecursionError):
            return set()
        if not isinstance(found, dict) or not isinstance(found.get("files"), list):
            return set()
        if kind is not None and found.get("format") != kind:
            return set()
        target = Path(self.target)
        return {
            target.with_name(name)
            for name in found["files"]
            if isinstance(name, str) and name.startswith(f"{target.stem}.") and name == Path(name).name
        }


def _of_numbers(row: bytes) -> bool:
    """Whether a machine or a logger wrote a row of a table: numbers behind a number or a time.

    >>> [_of_numbers(row) for row in (b"0;25,1", b"28.11.2026 10:00:00,25.1,", b"old text, 12", b"12")]
    [True, True, False, False]
    """
    first, *rest = (cell.strip(' "') for cell in re.split(r"[,;\t]", row.decode("latin-1")))
    return any(rest) and first.lstrip("+-")[:1].isdigit() and all(is_number(cell) for cell in rest if cell)


def check_place(target: str) -> None:
    """Raise OutputError where ``target`` cannot be a file: its folder is missing or closed, or it is a folder."""
    path = Path(target)
    folder = path.parent
    try:
        occupied = path.is_dir()
    except OSError as error:  # a name the system does not take
        raise OutputError(f"{target[:80]}...: {error.strerror}; choose a shorter name") from None
    if occupied:
        raise OutputError(f"{target}: is a folder")
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"{target}: {folder} is a file, not a folder; choose another name")
    if not folder.is_dir():
        raise OutputError(f"{target}: the folder {folder} does not exist; make it first")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(
            f"{target}: the folder {folder.resolve()} cannot be written; choose another or mend its permissions"
        )


def is_input(path: Path, inputs: Inputs) -> bool:
    """Whether ``path`` is a file that was read, by whatever name or hard link."""
    return any(file.name != "-" and _same_file(path, Path(file.name)) for file in inputs.files)


def write_single(target: str, data: bytes, inputs: Inputs) -> None:
    """Write the one file of a command without a document; UsageError where ``target`` is an input of it."""
    if target == "-":
        write_stdout(data)
    elif target != os.devnull:
        if is_input(Path(target), inputs):
            raise UsageError(f"--output {target}: is an input of this command; choose another name")
        write_files([(target, data)])


def _same_file(first: Path, second: Path) -> bool:
    try:
        return first.samefile(second)  # the same device and inode: links of either kind
    except OSError:
        return os.path.realpath(first) == os.path.realpath(second)


def write_stdout(data: bytes) -> None:
    """Write to file descriptor 1: the buffer of sys.stdout would fail once more, with a traceback, at exit."""
    view = memoryview(data)
    try:
        while view:
            view = view[os.write(1, view) :]
    except OSError as error:
        raise OutputError(f"standard output: {error.strerror or error}") from error
