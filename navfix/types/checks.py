"""What every record checks with, and the array types."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from navfix.errors import InputError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def require(condition: bool, name: str, rule: str, value: object) -> None:
    """Raise InputError with what was seen and what was expected unless the condition holds."""
    if not condition:
        raise InputError(f"{name} {rule}, got {value!r}")


def frozen_array(values: object, dtype: type) -> NDArray[np.generic]:
    """Return a read-only copy."""
    array: NDArray[np.generic] = np.array(values, dtype=dtype)
    array.setflags(write=False)
    return array
