"""Draw the subpackages in the order of the import contracts in pyproject.toml, as images/rooms.svg.

python docs/rooms_picture.py
"""

from __future__ import annotations

import sys
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parent.parent
PICTURE = ROOT / "docs" / "images" / "rooms.svg"
PACKAGE = "igl_linabf"
Layers = list[list[str]]
WIDTH, HEIGHT, GAP = 130, 24, 6  # size of a box, and distance between boxes, in pixels
HEAD, EDGE = 30, 14  # heading above a column, and margin of the picture, in pixels
COLUMNS = (("charts", "angles", "surface"), ("flattening", "layouts", "io"))  # beside the whole package


def read_layers() -> dict[str, Layers]:
    """Return the layers of each subpackage with a contract. A layer imports only from the layers after it."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    layers_of_room = {}
    for contract in tomllib.loads(text)["tool"]["importlinter"]["contracts"]:
        for container in contract.get("containers", ()):
            layers = [[name.strip() for name in layer.split("|")] for layer in contract["layers"]]
            layers_of_room[container.removeprefix(PACKAGE).lstrip(".")] = layers
    return layers_of_room


def draw_column(room: str, layers: Layers, x: int, y: int, inner: set[str]) -> tuple[list[str], int, int]:
    """Return the SVG lines of a subpackage, and its width and height in pixels."""
    across = max(map(len, layers))
    width = across * (WIDTH + GAP) - GAP
    lines = [f'<text x="{x}" y="{y + 16}" font-weight="bold">{room or PACKAGE}</text>']
    for i, layer in enumerate(layers):
        each = (width - GAP * (len(layer) - 1)) / len(layer)
        for k, name in enumerate(layer):
            left, top = x + k * (each + GAP), y + HEAD + i * (HEIGHT + GAP)
            fill = "#cfe3ff" if name in inner and not room else "#f2f2f2"
            box = f'x="{left:g}" y="{top}" width="{each:g}" height="{HEIGHT}"'
            lines.append(f'<rect {box} rx="4" fill="{fill}" stroke="#777"/>')
            lines.append(f'<text x="{left + each / 2:g}" y="{top + 16}" text-anchor="middle">{name}</text>')
    return lines, width, HEAD + len(layers) * (HEIGHT + GAP)


def draw_rooms() -> str:
    """Return the picture as SVG."""
    layers = read_layers()
    x, lowest, lines = EDGE, 0, []
    for rooms in (("",), *COLUMNS):
        y, widest = EDGE, 0
        for room in rooms:
            boxes, width, height = draw_column(room, layers[room], x, y, set(layers))
            lines += boxes
            y, widest = y + height + 2 * GAP, max(widest, width)
        x, lowest = x + widest + 5 * GAP, max(lowest, y)
    size = f'width="{x}" height="{lowest + EDGE}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif" font-size="12">'
    return "\n".join([head, '<rect width="100%" height="100%" fill="white"/>', *lines, "</svg>", ""])


if __name__ == "__main__":
    PICTURE.write_text(draw_rooms(), encoding="utf-8")
