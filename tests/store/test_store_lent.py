"""A file that one thread has let go of, as `learn` does, can be written by another thread."""

from __future__ import annotations

from pathlib import Path

from motiondb import store


def test_a_lent_store_is_written_and_lent_again(database: store.Store) -> None:
    database.lend()
    try:
        assert store.load_captures(database) == []  # opens it for reading
        store.save_synonyms(database, {"stroll": "walk"})
        with store.open_store(database.path, read_only=True) as other:
            assert store.load_synonyms(other) == {"stroll": "walk"}
    finally:
        database.take_back()
    store.save_synonyms(database, {"stroll": "run"})
    assert store.load_synonyms(database) == {"stroll": "run"}
    assert Path(database.path).is_file()
