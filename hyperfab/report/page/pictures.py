"""Pictures for the page: as the commands drew them, in fewer bytes."""

from __future__ import annotations

import io

from PIL import Image, UnidentifiedImageError

#: Pictures larger than this are stored with a palette: a third of the bytes, and nobody sees it.
LARGE = 60_000
#: Pixels of a picture from somewhere else that are still opened.
MAX_PIXELS = 40_000_000


def light(data: bytes) -> bytes | None:
    """Return a PNG with at most 256 colours where it was large; None where it is no picture.

    >>> light(b"no picture") is None
    True
    """
    try:
        with Image.open(io.BytesIO(data), formats=["PNG"]) as picture:
            if picture.width * picture.height > MAX_PIXELS:
                return None
            if len(data) <= LARGE:
                picture.verify()
                return data
            small = picture.convert("RGB").quantize(
                256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE
            )
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError, Image.DecompressionBombError):
        return None
    buffer = io.BytesIO()
    small.save(buffer, "PNG", optimize=True)
    return min(buffer.getvalue(), data, key=len)
