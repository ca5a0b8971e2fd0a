"""The outcome of a flattening, and its message."""

from .._types import IntArray
from ..errors import some
from ..surface import ALL_DIGITS, SPAN
from .result import Outcome


def judge(
    ratio: float,
    made: str,
    solver: str,
    flipped: IntArray,
    residual: float,
    invalid: IntArray,
    *,
    converged: bool = False,
    note: str = "",
    pins: int = 0,
) -> tuple[Outcome, str]:
    """The outcome, and a sentence that explains it.

    Parameters
    ----------
    ratio : float
        Of the map's largest area scale to its smallest one.
    made, solver : str
        The layout, and what solved it.
    flipped, invalid : int64 arrays
        Faces that are flipped in the map; faces with a target angle outside (0, pi).
    residual : float
        The largest of the target angles.
    converged : bool
        Whether the method's tolerance was reached.
    note : str
        Why it was not reached; "" if no convergence was asked for.
    pins : int
        How many vertices were pinned.
    """
    fit = f"largest angle residual {residual:.1e}"
    if len(invalid):
        return Outcome.ANGLES_INVALID, (
            f"the target angles of faces {some(invalid)} are outside (0, pi), and {len(flipped)} triangles "
            "of the map are flipped: use safeguard=True, or abf"
        )
    wide = ""
    if ratio > SPAN:
        wide = f"area scale varies by a factor of {ratio:.0e}{' or more' if ratio > ALL_DIGITS else ''}"
    if not len(flipped):
        cut = "near the end of double precision: cut the mesh, for example by igl_linabf.unwrap"
        end = f"; the map's {wide}, {cut}" if wide else ""
        if made in ("SLIM", "isometric", "embedding"):
            if note:
                return Outcome.NOT_CONVERGED, f"no triangle is flipped, but {note}, by {solver}{end}"
            return Outcome.VALID, f"no triangle is flipped, by {solver}{end}"
        if converged:
            return Outcome.CONVERGED, f"no triangle is flipped; {fit}{end}"
        if not note:
            return Outcome.VALID, f"no triangle is flipped; {fit}{end}"
        return Outcome.NOT_CONVERGED, (
            f"no triangle is flipped, but {note} ({fit}): look for degenerate faces, or cut the mesh{end}"
        )
    where = f"faces {some(flipped)} are flipped or collapsed"
    helps = (
        "cut the mesh towards them (igl_linabf.unwrap does this for you), or use guarantee='injective', "
        "which gives a map without flips, but with more distortion"
    )
    if pins > 2:
        return Outcome.FLIPPED, (
            f"{where}, as {pins} pins may ask for: pin fewer vertices, or use method='isometric', which "
            "comes as near to them as it can without flips"
        )
    if not converged:
        return Outcome.FLIPPED, f"{where}: {note or 'more iterations may help'} ({fit}); {helps}"
    if wide:
        return Outcome.FLIPPED, (
            f"{where}: the map's {wide}, more than double precision holds ({fit}); {helps}"
        )
    return Outcome.FLIPPED, f"{where}, though the angles converged ({fit}): {helps}"
