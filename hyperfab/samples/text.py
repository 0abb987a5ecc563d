"""The form in which the samples' tables are written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence


def csv_file(metadata: Mapping[str, str], header: Sequence[str], rows: Sequence[Sequence[str]]) -> bytes:
    """Return a CSV file: ``# key: value`` lines, one header row, then the rows as they are printed.

    >>> csv_file({"test": "uniaxial"}, ["stretch [-]", "stress [MPa]"], [["1.01", "0.03"]])
    b'# test: uniaxial\\nstretch [-],stress [MPa]\\n1.01,0.03\\n'
    """
    lines = [f"# {key}: {value}" for key, value in metadata.items()]
    lines += [",".join(header), *(",".join(row) for row in rows)]
    return ("\n".join(lines) + "\n").encode("ascii")
