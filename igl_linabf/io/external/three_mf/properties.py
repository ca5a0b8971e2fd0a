"""Read the properties of 3MF triangles: colours, materials, texture coordinates, and combinations of them."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ...._types import IntArray
from ...materials import Colour, Material, decode_srgb

PROPERTY_DTYPE = np.dtype([("resource", "<u4"), ("index", "<u4", 3)])  # properties of a triangle's corners
WHITE = (1.0, 1.0, 1.0, 1.0)


class PropertyGroup(NamedTuple):
    """A 3MF resource that defines properties.

    Attributes
    ----------
    kind : {"colour", "material", "texture", "several"}
    ids : (n,) int64
        The numbers of the properties in ascending order.
    rows : (n,) int64, or (n, layers) int64
        The row of each property in the table of its kind; for "several", the property number in each layer.
    layers : tuple of int
        For "several", the resource of each layer.
    """

    kind: str
    ids: IntArray
    rows: IntArray
    layers: tuple[int, ...] = ()


class Properties:
    """The properties of a model as tables of colours, materials and texture coordinates."""

    def __init__(self, model: Any) -> None:
        self.groups: dict[int, PropertyGroup] = {}
        colours, TC = [np.zeros((0, 4))], [np.zeros((0, 2))]
        self.materials: list[tuple[str, Material]] = []
        self.covered = False  # whether any triangle has a colour that replaces its material
        rows = 0
        for group in _iterate_resources(model.GetColorGroups()):
            ids = self._add_group(group, "colour", rows)
            shades = [group.GetColor(i) for i in ids]
            colours.append(
                np.array([(colour.Red, colour.Green, colour.Blue, colour.Alpha) for colour in shades]) / 255
            )
            rows += len(ids)
        for group in _iterate_resources(model.GetBaseMaterialGroups()):
            ids = self._add_group(group, "material", len(self.materials))
            self.materials += [(group.GetName(i), _make_material(group.GetDisplayColor(i))) for i in ids]
        rows = 0
        for group in _iterate_resources(model.GetTexture2DGroups()):
            ids = self._add_group(group, "texture", rows)
            pairs = [group.GetTex2Coord(i) for i in ids]
            TC.append(np.array([(pair.U, pair.V) for pair in pairs]).reshape(-1, 2))
            rows += len(ids)
        for group in _iterate_resources(model.GetMultiPropertyGroups()):
            layers = tuple(group.GetLayer(i).ResourceID for i in range(group.GetLayerCount()))
            ids = sorted(group.GetAllPropertyIDs())
            table = [
                group.GetMultiProperty(i, [0] * len(layers)) for i in ids
            ]  # lib3mf requires a list with one entry per layer
            several = np.array(table, dtype=np.int64).reshape(-1, len(layers))
            self.groups[group.GetResourceID()] = PropertyGroup("several", np.array(ids), several, layers)
        self.colours, self.TC = np.concatenate(colours), np.concatenate(TC)

    def _add_group(self, group: Any, kind: str, start: int) -> list[int]:
        ids = sorted(group.GetAllPropertyIDs())
        numbers = np.array(ids, dtype=np.int64)
        self.groups[group.GetResourceID()] = PropertyGroup(kind, numbers, start + np.arange(len(ids)))
        return ids

    def find_corner_rows(self, mesh: Any) -> dict[str, IntArray]:
        """Return the table rows of triangle corners, (#T, 3), by kind of property; -1 for no property."""
        corner_properties = np.frombuffer(
            b"".join(map(bytes, mesh.GetAllTriangleProperties())), dtype=PROPERTY_DTYPE
        )
        tables = {
            kind: np.full((len(corner_properties), 3), -1) for kind in ("colour", "material", "texture")
        }
        for resource in np.unique(corner_properties["resource"]).tolist():
            triangles = np.flatnonzero(corner_properties["resource"] == resource)
            self._fill_corner_rows(
                tables, resource, triangles, corner_properties["index"][triangles].astype(np.int64)
            )
        return tables

    def _fill_corner_rows(
        self, tables: dict[str, IntArray], resource: int, triangles: IntArray, index: IntArray
    ) -> None:
        group = self.groups.get(resource)
        if group is None or not len(group.ids):
            return
        place = np.minimum(np.searchsorted(group.ids, index), len(group.ids) - 1)
        is_found = group.ids[place] == index
        if group.kind != "several":
            tables[group.kind][triangles] = np.where(is_found, group.rows[place], -1)
            return
        for layer, inner in enumerate(group.layers):
            self._fill_corner_rows(
                tables, inner, triangles, np.where(is_found, group.rows[place][..., layer], 0)
            )
        covered = triangles[
            (tables["colour"][triangles] >= 0).all(axis=1) & (tables["material"][triangles] >= 0).any(axis=1)
        ]
        tables["material"][covered] = -1
        self.covered |= len(covered) > 0


def _make_material(colour: Any) -> Material:
    red, green, blue, alpha = (getattr(colour, name) / 255 for name in ("Red", "Green", "Blue", "Alpha"))
    light = decode_srgb(np.array((red, green, blue))).tolist()
    return Material(colour=Colour(red, green, blue), alpha=alpha, factor=(*light, alpha))


def _iterate_resources(resources: Any) -> Iterator[Any]:
    """Yield the resources of a lib3mf iterator with their specific types."""
    get = next(name for name in dir(resources) if name.startswith("GetCurrent") and name != "GetCurrent")
    while resources.MoveNext():
        yield getattr(resources, get)()


def assign_colours(
    rows_of_kind: dict[str, IntArray], properties: Properties, corners: IntArray, n: int
) -> dict[str, Any]:
    """Return colours as a field of `Extras`: per vertex if possible, otherwise per face or per corner.

    Corners without a colour are white, the neutral factor of material colours.

    Parameters
    ----------
    rows_of_kind : dict of (#T, 3) int64
        The rows of the tables, from `Properties.find_corner_rows`.
    properties : Properties
    corners : (3 #T,) int64
        The vertices at the corners.
    n : int
        The number of vertices.
    """
    rows = rows_of_kind["colour"]
    if (rows < 0).all():
        return {}
    shades = np.vstack((properties.colours, WHITE))
    if (shades[np.unique(rows), 3] == 1).all():
        shades = shades[:, :3]
    of_corners = shades[rows.ravel()]
    vertices = np.ones((n, shades.shape[1]))
    vertices[corners] = of_corners
    if (vertices[corners] == of_corners).all():
        return {"colours": vertices}
    if (rows == rows[:, :1]).all():
        return {"face_colours": shades[rows[:, 0]]}
    return {"corner_colours": of_corners}
