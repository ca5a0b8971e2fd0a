"""The calls of xatlas-python 0.0.11: `import igl_linabf.xatlas as xatlas`.

Names, arguments, dtypes and errors agree with xatlas-python; `unwrap` makes the atlas. See the page "From
xatlas" for the differences.
"""

from .atlas import Atlas, Chart, parametrize
from .export import export
from .options import ChartOptions, ChartType, PackOptions

__version__ = "0.0.11"  # of xatlas-python

__all__ = ["Atlas", "Chart", "ChartOptions", "ChartType", "PackOptions", "export", "parametrize"]
