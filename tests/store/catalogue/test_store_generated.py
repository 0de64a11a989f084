"""Every frame of a generated capture names its source and its licence (X2)."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

from motiondb import store
from motiondb.errors import QueryError


@pytest.fixture
def filled(database: store.Store, samples: ModuleType) -> store.Store:
    samples.add(database, "a", tags={"licence": "CC0"})
    samples.add(database, "bb", tags={"licence": "research only"})
    samples.add(database, "ccc", tags={})
    samples.add(database, "dddd", n_frames=5, kind="generated")
    return database


def test_provenance_comes_back_with_licences(filled: store.Store, samples: ModuleType) -> None:
    ids = np.array([2, 2, 1, -1, 3])
    frames = np.array([3.0, 4.5, 0.0, 0.0, 7.0])
    edits = ("", "blend 0.50", "foot lock", "drawn", "")
    provenance = store.to_provenance(filled, ids, frames, np.full(5, 1.5), edits)
    assert [source.name for source in provenance.sources] == ["a", "bb", "ccc"]
    assert provenance.licences == ("research only", "research only", "CC0", "", "")
    store.save_provenance(filled, 4, provenance)
    store.save_provenance(filled, 4, provenance)
    samples.assert_equal(store.load_provenance(filled, 4), provenance)
    assert store.check_store(filled) == []


def test_provenance_outlives_its_source_and_goes_with_its_capture(filled: store.Store) -> None:
    provenance = store.to_provenance(filled, np.full(5, 2), np.arange(5))
    store.save_provenance(filled, 4, provenance)
    store.remove_captures(filled, [2])
    assert store.load_provenance(filled, 4).licences == ("research only",) * 5
    assert store.check_store(filled) == []
    store.remove_captures(filled, [4])
    assert store.count_rows(filled)["frame_source"] == 0
    assert store.count_rows(filled)["generated_source"] == 0


def test_an_unknown_source_is_told(filled: store.Store) -> None:
    with pytest.raises(QueryError, match=r"capture 77: expected a capture in .*, found none"):
        store.to_provenance(filled, np.array([77]), np.array([0]))


def test_frames_without_source_are_a_fault(filled: store.Store) -> None:
    store.save_provenance(filled, 4, store.to_provenance(filled, np.full(5, 2), np.arange(5)))
    filled.connection.execute("DELETE FROM frame_source WHERE frame = 2")
    assert store.check_store(filled) == [
        "dddd: expected one known source for every frame, found others."
    ]
