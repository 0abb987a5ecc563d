"""A command's output: one JSON document, and its fields, curves and pictures beside it under the same stem."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hyperfab.errors import OutputError, UsageError
from hyperfab.io.atomic import write_files
from hyperfab.io.json_io import dump_json

if TYPE_CHECKING:
    from hyperfab.io.inputs import Inputs


class Output:
    """Collects what a command writes and writes it at the end: all files whole, the document last.

    ``target`` is ``NAME.json``, or ``-`` for standard output (then no other file is written).
    ``suffixes`` are the endings of the siblings the command may write (``.vtu``, ``.csv``, ``.png``).

    The place is tried at construction, before anything is computed: an output that is also an input is a
    UsageError, a folder that is missing or cannot be written an OutputError.
    """

    def __init__(self, target: str, suffixes: Sequence[str] = ()) -> None:
        self.target = target
        self._siblings: dict[str, bytes] = {}
        self._suffixes = tuple(suffixes)
        if target == "-":
            return
        path = Path(target)
        if path.suffix != ".json":
            raise UsageError(
                f"--output {target}: the document's name ends in .json; write {path.stem or 'result'}.json"
            )
        folder = path.parent
        try:
            occupied = path.is_dir()
        except OSError as error:  # a name the system does not take
            raise OutputError(f"{target[:80]}...: {error.strerror}; choose a shorter name") from None
        if occupied:
            raise OutputError(f"{target}: is a folder")
        if not folder.is_dir():
            raise OutputError(f"{target}: the folder {folder} does not exist; make it first")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise OutputError(
                f"{target}: the folder {folder} cannot be written; choose another or mend its permissions"
            )

    @property
    def wants_files(self) -> bool:
        """Whether siblings are written: not where the document goes to standard output."""
        return self.target != "-"

    def path(self, suffix: str) -> Path:
        """Return the path of the sibling with ``suffix``: ``out/drape.json`` and ``.vtu`` give ``out/drape.vtu``."""
        target = Path(self.target)
        return target.with_name(target.stem + suffix)

    def refuse_inputs(self, inputs: Inputs) -> None:
        """Refuse to overwrite a file that was read (also through a link, also by a sibling)."""
        if not self.wants_files:
            return
        for suffix in (".json", *self._suffixes):
            path = self.path(suffix)
            for file in inputs.files:
                if file.name != "-" and _same_file(path, Path(file.name)):
                    raise UsageError(
                        f"--output {self.target}: {path} is an input of this command; choose another name"
                    )

    def add(self, suffix: str, data: bytes) -> None:
        """Queue the sibling with ``suffix``; nothing is written before ``finish``."""
        if suffix not in self._suffixes and not any(suffix.endswith(known) for known in self._suffixes):
            raise ValueError(f"sibling {suffix} was not declared")
        if self.wants_files:
            self._siblings[suffix] = data

    def finish(self, document: dict[str, Any], inputs: Inputs) -> None:
        """Write the siblings and then the document, with ``files`` filled in; OutputError where that fails.

        Siblings of an earlier run that this one does not write again are removed.
        """
        self.refuse_inputs(inputs)
        if not self.wants_files:
            write_stdout(dump_json(document))
            return
        names = {suffix: self.path(suffix) for suffix in self._siblings}
        earlier = self._written_earlier(document.get("format"))
        document = {**document, "files": sorted(path.name for path in names.values())}
        batch = [(names[suffix], data) for suffix, data in self._siblings.items()]
        write_files([*batch, (Path(self.target), dump_json(document))])
        inputs_read = [Path(file.name) for file in inputs.files]
        for path in earlier - set(names.values()):
            if not any(_same_file(path, read) for read in inputs_read):
                # One that cannot be removed does no harm to what was written: the document does not list it.
                with contextlib.suppress(OSError, ValueError):
                    path.unlink()

    def _written_earlier(self, kind: object) -> set[Path]:
        """Return the siblings that the document of this kind lists which is about to be replaced.

        Those that are not written again would pass for this run's (a longer series of frames); nothing else goes.
        """
        try:
            found = json.loads(Path(self.target).read_bytes())
        except (OSError, ValueError, RecursionError):
            return set()
        if (
            not isinstance(found, dict)
            or found.get("format") != kind
            or not isinstance(found.get("files"), list)
        ):
            return set()
        target = Path(self.target)
        return {
            target.with_name(name)
            for name in found["files"]
            if isinstance(name, str) and name.startswith(f"{target.stem}.") and name == Path(name).name
        }


def _same_file(first: Path, second: Path) -> bool:
    try:
        return first.samefile(second)
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
