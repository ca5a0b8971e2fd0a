"""Cut graphs: edges along which a component opens to a disk, and how they are made shorter.

In: a component. Out: `ClosedSurface`, its graph with a hole as a node; trees through nodes; the stretch to
expect of the map that a cut leaves.
"""

from .branches import Cost, pruned, shortened
from .clusters import CLUSTERED, DIRECT, DIRECT_HANDLES, Levels, handles_of_clusters
from .graph import (
    CREASE_DISCOUNT,
    ClosedSurface,
    closed_surface,
    join,
    open_handles,
    seam_lengths,
    without_stubs,
)
from .laplacians import ZeroAtNodes
from .shortening import rerouted
from .stretch import MAX_LOG_SCALE, expected, expected_stretch, log_scale
