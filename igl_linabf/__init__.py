"""Linear angle based parameterization of triangle meshes, beside libigl.

>>> import igl, igl_linabf
>>> V, F = igl.icosahedron()
>>> uv = igl_linabf.linabf(V, F[1:])
"""

from importlib import import_module

# A room is imported when one of its names is first used: so `igl-linabf` answers Ctrl-C before NumPy, SciPy
# and libigl are there, and importing the package costs nothing. Type checkers read __init__.pyi.
_NAMES = {
    "batch_runs": "batch",
    "charts": "Atlas AtlasCost Chart ChartOptions Cones Packing cut find_cones find_seams pack_together "
    "texture_seams unwrap",
    "cortex": "FlatHemisphere flatten_hemisphere flatten_hemispheres write_hemisphere",
    "errors": "FallbackWarning MemoryLimitError MeshError MeshWarning OutcomeWarning SingularSystemError",
    "flattening": "ABF DNCP LSCM SCP Comparison Flattener Flattening Hole Isometric LinABF OneStepABFpp "
    "Outcome Residuals abf compare flatten flatten_many linabf linabf_angles lscm",
    "io": "write_grid",
    "layouts": "layout",
    "measures": "Quality distance_error distortion overlaps quality",
    "patterns": "Pattern write_pattern",
    "remesh": "QuadGrid quad_grid",
    "surface": "Cleaned Repair clean split_chords",
    "textures": "bake bake_texture",
    "uv_sets": "PackedUV UVCheck check_uv pack",
}
_ROOM = {name: room for room, names in _NAMES.items() for name in names.split()}
__all__ = sorted(["adapters", "io", *_ROOM])
_ROOMS = {*_NAMES, "adapters", "angles", "_core", "linalg"}


def __getattr__(name: str) -> object:
    if name in _ROOMS:
        return import_module(f"{__name__}.{name}")
    if name == "__version__":
        from importlib.metadata import version  # takes as long as the rest of this module

        value: object = version("igl-linabf")
        globals()[name] = value
        return value
    if name not in _ROOM:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(f"{__name__}.{_ROOM[name]}"), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_ROOMS, "__version__"})
