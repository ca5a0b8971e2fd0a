"""Charts cut further, or mended, where their maps overlap, flip or shrink.

In: a chart with its map. Out: seams that split it; small charts joined to neighbours; maps laid out anew.
SCAF is Jiang, Schaefer, Panozzo 2017.
"""

from .bijective import made_bijective
from .bisection import halves
from .crease_cuts import is_isometric, parted
from .local_relayout import laid_narrower
from .overlap_seams import MAX_SPLITS, parts_between, seams_between, separating_seams
from .predicted_overlaps import coarse_mesh, overlaps_and_tips
from .reused_maps import EVEN, Known, Measured, kept_maps
from .scaf import make_bijective
from .small_charts import with_small_joined
from .tips import TIPPED, seam_to_fine_tips, seams_to_tips
