"""Cut and flatten the hemispheres of a FreeSurfer subject."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from .._runtime import Progress, progress_part, show_progress
from .._types import BoolArray, FloatArray, IntArray
from ..errors import MeshError, MeshWarning, format_count, is_number, stack_level
from ..flattening import Flattening, Method, Outcome, flatten, resolve_method
from ..measures import Distances, Quality, find_overlapping_pairs, measure_quality
from ..surface import PatchFaces, Submesh, find_patch_faces, scatter_to_input
from .constants import MAX_DISTANCE_SOURCES, MAX_OMITTED_SHARE
from .found_cuts import find_cuts
from .subjects import HEMISPHERE_NAMES, Hemisphere, HemisphereName
from .templates import Template, load_fsaverage_template, read_template
from .transfer import Cuts, transfer_cuts, transfer_wall

MAX_DISTANCE_ERROR = 0.15  # default bound on the error of distances if cuts are found

CutSource = Literal["template", "found"]
WallSource = Literal["template", "label"]


@dataclass(frozen=True, eq=False, repr=False)
class FlatHemisphere:
    """A flat map of a hemisphere.

    Attributes
    ----------
    hemisphere : Hemisphere
        The uncut surface of the subject.
    F : (#, 3) int64
        The flattened faces, as indices of the surface's vertices.
    uv : (#V, 2) float64
        The map in mm, with superior up; NaN at vertices that are not in the map.
    cuts : Cuts
        The medial wall and the cuts.
    patch : PatchFaces
        The faces in the map, and the pieces that are left out in addition to the wall and the cuts.
    tangled : (#,) int64
        Border vertices that are left out because the map would overlap there.
    quality : Quality
        Quality of the map, with its error of distances.
    result : Flattening
        Result of the flattening, before tangled vertices are left out.
    """

    hemisphere: Hemisphere
    F: IntArray
    uv: FloatArray
    cuts: Cuts
    patch: PatchFaces
    tangled: IntArray
    quality: Quality
    result: Flattening

    @property
    def good(self) -> bool:
        """Whether the map has no flipped or overlapping triangles."""
        return self.result.outcome.good and not self.quality.overlaps

    @property
    def border(self) -> BoolArray:
        """Mask of the vertices in the map that have a neighbour outside the map, (#V,)."""
        return mask_border_vertices(self.hemisphere.F, self.patch)

    @property
    def left_out(self) -> str:
        """The numbers of vertices that are not in the map, by reason."""
        enclosed = sum(map(len, self.patch.pieces)) + len(self.patch.pinched) + len(self.patch.bare)
        cut = int((~self.cuts.is_kept & ~self.cuts.wall).sum())
        return (
            f"{int(self.cuts.wall.sum()):,} vertices of the medial wall, {cut:,} of "
            f"{len(self.cuts.paths)} cuts, {enclosed:,} between them, {len(self.tangled):,} where the border "
            "would overlap"
        )

    def __repr__(self) -> str:
        return (
            f"<Flat {self.hemisphere.name} of {self.hemisphere.subject}: "
            f"{format_count(len(self.F), 'triangle')}>"
        )


def flatten_hemisphere(
    subject: str | os.PathLike[str],
    hemisphere: HemisphereName,
    *,
    method: str | Method = "isometric",
    cuts: CutSource = "template",
    medial_wall: WallSource = "template",
    template: tuple[str | os.PathLike[str], str | os.PathLike[str]] | None = None,
    max_distance_error: float | None = None,
    progress: Progress = None,
) -> FlatHemisphere:
    """Cut and flatten a hemisphere of a FreeSurfer subject.

    Parameters
    ----------
    subject : path of the subject's folder
        The folder contains `surf/?h.fiducial`, or `midthickness`, or both `pial` and `smoothwm` or `white`,
        whose mean is used. Templates also need `surf/?h.sphere.reg`.
    hemisphere : {"lh", "rh"}
    method : str or method object
        As in `igl_linabf.flatten`.
    cuts : {"template", "found"}
        "template": transfer the cuts of a template by the registered spheres. "found": the shortest seams of
        `find_seams` from the medial wall with an error of distances of at most `max_distance_error`.
    medial_wall : {"template", "label"}
        "template": transfer the medial wall of the template. "label": use all vertices that are not in the
        subject's `label/?h.cortex.label`.
    template : (patch, sphere), optional
        A FreeSurfer patch of another subject, and the registered sphere of that subject. The default is
        fsaverage5, with the medial wall and the five cuts of the flat map that comes with nilearn.
    max_distance_error : float, optional
        Bound on the error of distances for `cuts="found"`; by default 0.15.
    progress : callable or False, optional
        As in `igl_linabf.flatten`.

    Returns
    -------
    FlatHemisphere
        The flat map, at the scale with the smallest error of distances.

    Raises
    ------
    MeshError
        A file is missing or belongs to another subject, or the remaining surface is not a disk (with or
        without holes).
    ValueError
        An option has an invalid value.
    ImportError
        nibabel or nilearn is not installed.

    Warns
    -----
    MeshWarning
        Cuts and medial wall enclose a piece of the cortex, which is left out, or found cuts do not reach
        `max_distance_error`.

    Examples
    --------
    >>> import tempfile, pathlib, nibabel.freesurfer as fs
    >>> from nilearn.datasets import fetch_surf_fsaverage
    >>> from nilearn.surface import load_surf_mesh
    >>> shipped, subject = fetch_surf_fsaverage("fsaverage5"), pathlib.Path(tempfile.mkdtemp())
    >>> (subject / "surf").mkdir()
    >>> for name, key in (("white", "white"), ("pial", "pial"), ("sphere.reg", "sphere")):
    ...     mesh = load_surf_mesh(shipped[f"{key}_left"])
    ...     fs.write_geometry(subject / "surf" / f"lh.{name}", mesh.coordinates, mesh.faces)
    >>> flat = flatten_hemisphere(subject, "lh")
    >>> flat.quality.flips, flat.quality.overlaps, len(flat.cuts.paths), flat.quality.distance_error < 0.142
    (0, 0, 5, True)
    """
    _check_options(cuts, medial_wall, template, max_distance_error)
    chosen = resolve_method(method)
    with show_progress(progress):
        with progress_part("reading", 0.1):
            given = Hemisphere.of_subject(subject, hemisphere)
            needs_sphere = "template" in (cuts, medial_wall)
            sphere = given.registered_sphere() if needs_sphere else given.V
            lines = _load_template(hemisphere, template) if needs_sphere else None
        with progress_part("cutting", 0.2):
            if medial_wall == "label":
                wall = given.labelled_wall()
            else:
                assert lines is not None  # because `needs_sphere` is True
                wall = transfer_wall(lines, sphere)
        if cuts == "found":
            bound = MAX_DISTANCE_ERROR if max_distance_error is None else max_distance_error
            with progress_part("finding cuts", 0.6):
                seams = find_cuts(given, wall, bound)
        else:
            assert lines is not None  # because `needs_sphere` is True
            seams = transfer_cuts(lines, sphere, given.F, wall)
        return _flatten_patch(given, seams, chosen)


def flatten_hemispheres(
    subject: str | os.PathLike[str],
    hemispheres: Iterable[HemisphereName] = HEMISPHERE_NAMES,
    *,
    method: str | Method = "isometric",
    cuts: CutSource = "template",
    medial_wall: WallSource = "template",
    template: tuple[str | os.PathLike[str], str | os.PathLike[str]] | None = None,
    max_distance_error: float | None = None,
) -> list[FlatHemisphere]:
    """Cut and flatten several hemispheres of a subject at once, each in its own thread.

    Parameters
    ----------
    subject : path of the subject's folder
    hemispheres : iterable of {"lh", "rh"}
    method, cuts, medial_wall : see `flatten_hemisphere`
        As in `flatten_hemisphere`.
    template : (patch, sphere), optional
        As in `flatten_hemisphere`, for one of the hemispheres. The files of the other hemisphere differ only
        in the prefix, such as `rh.cuts.patch.3d` instead of `lh.cuts.patch.3d`.
    max_distance_error : see `flatten_hemisphere`
        As in `flatten_hemisphere`.

    Returns
    -------
    list of FlatHemisphere

    Raises
    ------
    MeshError, ValueError, ImportError
        As in `flatten_hemisphere`.

    Examples
    --------
    >>> flatten_hemispheres("subjects/nobody")
    Traceback (most recent call last):
    ...
    igl_linabf.errors.MeshError: subjects/nobody has no surf/lh.fiducial, ...
    """

    def flatten_one(name: HemisphereName) -> FlatHemisphere:
        own_template = (
            None if template is None else tuple(_set_hemisphere_prefix(Path(path), name) for path in template)
        )
        return flatten_hemisphere(
            subject,
            name,
            method=method,
            cuts=cuts,
            medial_wall=medial_wall,
            template=own_template,  # type: ignore[arg-type]
            max_distance_error=max_distance_error,
            progress=False,
        )

    names = list(hemispheres)
    with ThreadPoolExecutor(max(len(names), 1)) as threads:
        return list(threads.map(flatten_one, names))


def _set_hemisphere_prefix(path: Path, name: HemisphereName) -> Path:
    """Replace the prefix "lh." or "rh." of a file name by the prefix of a hemisphere."""
    return path.with_name(name + path.name[2:]) if path.name[:3] in ("lh.", "rh.") else path


def _check_options(cuts: str, medial_wall: str, template: object, max_distance_error: float | None) -> None:
    for name, value, known in (("cuts", cuts, CutSource), ("medial_wall", medial_wall, WallSource)):
        if value not in get_args(known):
            raise ValueError(f"{name} is {value!r}: use {' or '.join(map(repr, get_args(known)))}")
    if "template" not in (cuts, medial_wall) and template is not None:
        raise ValueError("neither the cuts nor the medial wall come from a template: leave out the template")
    if max_distance_error is None:
        return
    if cuts != "found":
        raise ValueError("max_distance_error is for cuts that are found: use cuts='found'")
    if not is_number(max_distance_error, 0, 1, above=True):
        raise ValueError(
            f"max_distance_error is {max_distance_error!r}: use a number from 0 to 1, such as 0.15"
        )


def _load_template(
    hemisphere: HemisphereName, given: tuple[str | os.PathLike[str], str | os.PathLike[str]] | None
) -> Template:
    """Read the given template, or the template from fsaverage5."""
    if given is None:
        return load_fsaverage_template(hemisphere)
    patch, sphere = map(Path, given)
    for path in (patch, sphere):
        if path.name[:3] in ("lh.", "rh.") and path.name[:2] != hemisphere:
            raise MeshError(f"{path} is of the other hemisphere: give a template of {hemisphere}")
    return read_template(patch, sphere)


def _flatten_patch(given: Hemisphere, cuts: Cuts, method: Method) -> FlatHemisphere:
    """Flatten a hemisphere without its cuts and its medial wall, and measure the map."""
    patch = find_patch_faces(given.F, cuts.is_kept)
    enclosed = [piece for piece in patch.pieces if len(piece) > MAX_OMITTED_SHARE * len(given.V)]
    if enclosed:
        warnings.warn(
            f"{given.subject}, {given.name}: cuts and medial wall enclose pieces of "
            f"{', '.join(str(len(piece)) for piece in enclosed)} vertices (the first has vertex "
            f"{enclosed[0][0]}), which are left out of the map: check the registration there",
            MeshWarning,
            stacklevel=stack_level(),
        )
    surface = Submesh.from_input(given.V, given.F[patch.rows])
    with progress_part("flattening", 0.8):
        result = flatten(surface.V, surface.F, method=method)
    with progress_part("measuring", 1.0):
        distances = Distances.measure_within_rings(surface.as_manifold(), most=MAX_DISTANCE_SOURCES)
        uv = rotate_superior_up(result.uv, surface.V) * distances.find_best_scale(result.uv)
        error = distances.compute_mean_error(uv)
        uv = scatter_to_input(uv, surface.vertices, len(given.V))
        patch, tangled, pairs = _remove_overlapping_border(given, patch, uv)
        surface = Submesh.from_input(given.V, given.F[patch.rows])
        quality = replace(measure_quality(surface, uv[surface.vertices], pairs), distance_error=error)
        if result.outcome is Outcome.OVERLAPPING and not pairs:
            message = "no triangle is flipped or overlaps another, without the border that overlapped"
            result = replace(result, outcome=Outcome.VALID, message=message)
    uv = scatter_to_input(uv[surface.vertices], surface.vertices, len(given.V))
    return FlatHemisphere(given, given.F[patch.rows], uv, cuts, patch, tangled, quality, result)


def _remove_overlapping_border(
    given: Hemisphere, patch: PatchFaces, uv: FloatArray
) -> tuple[PatchFaces, IntArray, int]:
    """Remove border vertices where the map overlaps.

    Return the remaining patch, the removed vertices, and the number of pairs of faces that still overlap. If
    too many vertices would have to be removed, return the patch unchanged.
    """
    is_kept, first, removed = np.zeros(len(uv), dtype=bool), patch, list[IntArray]()
    is_kept[patch.vertices] = True
    while True:
        F = given.F[patch.rows]
        pairs = find_overlapping_pairs(uv, F)
        if not len(pairs):
            return patch, np.concatenate([np.zeros(0, dtype=np.int64), *removed]), 0
        touched = np.unique(F[pairs])
        removed.append(touched[mask_border_vertices(given.F, patch)[touched]])
        if not len(removed[-1]) or sum(map(len, removed)) > MAX_OMITTED_SHARE * len(patch.vertices):
            pairs = find_overlapping_pairs(uv, given.F[first.rows])
            return first, np.zeros(0, dtype=np.int64), len(pairs)
        is_kept[removed[-1]] = False
        patch = find_patch_faces(given.F, is_kept)


def mask_border_vertices(F: IntArray, patch: PatchFaces) -> BoolArray:
    """Return a mask of the vertices in the patch that have a neighbour outside the patch, (#V,)."""
    is_outside = np.ones(int(F.max()) + 1, dtype=bool)
    is_outside[patch.vertices] = False
    border = np.zeros(len(is_outside), dtype=bool)
    border[F[is_outside[F].any(axis=1)]] = True
    return np.asarray(border & ~is_outside)


def rotate_superior_up(uv: FloatArray, V: FloatArray) -> FloatArray:
    """Rotate the map so that the superior direction, FreeSurfer's z axis, points up."""
    z, height = (uv - uv.mean(axis=0)) @ [1, 1j], V[:, 2] - V[:, 2].mean()
    superior = complex(height @ z)
    rotated = z * (1j * np.conj(superior) / abs(superior) if superior else 1.0)
    return np.column_stack((rotated.real, rotated.imag))
