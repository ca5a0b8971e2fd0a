"""Compute and cache the maps of a surface that a window shows."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from .._types import FloatArray, IntArray
from ..charts import ChartOptions, find_seams, unwrap
from ..errors import OutcomeWarning
from ..flattening import BoundaryName, LinABF, flatten, resolve_method
from ..measures import Quality, quality
from ..surface import build_topology, drop_unused_vertices
from .scene import Scene, build_scene

Pairs = tuple[tuple[int, int], ...]


@dataclass(frozen=True, eq=False)
class Shown:
    """A flat map that the window shows.

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
        Rows of `uv` at the corners of the faces.
    """

    drawn: Scene
    quality: Quality
    charts: int
    uv: FloatArray
    corners: IntArray


@dataclass(frozen=True)
class MapRequest:
    """The parameters of a map, used as the key of the cache.

    Attributes
    ----------
    method : str
    iterations : int
        Number of iterations of linABF; 0 stands for its default, "auto".
    trade : float or None
        Trade of seam length for stretch. None leaves a disk uncut, and uses the default of `ChartOptions` for
        all other surfaces.
    drawn : tuple of vertex pairs
        Edges that the user has drawn as seams. If the surface needs further seams, they are found
        automatically.
    """

    method: str
    iterations: int
    trade: float | None = None
    drawn: Pairs = ()


class MapCache:
    """The maps of a surface, each computed at the first request.

    `boundary` and `cones` apply to methods that support these options, until seams are drawn or found with
    another `trade`.
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
        vertices, faces = drop_unused_vertices(F, len(V))
        self.planar = build_topology(faces, vertices).is_planar
        self._maps: dict[MapRequest, Shown] = {}
        self._seams: dict[float, IntArray] = {}

    def get_map(self, request: MapRequest) -> Shown:
        """Return the map of a request, and compute it at the first request."""
        if request not in self._maps:
            self._maps[request] = self._compute(request)
        return self._maps[request]

    def _compute(self, request: MapRequest) -> Shown:
        method = LinABF(iterations=request.iterations) if request.iterations else request.method
        plain, shapes = request.trade is None and not request.drawn, resolve_method(method).shapes
        with_cones = plain and self._cones is not None and shapes
        if not with_cones and plain and (self.planar or self._boundary != "free"):
            uv = flatten(self.V, self.F, method=method, boundary=self._boundary if shapes else "free").uv
            drawn = build_scene(self.V, self.F, uv)
            if self._maps:  # give all maps the same orientation
                drawn = drawn.fit_map(next(iter(self._maps.values())).drawn)
            return Shown(drawn, quality(drawn.V, drawn.F, drawn.uv), 1, uv, self.F)
        options: dict[str, Any] = {"cones": self._cones}
        if not with_cones:
            trade = ChartOptions.trade if request.trade is None else request.trade
            seams = np.array(request.drawn, dtype=np.int64) if request.drawn else self._find_seams(trade)
            extend = bool(request.drawn) and not self.planar
            options = {"seams": seams, "charts": ChartOptions(trade=trade, extend=extend)}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", OutcomeWarning)  # the window itself shows flipped triangles
            atlas = unwrap(self.V, self.F, method=method, **options)
        drawn = build_scene(self.V, self.F, atlas)
        return Shown(drawn, atlas.quality, len(atlas.charts), atlas.flat, np.asarray(atlas.FTC))

    def _find_seams(self, trade: float) -> IntArray:
        if trade not in self._seams:
            self._seams[trade] = find_seams(self.V, self.F, method="linabf", trade=trade, disks=True)
        return self._seams[trade]
