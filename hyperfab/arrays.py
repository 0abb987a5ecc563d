"""The arrays of the house: of numbers, in double or in single precision, of whole numbers, of yes and no."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Singles = NDArray[np.float32]
Reals = Array | Singles
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]
