"""Maps whose seams shift a periodic texture by whole periods, so that it continues across them.

Input: charts whose seams turn by quarter turns. Output: the shifted charts, or a period that fits.
"""

from .period import shift_by_period
