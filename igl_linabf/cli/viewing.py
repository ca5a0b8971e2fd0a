"""Define the command `igl-linabf view`."""

from functools import partial
from typing import Annotated

from ..io import read_mesh, replacing
from ..measures import Measure
from .arguments import ALLOW_OUTSIDE, Boundary, ConeCount, MethodName, Option
from .jobs import FORCE, ExitCode, Job

MESH = Option("OBJ, OFF, PLY, STL, GLB, glTF, 3MF, GIFTI, FreeSurfer or VTP file", "MESH")
SCREENSHOT = Option("write a picture instead of opening a window", "OUT.png", flags=("--screenshot",))


def view_mesh(
    job: Annotated[
        Job, {"given": MESH, "allow_outside": ALLOW_OUTSIDE, "picture": SCREENSHOT, "force": FORCE}
    ],
    *,
    method: MethodName = "linabf",
    boundary: Boundary = "free",
    cones: ConeCount = None,
    measure: Annotated[Measure | None, Option("distortion to show instead of the checkerboard")] = None,
    frequency: Annotated[float, Option("checkerboard squares along the map", "N")] = 30.0,
) -> ExitCode:
    """Open a window with a surface and its flat map side by side.

    In the window, h lists the keys.

    Examples
    --------
    bunny.obj
    bunny.obj --method abf --frequency 60
    scene/bunny.gltf --allow-outside    # its buffer is in another folder
    face.obj --boundary circle
    bunny.obj --cones auto    # the cones as spheres, both sides of a seam in one colour
    bunny.obj --measure area --screenshot bunny.png    # opens no window
    bunny.obj --screenshot bunny.png --force    # replaces an older picture
    """
    from ..plot import view

    V, F = read_mesh(job.mesh, allow_outside=job.allow_outside)
    draw = partial(
        view, V, F, method=method, boundary=boundary, cones=cones, measure=measure, frequency=frequency
    )
    if job.picture is None:
        draw(title=f"igl_linabf: {job.mesh.name}", save_as=job.mesh.stem)  # saves to the current folder
    else:
        with replacing(job.picture) as temporary:
            draw(off_screen=True, screenshot=temporary)
            job.on_commit()
    return ExitCode.GOOD
