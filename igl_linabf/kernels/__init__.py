from .drawing import drawn
from .drawn_loops import drawn_loops
from .lines_across import divisions
from .places import placed, taken_cells
from .rectangles import narrowest_turns
from .shelves import on_shelves
