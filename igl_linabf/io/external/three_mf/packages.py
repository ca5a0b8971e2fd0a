"""Find contents of a 3MF package that lib3mf does not read."""

import re
from pathlib import Path
from zipfile import ZipFile

from ...limits import CHUNK, check_expansion, reject_entities

NAMESPACE_PATTERN = re.compile(rb"""xmlns:([\w.-]+)\s*=\s*["']([^"']*)""")
# Prefixes of the 3MF Consortium's namespaces, which lib3mf reads.
CONSORTIUM_NAMESPACES = (
    b"http://schemas.microsoft.com/3dmanufacturing/",
    b"http://schemas.3mf.io/3dmanufacturing/",
)
TRIANGLE_PATTERN = re.compile(rb"<(?:[\w.-]+:)?triangle\s([^>]*)")
ATTRIBUTE_PATTERN = re.compile(rb"([\w:.-]+)\s*=")
XML_SUFFIXES = (".model", ".rels", ".xml")
TRIANGLE_ATTRIBUTES = {b"v1", b"v2", b"v3", b"p1", b"p2", b"p3", b"pid"}


def check_package(path: str) -> None:
    """Raise `Damaged` if a 3MF package is too large after decompression, or declares XML entities."""
    size, taken = Path(path).stat().st_size, 0
    with ZipFile(path) as package:
        for entry in package.infolist():
            with package.open(entry) as file:
                head = file.read(CHUNK)
                if entry.filename.lower().endswith(XML_SUFFIXES):
                    reject_entities(head)
                chunk = head
                while chunk:  # count the bytes, because the sizes in the ZIP directory may be wrong
                    taken += len(chunk)
                    check_expansion(taken, size, "its decompressed parts")
                    chunk = file.read(CHUNK)


def find_required_extensions(path: str) -> list[str]:
    """Return the namespaces that the models of a package require."""
    from xml.etree.ElementTree import iterparse

    found = dict[str, None]()
    with ZipFile(path) as package:
        for name in package.namelist():
            if not name.lower().endswith(".model"):
                continue
            uri_of_prefix = dict[str, str]()
            with package.open(name) as file:
                for event, element in iterparse(file, ("start-ns", "start")):
                    if event == "start":  # only the root element declares required extensions
                        prefixes = element.get("requiredextensions", "").split()
                        found |= {uri_of_prefix.get(prefix, prefix): None for prefix in prefixes}
                        break
                    uri_of_prefix[element[0]] = element[1]
    return list(found)


def list_unread_content(path: Path, known: set[str]) -> tuple[str, ...]:
    """Describe, for warnings, package parts that are not in `known` and contents of unknown extensions."""
    parts, spaces, attributes = list[str](), set[str](), set[str]()
    with ZipFile(path) as package:
        for name in package.namelist():
            if name.lower().endswith(".model"):
                data = package.read(name)
                used = {
                    prefix
                    for prefix, space in NAMESPACE_PATTERN.findall(data)
                    if not space.startswith(CONSORTIUM_NAMESPACES)
                    and re.search(rb"[<\s]" + re.escape(prefix) + b":", data)
                }
                spaces |= {prefix.decode(errors="backslashreplace") for prefix in used}
                words = {
                    attribute
                    for found in TRIANGLE_PATTERN.finditer(data)
                    for attribute in ATTRIBUTE_PATTERN.findall(found[1])
                }
                others = {attribute for attribute in words - TRIANGLE_ATTRIBUTES if b":" not in attribute}
                attributes |= {attribute.decode(errors="backslashreplace") for attribute in others}
            elif not (name in known or name.endswith((".rels", "/")) or name == "[Content_Types].xml"):
                parts.append(name)
    unread = {
        f"the parts {', '.join(parts)} of its package": parts,
        f"the contents of the namespaces {', '.join(sorted(spaces))}": spaces,
        f"the attributes {', '.join(sorted(attributes))} of triangles": attributes,
    }
    return tuple(what for what, is_there in unread.items() if is_there)
