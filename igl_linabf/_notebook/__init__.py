"""Represent results in notebooks, as HTML tables and small SVG pictures of maps."""

from .pages import html_row, html_table, map_svg
