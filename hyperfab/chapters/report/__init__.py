"""`hf report`: any documents, in any order, as one page that tells the story of the line."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from hyperfab.cases.about import ReportCase
from hyperfab.chapters.job import Job
from hyperfab.documents.base import document_class, parse_document, stated_kind
from hyperfab.errors import InputError, UsageError
from hyperfab.io.json_io import load_json
from hyperfab.io.output import check_place, write_single
from hyperfab.report.page.parts import KINDS, Chart, Picture, Scene, Section, Source, in_order, light
from hyperfab.report.page.render import page
from hyperfab.report.page.sections import build
from hyperfab.report.page.sections.heat import molds

#: A page heavier than this opens slowly on a phone.
LARGE = 8 * 2**20


def run(job: Job, case: ReportCase) -> int:
    """Write the page. A document that cannot be read costs its section, and the exit status is that of an InputError;
    none at all is one."""
    output = _target(job.target)
    sources: dict[str, Source] = {}
    broken: list[tuple[Source, Section]] = []
    for name in case.documents:
        source, error = _read(job, name)
        if source.sha256 in sources:
            continue
        if error is None:
            sources[source.sha256] = source
            job.ranges.taken(name, source.data)
        else:
            job.console.warn(f"{error}; its section says so")
            broken.append((source, Section("", False, f"Cannot be shown: {error}.")))
    if not sources:
        raise InputError(broken[0][1].verdict.removesuffix("."), remedy="name documents that hf wrote")
    told = []
    with job.console.progress("Writing the page") as advance:
        ordered = in_order(list(sources.values()))
        for index, source in enumerate(ordered):
            advance(index / len(ordered), KINDS[source.kind])
            section = build(source)
            _add_pictures(source, section)
            told.append((source, section))
        data = page(case.title, [*told, *broken], molds(ordered))
    if len(data) > LARGE:
        job.console.warn(f"the page has {len(data) / 2**20:.1f} MB; name fewer documents for a phone")
    write_single(output, data, job.inputs)
    job.judge_ranges()
    return InputError.exit_status if broken else 0


def _target(output: str) -> str:
    """Return where the page goes: a name without an ending gets ``.html``; the place is tried before any work."""
    if output in ("-", os.devnull):
        return output
    path = Path(output)
    if not path.suffix and not path.is_dir():
        path = path.with_name(f"{path.name}.html")
    if path.suffix not in (".html", ".htm"):
        raise UsageError(f"--output {output}: a page's name ends in .html; write {path.stem or 'report'}.html")
    check_place(str(path))
    return str(path)


def _read(job: Job, name: str) -> tuple[Source, InputError | None]:
    """Return a document, checked; where it is not sound, what is known of it and the error."""
    raw = job.inputs.read(name)
    digest = hashlib.sha256(raw).hexdigest()
    beside = _reader(job, name)
    try:
        loaded = load_json(raw, name)
        kind = stated_kind(loaded)
        if kind not in KINDS:
            raise InputError(
                "is no document that a page can show",
                file=name,
                key="format",
                remedy=f"it shows {', '.join(KINDS)}",
            )
        data: Mapping[str, Any] = parse_document(loaded, name, document_class(kind)).to_json()
    except InputError as error:
        return Source(name, "material", digest, {}, beside), error
    return Source(name, kind, digest, data, beside), None


def _reader(job: Job, name: str) -> Callable[[str], bytes]:
    def read(file: str) -> bytes:
        # A document from somewhere else must not bring files of this machine into the page.
        if os.path.isabs(file) or ".." in Path(file).parts:
            raise InputError("is not beside the document", file=file)
        return job.inputs.read(job.inputs.beside(name, file))

    return read


def _add_pictures(source: Source, section: Section) -> None:
    """Put the command's own picture under the section: on paper in place of a view, or where nothing else is shown."""
    views = any(isinstance(part, Scene) for part in section.parts)
    charts = any(isinstance(part, Chart) for part in section.parts)
    if source.kind == "sweep" or (charts and not views):
        return
    drawn = source.sibling(".png", but=".model.png")
    picture = None if drawn is None else light(drawn)
    if picture is not None:
        words = f"Picture of {KINDS[source.kind].lower()}, as the command drew it."
        section.parts.append(Picture(words, words, picture, only_print=views))
