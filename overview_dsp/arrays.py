"""Array types that many signatures use."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

SampleArray = NDArray[np.float32]  # sound: (frames,) or (frames, channels)
