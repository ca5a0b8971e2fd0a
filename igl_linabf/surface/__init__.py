"""Surfaces: the caller's arrays, checked once, and what is known of them.

In: V, F, and a map or pins as the caller has them. Out: a `Submesh`, any surface or a part of one; a
`Mesh`, one disk with or without holes, which is what is flattened; their `Topology`, components, areas.
`clean` makes any triangles such a surface.
Genus by Euler and Poincare: vertices - edges + faces = 2 - 2 genus - loops.
"""

from .areas import measure
from .arrays import Pins, check_finite, compact, face_array, pins, scatter, seam_mask, vertex_array
from .components import connected_labels, face_components
from .mesh import Mesh, loop_through, planar, planar_mesh
from .plane import (
    ALL_DIGITS,
    SPAN,
    centred,
    complex_positions,
    coordinates,
    flat_angles,
    flipped_faces,
    of_size_one,
    placed_at,
    signed_double_areas,
    span,
)
from .repair import Cleaned, Repair, as_it_is, clean, cleaned_surface
from .submesh import Submesh, cut_faces
from .topology import (
    NEXT,
    PREV,
    Topology,
    check_fans,
    check_planar,
    cycles,
    planar_topology,
    sum_by,
    topology_of,
    with_outer,
)
