"""Represent results in notebooks, as HTML tables and small SVG pictures of maps."""

from .pages import arrange_html_row, draw_map_as_svg, format_html_table
