"""The options of xatlas-python, with its names and defaults."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, fields
from enum import Enum

from ..errors import FallbackWarning, stack_level

IGNORED_PACKING = ("max_chart_size", "blockAlign", "bruteForce")
ROTATIONS = ("rotate_charts_to_axis", "rotate_charts")


class ChartType(Enum):
    """The methods by which xatlas flattens charts. This package reports `LSCM` for each flattened chart."""

    Planar = 0
    Ortho = 1
    LSCM = 2
    Piecewise = 3
    Invalid = 4

    def __int__(self) -> int:
        """Return the number of the type in xatlas."""
        return int(self.value)


@dataclass(slots=True)
class ChartOptions:
    """The chart options of xatlas. They are accepted but ignored: `unwrap` finds charts in another way.

    `Atlas.generate` issues one warning that names the options with other values than the defaults. Charts are
    never mirrored, as if `fix_winding` were always True.

    Attributes
    ----------
    max_chart_area, max_boundary_length : float
    normal_deviation_weight, roundness_weight, straightness_weight : float
    normal_seam_weight, texture_seam_weight : float
    max_cost : float
    max_iterations : int
    use_input_mesh_uvs : bool
        Use `Atlas.add_uv_mesh` instead, which packs the charts of existing texture coordinates.
    fix_winding : bool

    Examples
    --------
    >>> options = ChartOptions()
    >>> options.max_cost = 8.0
    """

    max_chart_area: float = 0.0
    max_boundary_length: float = 0.0
    normal_deviation_weight: float = 2.0
    roundness_weight: float = 0.01
    straightness_weight: float = 6.0
    normal_seam_weight: float = 4.0
    texture_seam_weight: float = 0.5
    max_cost: float = 2.0
    max_iterations: int = 1
    use_input_mesh_uvs: bool = False
    fix_winding: bool = False


@dataclass(slots=True)
class PackOptions:
    """The packing options of xatlas.

    Attributes
    ----------
    max_chart_size : int
        Ignored.
    padding : int
        Texels between charts.
    texels_per_unit : float
        Texels per unit of length. If 0, charts are as large as one page allows.
    resolution : int
        Texels along a page's side. With `texels_per_unit`, there are as many pages as necessary. If 0, there
        is one page, whose resolution follows from `texels_per_unit` or is 1024.
    bilinear : bool
        Leave at least two texels between charts, which then share no texels of bilinear lookups.
    blockAlign, bruteForce : bool
        Ignored.
    create_image : bool
        Allow `Atlas.get_chart_image`.
    rotate_charts_to_axis, rotate_charts : bool
        If both are False, the charts of `Atlas.add_uv_mesh` are not rotated. All other charts may be rotated
        in any case.

    Examples
    --------
    >>> options = PackOptions()
    >>> options.resolution, options.padding = 512, 4
    """

    max_chart_size: int = 0
    padding: int = 0
    texels_per_unit: float = 0.0
    resolution: int = 0
    bilinear: bool = True
    blockAlign: bool = False  # noqa: N815
    bruteForce: bool = False  # noqa: N815
    create_image: bool = False
    rotate_charts_to_axis: bool = True
    rotate_charts: bool = True


def warn_of_ignored_options(charts: ChartOptions, pack: PackOptions, *, keeps_rotation: bool) -> None:
    """Issue one warning that names the options that were changed but have no effect.

    `keeps_rotation` says whether charts have a direction that they can keep.
    """
    ignored = _list_changed_options(charts) - {"ChartOptions.fix_winding"}
    changed = _list_changed_options(pack)
    rotations = {f"PackOptions.{name}" for name in ROTATIONS} & changed
    ignored |= {f"PackOptions.{name}" for name in IGNORED_PACKING} & changed
    if not (keeps_rotation and len(rotations) == len(ROTATIONS)):
        ignored |= rotations
    if ignored:
        warnings.warn(
            f"{', '.join(sorted(ignored))} {'has' if len(ignored) == 1 else 'have'} no meaning in "
            "igl_linabf.xatlas and no effect: see the page 'From xatlas'",
            FallbackWarning,
            stacklevel=stack_level(),
        )


def _list_changed_options(options: ChartOptions | PackOptions) -> set[str]:
    """Return the names of the options that differ from their defaults."""
    return {
        f"{type(options).__name__}.{field.name}"
        for field in fields(options)
        if getattr(options, field.name) != field.default
    }
