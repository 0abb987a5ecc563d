"""Writing of triangle surfaces as binary STL."""

from __future__ import annotations

from hyperfab.arrays import Array, Ints


def stl_bytes(vertices: Array, faces: Ints) -> bytes:
    """Return a binary STL of ``vertices`` (n, 3) [mm] and ``faces`` (m, 3), 84 + 50 m bytes.

    Corners that share a vertex get the same bits, so a closed surface stays closed. Facet normals follow the
    winding.

    >>> import numpy as np
    >>> len(stl_bytes(np.eye(3), np.array([[0, 1, 2]])))
    134
    """
    # Imported where it is needed: it takes as long to load as numba, and bad input is refused without it.
    import trimesh

    # process=False: vertices are neither merged nor reordered.
    surface = trimesh.Trimesh(vertices, faces, process=False)
    data: bytes = trimesh.exchange.stl.export_stl(surface)
    return data
