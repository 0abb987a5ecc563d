"""Writing of triangle surfaces as binary STL."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def stl_bytes(vertices: NDArray[np.float64], faces: NDArray[np.int64], title: str = "hyperfab") -> bytes:
    """Return a binary STL of ``vertices`` (n, 3) [mm] and ``faces`` (m, 3), 84 + 50 m bytes.

    Corners that share a vertex get the same bits, so a closed surface stays closed. Facet normals follow the
    winding; a facet without area gets the normal (0, 0, 0). The header never begins with "solid", by which
    other programs would take the file for an ASCII one.

    >>> import numpy as np
    >>> len(stl_bytes(np.eye(3), np.array([[0, 1, 2]])))
    134
    """
    corners = np.asarray(vertices, dtype=np.float64)[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.sqrt(cross[:, 0] ** 2 + cross[:, 1] ** 2 + cross[:, 2] ** 2)
    records = np.zeros(len(faces), dtype=_RECORD)
    records["normal"] = cross / np.where(length > 0.0, length, 1.0)[:, None]
    records["corners"] = corners
    header = f"binary STL, mm, {title}".encode("ascii", "replace")[:80].ljust(80, b" ")
    return header + len(faces).to_bytes(4, "little") + records.tobytes()
