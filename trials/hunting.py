"""What the hunts share: the command run in this process, and the count of cases judged."""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from hyperfab.cli import app

Array = NDArray[np.float64]
Columns = Mapping[str, Array]


@dataclass(frozen=True)
class Ran:
    """A run of ``hf``: its exit status, the document it wrote (None if none) and what it said on standard error."""

    status: int
    document: Any
    said: str

    def __getitem__(self, key: str) -> Any:
        """Return what the document has under ``key``; without a document there is nothing to judge."""
        if self.document is None:
            raise KeyError(f"status {self.status}: {self.said.strip().splitlines()[-1:]}")
        return self.document[key]


def hf(*words: object, output: Path | None = None) -> Ran:
    """Run ``hf`` with the words of its command line in this process; ``output`` is where ``-o`` writes.

    Without it the document comes on standard output, and no pictures are drawn. Everything but the start of the
    interpreter is what a user has: parser, reader, exit status, document.
    """
    arguments = [str(word) for word in words] + ([] if output is None else ["-o", str(output)])
    said, status, text = io.StringIO(), 0, ""
    if output is not None:
        output.unlink(missing_ok=True)
    with contextlib.redirect_stderr(said), _standard_output() as printed:
        try:
            app(prog_name="hf", args=arguments)
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else 0
        sys.stdout.flush()
        if output is None:
            printed.seek(0)
            text = printed.read().decode()
    if output is not None and output.exists():
        text = output.read_text()
    return Ran(status, json.loads(text) if text.startswith("{") else text or None, said.getvalue())


def on_files(command: str, options: Mapping[str, Any], files: Mapping[str, str | bytes]) -> Ran:
    """Run a command without an output file on options by their long name, beside ``files`` (name: content).

    A value that names one of the files is that file; several repeat the option; True is a flag, None leaves it out.
    The option ``""`` is the plain argument.
    """
    with tempfile.TemporaryDirectory() as folder:
        for name, content in files.items():
            path = Path(folder) / name
            path.write_bytes(content if isinstance(content, bytes) else content.encode())
        words: list[str] = []
        for name, given in options.items():
            for value in given if isinstance(given, (list, tuple)) else [given]:
                option = [f"--{name}"] if name else []
                if value is True:
                    words += option
                elif value is not None:
                    words += [*option, str(Path(folder) / value) if value in files else str(value)]
        ran = hf(command, *words, "-o", "-", "--quiet")
        return Ran(ran.status, ran.document, ran.said.replace(folder + "/", ""))


def off(one: Ran, other: Ran, scales: Mapping[str, float]) -> float:
    """Return how far figures of two documents are apart at most, relative to the larger: those of ``other`` should be
    those of ``one`` times ``scales``; infinity without a document."""
    if not isinstance(one.document, dict) or not isinstance(other.document, dict):
        return float("inf")
    worst = 0.0
    for key, scale in scales.items():
        a, b = scale * one[key], other[key]
        worst = max(worst, abs(a - b) / max(abs(a), abs(b), 1e-12))
    return worst


@contextlib.contextmanager
def _standard_output() -> Iterator[IO[bytes]]:
    """Catch what goes to standard output, also what goes straight to its descriptor."""
    sys.stdout.flush()
    kept = os.dup(1)
    with tempfile.TemporaryFile() as printed:
        os.dup2(printed.fileno(), 1)
        try:
            yield printed
        finally:
            os.dup2(kept, 1)
            os.close(kept)


@dataclass(frozen=True)
class File:
    """One file of a test: what its head says, and its columns by header."""

    head: Mapping[str, str]
    columns: Columns

    def text(self) -> str:
        """Return it as a user would have it."""
        head = [f"# {key}: {value}" for key, value in self.head.items()]
        rows = [",".join(repr(float(v)) for v in row) for row in zip(*self.columns.values(), strict=True)]
        return "\n".join([*head, ",".join(self.columns), *rows, ""])

    def with_columns(self, change: Callable[[str, Array], tuple[str, Array]]) -> File:
        """Return the file with each column and header changed."""
        return replace(self, columns=dict(change(key, values) for key, values in self.columns.items()))

    def rows(self, keep: slice | Array) -> File:
        """Return the file with some of its rows."""
        return replace(self, columns={key: values[keep] for key, values in self.columns.items()})

    def with_stress(self, change: Callable[[Array], Array]) -> File:
        """Return the file with its stresses changed."""
        return self.with_columns(lambda key, v: (key, change(v) if key.startswith("stress") else v))


def scaled(header: str, factor: float, name: str) -> Callable[[File], File]:
    """Return what puts one column into another unit."""
    return lambda one: one.with_columns(lambda key, v: (name, v * factor) if key == header else (key, v))


def strained(one: File) -> File:
    """Return the file with strains in percent in place of stretches."""
    return one.with_columns(lambda key, v: ("strain [%]", 100.0 * (v - 1.0)) if key.startswith("stretch") else (key, v))


def headed(**head: str) -> Callable[[File], File]:
    """Return what changes the head of a file."""
    return lambda one: replace(one, head={**one.head, **head})


@dataclass
class Hunt:
    """The cases and what came out; ``only`` is a part of the names of those that are asked for."""

    wrong: list[str] = field(default_factory=list)
    only: str = ""
    count: int = 0

    def judge(self, name: str, good: bool, said: object) -> None:
        """Count a case."""
        self.count += 1
        if not good:
            self.wrong.append(name)
        print(f"{'ok   ' if good else 'WRONG'} {name:58s} {said}", flush=True)

    def wanted(self, name: str) -> bool:
        """Whether a case is asked for."""
        return self.only in name

    def case(self, name: str, judged: Callable[[], tuple[bool, object]]) -> None:
        """Judge a case that is asked for: ``judged`` returns whether it is good, and what it says."""
        if self.wanted(name):
            try:
                self.judge(name, *judged())
            except KeyError as missing:
                self.judge(name, False, f"no such figure: {missing}"[:110])

    def ended(self, what: str) -> int:
        """Say how it went, and return the exit status: 1 if any case was wrong."""
        print("\n  ".join([f"{self.count} inputs of {what}, {len(self.wrong)} wrong", *self.wrong]))
        return 1 if self.wrong else 0


def asked(arguments: Sequence[str]) -> Hunt:
    """Return the hunt that a command line asks for: all of it, or what has a part of a name."""
    return Hunt(only=arguments[1] if len(arguments) > 1 else "")
