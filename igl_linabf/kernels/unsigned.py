"""Unsigned numbers for indices: with them alone, loops need not look for negative ones."""

from typing import Any

import numpy as np

index: Any = np.uint64
ZERO, ONE, TWO, THREE, FOUR = (index(i) for i in range(5))
