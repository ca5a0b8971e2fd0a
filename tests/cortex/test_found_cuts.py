"""Cuts that are found from the medial wall, without a template."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("nilearn")
from subjects import made_up_subject

from igl_linabf import MeshWarning
from igl_linabf.cortex import flatten_hemisphere

pytestmark = pytest.mark.usefixtures("few_sources")


@pytest.fixture(scope="module")
def subject(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made_up_subject(tmp_path_factory.mktemp("subjects") / "sub-01", 4, ("lh",))


def test_smaller_errors_need_longer_cuts(subject: Path) -> None:
    lengths = []
    for most in (0.3, 0.17):
        flat = flatten_hemisphere(subject, "lh", cuts="found", max_distance_error=most)
        assert flat.quality.distance_error <= most
        assert flat.quality.flips == flat.quality.overlaps == 0
        lengths.append(sum(map(len, flat.cuts.paths)))
        touching = flat.hemisphere.F[flat.cuts.wall[flat.hemisphere.F].any(axis=1)]
        assert all(np.isin(path, touching).any() for path in flat.cuts.paths)  # each cut begins at the wall
    assert lengths[0] < lengths[1]


@pytest.mark.slow
def test_an_unreachable_error_is_reported(subject: Path) -> None:
    with pytest.warns(MeshWarning, match=r"cuts leave an error of 0\.\d+ in distances, more than 0\.001"):
        flatten_hemisphere(subject, "lh", cuts="found", max_distance_error=0.001)
