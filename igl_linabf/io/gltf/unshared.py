"""List the contents of a glTF file that other formats cannot store."""

from typing import Any

from .extensions import iterate_extended, iterate_objects

# Extensions that this package interprets, or that do not change the mesh as it is read.
HANDLED_EXTENSIONS = ("FB_ngon_encoding", "KHR_mesh_quantization")
SHARED_ATTRIBUTES = ("POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "COLOR_0")
SKIN_PREFIXES = ("JOINTS_", "WEIGHTS_")


def list_unshared(text: dict[str, Any], instance_count: int) -> tuple[str, ...]:
    """Describe, for warnings, the contents of a glTF file that other formats cannot store.

    `instance_count` is the number of further instances of its meshes.
    """
    found = [f"its {name}" for name in ("animations", "skins", "cameras") if text.get(name)]
    if len(text.get("scenes", ())) > 1:
        found.append(f"its {len(text['scenes'])} scenes")
    # do not report a hierarchy with a single parent, which may be just the root node
    if sum(bool(node.get("children")) for node in text.get("nodes", ())) > 1:
        found.append("its node hierarchy")
    if instance_count:
        found.append(f"{instance_count} further instances of its meshes")
    primitives = [entry for mesh in text.get("meshes", ()) for entry in mesh.get("primitives", ())]
    if any("targets" in entry for entry in primitives):
        found.append("its shape keys")
    if any(entry.get("mode", 4) < 4 for entry in primitives):
        found.append("its points and lines")
    if 0 < sum("NORMAL" in entry.get("attributes", {}) for entry in primitives) < len(primitives):
        found.append("normals, which not all of its primitives have")
    names = {name for entry in primitives for name in entry.get("attributes", {})}
    names -= {name for name in names if name in SHARED_ATTRIBUTES or name.startswith(SKIN_PREFIXES)}
    if names:
        found.append(f"the attributes {', '.join(sorted(names))}")
    extensions = {name for holder in iterate_extended(text) for name in holder["extensions"]} - set(
        HANDLED_EXTENSIONS
    )
    if extensions:
        found.append(f"the extensions {', '.join(sorted(extensions))}")
    if any(entry.get("alphaMode") == "MASK" for entry in text.get("materials", ())):
        found.append("the alpha cutoff of its materials")
    if any("extras" in holder for holder in iterate_objects(text)):
        found.append("its extras")
    if text.get("asset", {}).get("copyright"):
        found.append("its copyright")
    return tuple(found)
