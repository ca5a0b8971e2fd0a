"""What the package of a 3MF file has that lib3mf does not read."""

import re
from pathlib import Path
from zipfile import ZipFile

SPACE = re.compile(rb"""xmlns:([\w.-]+)\s*=\s*["']([^"']*)""")
# Name spaces of the consortium, by which lib3mf reads core, materials, production and so on.
OWN_SPACES = (b"http://schemas.microsoft.com/3dmanufacturing/", b"http://schemas.3mf.io/3dmanufacturing/")
TRIANGLE = re.compile(rb"<(?:[\w.-]+:)?triangle\s([^>]*)")
ATTRIBUTE = re.compile(rb"([\w:.-]+)\s*=")
OF_TRIANGLES = {b"v1", b"v2", b"v3", b"p1", b"p2", b"p3", b"pid"}


def required_extensions(path: str) -> list[str]:
    """The name spaces that the models of a package require."""
    from xml.etree.ElementTree import iterparse

    found = dict[str, None]()
    with ZipFile(path) as package:
        for name in package.namelist():
            if not name.lower().endswith(".model"):
                continue
            spaces = dict[str, str]()
            with package.open(name) as file:
                for event, of in iterparse(file, ("start-ns", "start")):
                    if event == "start":  # the first element has them
                        prefixes = of.get("requiredextensions", "").split()
                        found |= {spaces.get(prefix, prefix): None for prefix in prefixes}
                        break
                    spaces[of[0]] = of[1]
    return list(found)


def package_rest(path: Path, known: set[str]) -> tuple[str, ...]:
    """What is left aside, as a warning names it: parts that are not `known`, and what other programs add."""
    parts, spaces, attributes = list[str](), set[str](), set[str]()
    with ZipFile(path) as package:
        for name in package.namelist():
            if name.lower().endswith(".model"):
                data = package.read(name)
                used = {
                    prefix
                    for prefix, space in SPACE.findall(data)
                    if not space.startswith(OWN_SPACES)
                    and re.search(rb"[<\s]" + re.escape(prefix) + b":", data)
                }
                spaces |= {prefix.decode(errors="backslashreplace") for prefix in used}
                words = {of for found in TRIANGLE.finditer(data) for of in ATTRIBUTE.findall(found[1])}
                others = {of for of in words - OF_TRIANGLES if b":" not in of}
                attributes |= {of.decode(errors="backslashreplace") for of in others}
            elif not (name in known or name.endswith((".rels", "/")) or name == "[Content_Types].xml"):
                parts.append(name)
    there = {
        f"the parts {', '.join(parts)} of its package": parts,
        f"what is in the name spaces {', '.join(sorted(spaces))}": spaces,
        f"the attributes {', '.join(sorted(attributes))} of triangles": attributes,
    }
    return tuple(what for what, is_there in there.items() if is_there)
