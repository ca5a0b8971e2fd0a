"""Represent validated surfaces: the input arrays with their connectivity and areas.

A `Submesh` is any surface or a part of one; a `Mesh` is a single disk with or without holes. Both provide
their `Topology`, components and areas. `clean` turns an arbitrary set of triangles into such a surface.
The genus follows from the Euler-Poincare formula: vertices - edges + faces = 2 - 2 genus - loops.
"""

from .._core import NEXT, PREV, cycles, sum_by_index
from .areas import find_faces_without_area, measure
from .arrays import (
    Pins,
    check_finite,
    compact,
    count_vertices,
    distinct_corners,
    face_array,
    map_array,
    pins,
    scatter,
    seam_mask,
    shape_is_pinned,
    vertex_array,
    vertex_indices,
)
from .disks import Disks, sound_disks
from .mesh import Mesh, PlanarFaces, build_planar_mesh, find_loop_of_vertex, planar_mesh
from .outer_loop import find_outer_loop_of_angles
from .plane import (
    HOPELESS_AREA_RATIO,
    SAFE_AREA_RATIO,
    area_scale_ratio,
    bounded_ratio,
    complex_positions,
    coordinates,
    direction_in_space,
    flat_angles,
    flipped_faces,
    mapped_direction,
    move_to_pins,
    normalize_placement,
    scale_to_unit_size,
    signed_double_areas,
    times_power_of_two,
    unit_vectors,
)
from .polygons import Faces, Polygons, Triangles
from .ragged import Ragged, index_and_rank
from .repair import (
    Cleaned,
    PatchFaces,
    Repair,
    RepairedDisk,
    clean,
    cleaned_surface,
    coincident_edges,
    find_chords,
    merge_coincident,
    orient_faces,
    patch_faces,
    repair_disk,
    split_chords,
    wrap_sound_surface,
)
from .submesh import Submesh, cut_faces
from .topology import (
    Topology,
    build_topology,
    centres,
    check_planar,
    connected_labels,
    face_components,
    manifold_topology,
    number_triangles,
    planar_topology,
    with_outer_loop,
)
