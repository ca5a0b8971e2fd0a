"""Methods that harm their own process on chosen meshes, to test batches."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from igl_linabf.flattening import LSCM, Method


@dataclass(frozen=True)
class Hostile(Method):
    """LSCM that crashes or fails on meshes with certain numbers of faces, after a pause.

    On large meshes, the method waits until a file exists, at most for ten minutes.
    """

    aborts: int = 0
    aborts_once: int = 0
    allocates: int = 0
    fails: int = 0
    flag: str = ""
    pause: float = 0.0
    waits: int = 0
    name = label = "hostile"

    def run(self, mesh, pinned):
        time.sleep(self.pause)
        faces = len(mesh.double_area)
        end = time.monotonic() + 600
        while 0 < self.waits <= faces and not Path(self.flag).exists() and time.monotonic() < end:
            time.sleep(0.02)
        if faces == self.aborts:
            os.abort()
        if faces == self.aborts_once and not Path(self.flag).exists():
            Path(self.flag).touch()
            os.abort()
        if faces == self.allocates:
            np.ones(2**27)  # allocates 1 GiB
        if faces == self.fails:
            raise ZeroDivisionError("a mistake in the program")
        return LSCM().run(mesh, pinned)
