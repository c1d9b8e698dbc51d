"""Types of arrays outside FMUs; code that runs in an FMU uses `fmi_export.model.Array`."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
Complex = NDArray[np.complex128]
Indices = NDArray[np.intp]
