"""Bytes to text: the encoding of a file, by its marks, its bytes and the words it must hold."""

from __future__ import annotations

import codecs
import re
import unicodedata

from hyperfab.errors import InputError
from hyperfab.io.dictionary import is_known, setting

#: Recordings are thinned before they are fitted; this bound keeps any file within a second and 400 MB.
MAX_BYTES = 32 * 2**20

_BOMS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1f]")
#: Code pages, the commonest first, and the scripts a text in them is written in.
_PAGES = (
    ("cp1252", "LATIN"), ("mac_roman", "LATIN"), ("cp1250", "LATIN"), ("cp850", "LATIN"), ("cp1254",
    "LATIN"), ("cp1251", "CYRILLIC"),
    ("koi8_r", "CYRILLIC"), ("cp1253", "GREEK"), ("cp932", "CJK HIRAGANA KATAKANA"), ("gb18030", "CJK"),
    ("big5", "CJK"), ("cp949", "HANGUL"),
)  # fmt: skip
_HIGH = re.compile(rb"[\x80-\xff]")
_WORD = re.compile(r"[^\W\d_]+(?: [^\W\d_]+)*")
#: Signs that are written in several ways: minus, and the narrow blanks that part thousands.
_ONE_SIGN = str.maketrans("\N{MINUS SIGN}\N{THIN SPACE}\N{FIGURE SPACE}\N{PUNCTUATION SPACE}", "-\u202f\u202f\u202f")
#: What other files start with, and what to do with them.
_OTHERS = (
    (b"\xd0\xcf\x11\xe0", "is an old Excel workbook (.xls)", "open it and save it as .xlsx or CSV"),
    (b"\x89HDF", "is an HDF5 file", "export the table as CSV or .xlsx"),
    (b"%PDF", "is a PDF", "export the readings as CSV or .xlsx"),
    (b"PK\x03\x04", "is a zip archive", "unpack it"),
    (b"\x1f\x8b", "is compressed (gzip)", "unpack it"),
    (b"MATLAB 5.0", "is a MATLAB file", "export the table as CSV (writetable)"),
    (b"ply\n", "is a cloud of points (PLY)", "export them as CSV, with a line that names the columns"),
    (b"ply\r\n", "is a cloud of points (PLY)", "export them as CSV, with a line that names the columns"),
    (b"PAR1", "is a Parquet file", "export the table as CSV or .xlsx"),
)
#: A document of a command, in JSON or TOML: what it says of itself.
_DOCUMENT = re.compile(rb"""\s*(?:\{\s*"format"\s*:|(?:\#[^\n]*\n\s*)*format\s*=)\s*"(hyperfab\.[\w-]+/\d+)\"""")


def decode(data: bytes, wanted: tuple[str, ...] = ()) -> str:
    """Return the text of a file: UTF-8, UTF-16 (with or without byte-order mark), Windows, Mac or another code page.

    Of the code pages in which the bytes are text, that is taken in which most words are known; ``wanted`` are titles
    that it must hold. InputError where the file is empty, too large or no text.

    >>> decode("µ;°".encode("latin-1")), decode("Prüfkraft".encode("mac_roman"))
    ('µ;°', 'Prüfkraft')
    """
    if len(data) > MAX_BYTES:
        raise InputError(f"is larger than {MAX_BYTES // 2**20} MiB", remedy="thin the recording out")
    if not data.strip():
        raise InputError("is empty", remedy="a table with a header line is expected")
    for start, what, remedy in _OTHERS:
        if data.startswith(start):
            raise InputError(what, remedy=remedy)
    document = _DOCUMENT.match(data)
    if document:
        raise InputError(
            f"is a document, {document[1].decode()}, no table of readings",
            remedy="give the file that the readings stand in",
        )
    text = _decoded(data, wanted).removeprefix("\ufeff").translate(_ONE_SIGN)
    found = _CONTROL.search(text)
    if found:
        line = text.count("\n", 0, found.start()) + 1
        raise InputError(
            f"is no text (character 0x{ord(found[0]):02X})", line=line, remedy="export it as CSV text or .xlsx"
        )
    return text


def _decoded(data: bytes, wanted: tuple[str, ...]) -> str:
    encoding = next((encoding for bom, encoding in _BOMS if data.startswith(bom)), None)
    if encoding is None and len(data) >= 4:
        if data[1::2].count(0) > 0.4 * (len(data) // 2):
            encoding = "utf-16-le"
        elif data[::2].count(0) > 0.4 * (len(data) // 2):
            encoding = "utf-16-be"
    try:
        return data.decode(encoding or "utf-8")
    except UnicodeDecodeError as error:
        if encoding in (None, "utf-8-sig"):  # some machines put the mark of UTF-8 in front of Latin-1
            return _by_words(data.removeprefix(codecs.BOM_UTF8), wanted)
        raise InputError(
            f"is no {encoding.upper()[:6].rstrip('-')} text though it starts like it (byte {error.start})",
            remedy="export it again, as UTF-8",
        ) from None


def _by_words(data: bytes, wanted: tuple[str, ...]) -> str:
    """Return the text in the code page under which most of what stands above the numbers are words."""
    sample = b"\n".join(line for line in re.split(rb"[\r\n]+", data[: 2**16]) if _HIGH.search(line))[:8192]
    best, text = -1e9, data.decode("latin-1")
    for rank, (page, scripts) in enumerate(_PAGES):
        try:
            found = sample.decode(page)
        except UnicodeDecodeError:
            continue
        score = _score(found, scripts, wanted) - 1e-3 * rank  # Western Latin where nothing speaks for another
        if score > best:
            try:
                text = data.decode(page)
            except UnicodeDecodeError:
                continue
            best = score
    return text


def _score(text: str, scripts: str, wanted: tuple[str, ...]) -> float:
    """Count titles and known words; without any, Western Latin stands unless all foreign letters are whole words."""
    score = sum(10.0 for title in wanted if title in text and not title.isascii())
    for match in _WORD.finditer(text):
        if not match[0].isascii():
            # A letter alone is a word in Chinese and Japanese only; a word in ASCII speaks for no page.
            parts = [match[0], *(part for part in match[0].split() if not part.isascii())]
            parts = [part for part in parts if len(part) > 1 or scripts.startswith("CJK")]
            score += 3.0 * any(is_known(part) or setting(part) is not None for part in parts)
    if scripts == "LATIN":
        return score
    runs = re.findall(r"[^\x00-\x7f]+", text)
    whole = all(len(run) > 1 and all(_of(mark, scripts) for mark in run) for run in runs)
    return score + (0.5 if whole and not re.search(r"[A-Za-z][^\x00-\x7f]|[^\x00-\x7f][A-Za-z]", text) else -1.0)


def _of(mark: str, scripts: str) -> bool:
    name = unicodedata.name(mark, "")
    return "HALFWIDTH" not in name and any(name.startswith(script) for script in scripts.split())
