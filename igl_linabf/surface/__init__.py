"""Represent validated surfaces: the input arrays with their connectivity and areas.

A `Submesh` is any surface or a part of one; a `Mesh` is a single disk with or without holes. Both provide
their `Topology`, components and areas. `clean` turns an arbitrary set of triangles into such a surface.
The genus follows from the Euler-Poincare formula: vertices - edges + faces = 2 - 2 genus - loops.
"""

from .._core import NEXT, PREV, cycles, sum_by_index
from .areas import find_faces_without_area, measure_faces
from .arrays import (
    Pins,
    check_finite,
    convert_vertex_indices,
    count_vertices,
    drop_unused_vertices,
    face_array,
    has_distinct_corners,
    make_seam_mask,
    map_array,
    scatter_to_input,
    shape_is_pinned,
    validate_pins,
    vertex_array,
)
from .disks import Disks, concatenate_sound_disks
from .mesh import Mesh, PlanarFaces, build_planar_mesh, find_loop_of_vertex, planar_mesh
from .outer_loop import find_outer_loop_of_angles
from .plane import (
    HOPELESS_AREA_RATIO,
    SAFE_AREA_RATIO,
    complex_positions,
    compute_area_scale_ratio,
    compute_bounded_ratio,
    compute_flat_angles,
    find_flipped_faces,
    map_direction,
    move_to_pins,
    multiply_by_power_of_two,
    normalize_placement,
    normalize_vectors,
    parse_direction,
    real_coordinates,
    scale_to_unit_size,
    signed_double_areas,
)
from .polygons import Faces, Polygons, Triangles
from .ragged import Ragged, index_and_rank
from .repair import (
    Cleaned,
    PatchFaces,
    Repair,
    RepairedDisk,
    clean,
    clean_surface,
    find_chords,
    find_patch_faces,
    mark_coincident_edges,
    merge_coincident,
    orient_faces,
    repair_disk,
    split_chords,
    wrap_sound_surface,
)
from .submesh import Submesh, cut_faces
from .topology import (
    Topology,
    build_manifold_topology,
    build_planar_topology,
    build_topology,
    check_planar,
    compute_group_centres,
    connected_labels,
    label_face_components,
    number_triangles,
    with_outer_loop,
)
