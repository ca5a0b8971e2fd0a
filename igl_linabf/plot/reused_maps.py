"""The maps of one surface that a window has shown, each computed once."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from .._types import FloatArray, IntArray
from ..charts import Seams, find_seams, unwrap
from ..errors import OutcomeWarning
from ..flattening import BoundaryName, LinABF, flatten, method_of
from ..measures import Quality, quality
from ..surface import compact, topology_of
from .scene import Scene, scene_of

Pairs = tuple[tuple[int, int], ...]


@dataclass(frozen=True, eq=False)
class Shown:
    """One flat map as the window shows it.

    Attributes
    ----------
    drawn : Scene
        The surface and its map.
    quality : Quality
    charts : int
        Number of charts.
    uv : (#V or #TC, 2) float64
        The map, or the atlas's texture coordinates.
    corners : (#F, 3) int64
        Its rows at the corners of the faces.
    """

    drawn: Scene
    quality: Quality
    charts: int
    uv: FloatArray
    corners: IntArray


@dataclass(frozen=True)
class MapRequest:
    """What a map depends on.

    Attributes
    ----------
    method : str
    iterations : int
        Of linABF; 0 is its default, "auto".
    trade : float or None
        Of seam length for stretch; None leaves a disk uncut, and finds seams as `find_seams` does.
    drawn : tuple of vertex pairs
        Edges that the user has drawn as seams; the rest that the surface needs is found.
    """

    method: str
    iterations: int
    trade: float | None = None
    drawn: Pairs = ()


class ReusedMaps:
    """The maps of a surface by what was asked for.

    Those of methods that can have the `boundary`, or the `cones`, until seams are drawn or found anew.
    """

    def __init__(
        self,
        V: FloatArray,
        F: IntArray,
        boundary: BoundaryName = "free",
        cones: int | Literal["auto"] | None = None,
    ) -> None:
        if boundary != "free" and cones is not None:
            raise ValueError("a surface with cones has a free boundary: leave out boundary or cones")
        self.V, self.F, self._boundary, self._cones = V, F, boundary, cones
        vertices, faces = compact(F, len(V))
        self.planar = topology_of(faces, vertices).is_planar
        self._maps: dict[MapRequest, Shown] = {}
        self._seams: dict[float, IntArray] = {}

    def map_for(self, request: MapRequest) -> Shown:
        """The map, computed where it is asked for the first time."""
        if request not in self._maps:
            self._maps[request] = self._compute(request)
        return self._maps[request]

    def _compute(self, request: MapRequest) -> Shown:
        method = LinABF(iterations=request.iterations) if request.iterations else request.method
        plain, shapes = request.trade is None and not request.drawn, method_of(method).shapes
        with_cones = plain and self._cones is not None and shapes
        if not with_cones and plain and (self.planar or self._boundary != "free"):
            uv = flatten(self.V, self.F, method, boundary=self._boundary if shapes else "free").uv
            drawn = scene_of(self.V, self.F, uv)
            if self._maps:  # turned alike
                drawn = drawn.fitted(next(iter(self._maps.values())).drawn)
            return Shown(drawn, quality(drawn.V, drawn.F, drawn.uv), 1, uv, self.F)
        options: dict[str, Any] = {"cones": self._cones}
        if not with_cones:
            trade = Seams.trade if request.trade is None else request.trade
            seams = np.array(request.drawn, dtype=np.int64) if request.drawn else self._seams_of(trade)
            complete = bool(request.drawn) and not self.planar
            options = {"seams": Seams(seams, trade=trade, complete=complete)}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", OutcomeWarning)  # what is flipped is seen, and counted
            atlas = unwrap(self.V, self.F, method=method, **options)
        drawn = scene_of(self.V, self.F, atlas)
        return Shown(drawn, atlas.quality, len(atlas.charts), atlas.flat, np.asarray(atlas.FTC))

    def _seams_of(self, trade: float) -> IntArray:
        if trade not in self._seams:
            self._seams[trade] = find_seams(self.V, self.F, trade=trade, disks=True)
        return self._seams[trade]
