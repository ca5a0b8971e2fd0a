"""Any surface as an atlas of charts.

In: V, F of any manifold. Out: seams; the surface cut along them; an `Atlas` of flat, packed charts.
Handles are cut as in Erickson, Whittlesey 2005. Seam branches follow the conformal scale of Sawhney, Crane
2017. SCAF is Jiang, Schaefer, Panozzo 2017.
"""

from .atlas import Atlas, Chart
from .cones import find_cones
from .given_seams import texture_seams
from .overlap_seams import separating_seams
from .packing import pack
from .scaf import make_bijective
from .seams import TRADE, cut, find_seams
from .spacing import PADDING, Spacing
from .together import pack_together
from .unwrapping import unwrap
