"""How results show themselves in a notebook.

In: the rows of a table; a map and its triangles. Out: HTML, and a small picture in SVG.
"""

from .pages import html_row, html_table, map_svg
