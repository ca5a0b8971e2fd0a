"""What a file of glTF has that other formats have not."""

from typing import Any

from .extensions import extended, objects

# Extensions whose content is read, or changes no number that is.
TAKEN = ("FB_ngon_encoding", "KHR_mesh_quantization")
SHARED = ("POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "COLOR_0")
OF_SKINS = ("JOINTS_", "WEIGHTS_")


def unshared(text: dict[str, Any], further: int) -> tuple[str, ...]:
    """What a description has beyond its surface, as a warning names it; `further` instances of its meshes."""
    said = [f"its {name}" for name in ("animations", "skins", "cameras") if text.get(name)]
    if len(text.get("scenes", ())) > 1:
        said.append(f"its {len(text['scenes'])} scenes")
    if sum(bool(node.get("children")) for node in text.get("nodes", ())) > 1:  # one is the root of all
        said.append("its tree of nodes")
    if further:
        said.append(f"{further} further instances of its meshes")
    primitives = [of for mesh in text.get("meshes", ()) for of in mesh.get("primitives", ())]
    if any("targets" in of for of in primitives):
        said.append("its shape keys")
    if any(of.get("mode", 4) < 4 for of in primitives):
        said.append("its points and lines")
    if 0 < sum("NORMAL" in of.get("attributes", {}) for of in primitives) < len(primitives):
        said.append("normals, which not all of its primitives have")
    names = {name for of in primitives for name in of.get("attributes", {})}
    names -= {name for name in names if name in SHARED or name.startswith(OF_SKINS)}
    if names:
        said.append(f"the attributes {', '.join(sorted(names))}")
    extensions = {name for holder in extended(text) for name in holder["extensions"]} - set(TAKEN)
    if extensions:
        said.append(f"the extensions {', '.join(sorted(extensions))}")
    if any(of.get("alphaMode") == "MASK" for of in text.get("materials", ())):
        said.append("where its materials are cut off")
    if any("extras" in holder for holder in objects(text)):
        said.append("its extras")
    if text.get("asset", {}).get("copyright"):
        said.append("its copyright")
    return tuple(said)
