"""The store: one DuckDB file. The only part of motiondb that knows DuckDB.

Open it with :func:`open_store`; functions ``load_...`` and ``save_...`` take the open store first.
``schema.sql`` in ``motiondb.schema`` describes the tables. What only some commands need is imported
when one of its names is first used, so that the command line starts fast.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from motiondb.files.packed_files import Source, digest, leave_out, pack_source
from motiondb.store.catalogue.annotations import (
    load_captions,
    load_events,
    load_relations,
    load_synonyms,
    load_texts,
    save_captions,
    save_events,
    save_relations,
    save_synonyms,
    save_tags,
)
from motiondb.store.catalogue.cache import (
    CaptureRows,
    CheckedRows,
    Made,
    cache_bytes,
    cached_arrays,
    cached_rows,
    cached_segment_rows,
    is_cached,
    lacking_rows,
    readable_motions,
    segment_rows,
)
from motiondb.store.catalogue.captures import (
    load_capture,
    load_captured,
    load_captures,
    load_digests,
    load_motion,
    load_totals,
    remove_capture,
    rename_capture,
    save_capture,
)
from motiondb.store.catalogue.faulty import (
    NotSaved,
    is_noted,
    load_faulty,
    load_same_files,
    save_not_saved,
)
from motiondb.store.catalogue.names import check_new_name
from motiondb.store.catalogue.parquet_files import load_parquet_files
from motiondb.store.catalogue.runs import (
    copy_run,
    finish_run,
    load_runs,
    note_in_run,
    running,
    save_runs,
    start_run,
)
from motiondb.store.catalogue.sources import (
    fill_in,
    load_left_out,
    load_packed_source,
    load_source,
)
from motiondb.store.catalogue.trash import load_trash, restore_capture
from motiondb.store.catalogue.where import (
    CAPTION,
    COLUMNS,
    HEADS,
    Condition,
    Filter,
    OneOf,
    matches,
    parse_where,
)
from motiondb.store.compaction import backup, compact, count_rows, unused_bytes
from motiondb.store.connection.faults import DamagedFileError, damage_sentence
from motiondb.store.connection.handle import Store, bounded_memory, released
from motiondb.store.connection.migrations import motiondb_version
from motiondb.store.connection.opening import open_store
from motiondb.store.connection.transactions import (
    check_writable,
    content_revision,
    reading,
    revision,
    transaction,
)
from motiondb.store.connection.turns import somebody_waits
from motiondb.store.learned import (
    has_parameter,
    is_learned,
    learning_is_current,
    learning_mark,
    load_learned_captures,
    load_learning,
    load_learning_size,
    load_parameters,
    load_scores,
    load_segments,
    load_space,
    load_symbols,
    load_transition_counts,
    load_unlearned,
    load_words,
    save_learning,
)

if TYPE_CHECKING:
    from motiondb.store.catalogue.edits import (
        SYNONYMS,
        UNDO,
        Edit,
        find_undoable,
        load_edits,
        noting_edits,
    )
    from motiondb.store.catalogue.generated import (
        Provenance,
        SourceCapture,
        load_provenance,
        save_provenance,
        to_provenance,
    )
    from motiondb.store.catalogue.known_files import KnownFile, load_known_files, save_known_files
    from motiondb.store.checks import check_quickly, check_store
    from motiondb.store.grammars import (
        Derivation,
        GrammarSize,
        GrammarSource,
        StoredGrammar,
        load_derivation,
        load_derivations,
        load_grammar,
        load_grammar_names,
        load_grammar_sizes,
        load_source_numbers,
        remove_grammar,
        save_derivation,
        save_grammar,
    )
    from motiondb.store.moving import move_motions
    from motiondb.store.salvage import (
        SalvagedCapture,
        check_places,
        copy_shared,
        opened_damaged,
        salvage_captures,
        salvage_runs,
        was_learned,
    )
    from motiondb.store.scenes import (
        SceneClip,
        ScenePlayer,
        SceneRule,
        StoredScene,
        load_scene,
        load_scene_captures,
        load_scene_names,
        remove_scene,
        save_scene,
    )

_LATER = {
    "catalogue.edits": "SYNONYMS UNDO Edit find_undoable load_edits noting_edits",
    "catalogue.generated": "Provenance SourceCapture load_provenance save_provenance to_provenance",
    "catalogue.known_files": "KnownFile load_known_files save_known_files",
    "checks": "check_quickly check_store",
    "grammars": "Derivation GrammarSize GrammarSource StoredGrammar load_derivation "
    "load_derivations load_grammar load_grammar_names load_grammar_sizes "
    "load_source_numbers remove_grammar save_derivation save_grammar",
    "moving": "move_motions",
    "salvage": "SalvagedCapture check_places copy_shared opened_damaged "
    "salvage_captures salvage_runs was_learned",
    "scenes": "SceneClip ScenePlayer SceneRule StoredScene load_scene "
    "load_scene_captures load_scene_names remove_scene save_scene",
}  # The names of modules that are imported when one of them is used, separated by spaces
_MODULES = {name: module for module, names in _LATER.items() for name in names.split()}


def __getattr__(name: str) -> object:
    """Import the module that has a name."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
