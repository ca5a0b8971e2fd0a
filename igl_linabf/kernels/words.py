"""Bits in words of 64, for other loops."""

import numpy as np

from .choice import inlined
from .unsigned import ONE

WORD = 64
NONE, EVERY = np.uint64(0), np.uint64(0xFFFFFFFFFFFFFFFF)


@inlined
def ones(word: np.uint64) -> np.int64:
    """How many bits are set."""
    word = word - ((word >> np.uint64(1)) & np.uint64(0x5555555555555555))
    word = (word & np.uint64(0x3333333333333333)) + ((word >> np.uint64(2)) & np.uint64(0x3333333333333333))
    word = (word + (word >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return np.int64((word * np.uint64(0x0101010101010101)) >> np.uint64(56))


@inlined
def lowest(word: np.uint64) -> np.int64:
    """The place of the lowest bit that is set."""
    return ones(~word & (word - ONE))
