"""The one place that writes CSV: cells quoted where they must be, numbers that read back as the same doubles."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any


def csv_bytes(
    header: Sequence[str],
    rows: Iterable[Sequence[Any]],
    *,
    digits: int | None = None,
    metadata: Mapping[str, str] | None = None,
) -> bytes:
    """Return a table as CSV: ``# key: value`` lines, one header row, then the rows.

    Cells are text, numbers, truths (1 or 0) or None; None and what is not finite are empty cells. Numbers are written
    so that reading them gives the same doubles, or with ``digits`` significant digits. Text that holds a comma, a
    quote or a line break is quoted; line breaks become blanks: to tools that read line by line they would be rows.

    >>> csv_bytes(["time_s", "cup, left_degC"], [[0, 25.0], [0.1, None]])
    b'time_s,"cup, left_degC"\\n0,25.0\\n0.1,\\n'
    >>> csv_bytes(["stretch [-]"], [["1.01"]], metadata={"test": "uniaxial"})
    b'# test: uniaxial\\nstretch [-]\\n1.01\\n'
    """
    stream = io.StringIO()
    for key, value in (metadata or {}).items():
        stream.write(f"# {key}: {value}\n")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([_cell(name, None) for name in header])
    for row in rows:
        if len(row) != len(header):
            raise ValueError(f"a row of {len(row)} cells under a header of {len(header)}")
        writer.writerow([_cell(value, digits) for value in row])
    return stream.getvalue().encode("utf-8")


def _cell(value: Any, digits: int | None) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return " ".join(value.split())
    if hasattr(value, "item"):  # numpy's numbers print with their type
        value = value.item()
    if isinstance(value, bool | int):
        return str(int(value))
    if not math.isfinite(value):
        return ""
    value += 0.0  # no -0
    return repr(value) if digits is None else f"{value:.{digits}g}"
