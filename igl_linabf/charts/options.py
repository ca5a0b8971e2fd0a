"""What is asked of the charts of a surface."""

from dataclasses import dataclass

import numpy as np

from .._types import FloatArray, IntArray
from ..flattening import Isometric, Method
from ..surface import Submesh
from .atlas import STRETCH_ROUNDING, UNUSABLE_STRETCH
from .seams import seams_of
from .splitting import MAX_SPLITS

MAX_SPLITS_FOR_STRETCH = 64  # of one that is stretched more than is asked for, or beyond use


@dataclass(frozen=True)
class Task:
    """Arguments of `unwrap`, and whether more seams may be found."""

    method: Method
    may_find_seams: bool
    trade: float
    holes: bool
    bijective: bool
    max_stretch: float | None
    hidden: FloatArray | None

    def seams_of(
        self,
        piece: Submesh,
        *,
        disks: bool = False,
        gain: float = 0.0,
        part_overlaps: bool = False,
        panels: bool = False,
    ) -> IntArray:
        """`seams_of` a piece, as the task wants them; `part_overlaps` only if overlapping maps are cut."""
        isometric = isinstance(self.method, Isometric)
        return seams_of(
            piece,
            self.trade,
            holes=self.holes,
            disks=disks,
            gain=gain,
            hidden=self.hidden,
            isometric=isometric,
            part_overlaps=part_overlaps and not (isometric or self.bijective),
            panels=panels,
        )

    @property
    def most_stretch(self) -> float:
        """Of a chart, in L2, from which on it is cut further."""
        if self.max_stretch is not None:
            return self.max_stretch * (1 + STRETCH_ROUNDING)
        return UNUSABLE_STRETCH if self.may_find_seams else np.inf

    @property
    def weighs_stretch(self) -> bool:
        """Whether charts are cut further where the stretch of their map is worth a seam."""
        return self.may_find_seams and not self.holes and self.max_stretch is None

    @property
    def most_splits(self) -> int:
        """Of a chart and its parts."""
        return MAX_SPLITS if self.max_stretch is None else MAX_SPLITS_FOR_STRETCH
