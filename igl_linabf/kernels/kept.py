"""Where compiled loops are kept on disk. It needs numba, and is imported where that runs the loops."""

from hashlib import sha256
from typing import Any

from numba.core.caching import FunctionCache, IndexDataCacheFile


class Files(IndexDataCacheFile):  # type: ignore[misc]
    """An index of signatures, and a file of code for each.

    numba numbers the files, and writes the index first. Two processes that compile at once may then give one
    number to two signatures; and where the disk is full, the index may lead to a file of older loops. Either
    runs the wrong code. Here the name of a file follows from what is in it, and the index comes last.
    """

    def save(self, key: Any, data: Any) -> None:
        kind = sha256(repr((key, self._source_stamp, self._version)).encode()).hexdigest()[:16]
        name = self._data_name_pattern.format(number=int(kind, 16))
        self._save_data(name, data)
        self._save_index({**self._load_index(), key: name})


class Kept(FunctionCache):  # type: ignore[misc]
    """numba's cache of a function, whose entries are what they are said to be."""

    def __init__(self, loops: Any) -> None:
        super().__init__(loops)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = Files(self._cache_path, self._impl.filename_base, stamp)
