"""Arrays by what they hold, as annotations name them."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Floats = NDArray[np.floating]  # of single or double precision
Mask = NDArray[np.bool_]
Integers = NDArray[np.int64]
Indices = NDArray[np.intp]
Modes = NDArray[np.complex128]
