"""Maps whose seams shift a periodic texture by whole periods, so that it goes on across them.

In: charts whose seams turn by quarter turns. Out: the charts shifted, and the period that fits.
"""

from .period import with_period
