"""Many meshes: in come files, folders and globs; out come files of maps and a table with a row for each.

Dask hands them out, on this machine or on a cluster. `one_mesh` is what its workers do, `table` what is known
of the inputs and survives any end of the process, `places` folders and URLs.
"""

from .running import Batch, batch
from .table import Row
