"""Where the names of the store stand: __init__.py imports a module when one is used."""

from .catalogue.annotations import (
    load_captions as load_captions,
)
from .catalogue.annotations import (
    load_events as load_events,
)
from .catalogue.annotations import (
    load_quality as load_quality,
)
from .catalogue.annotations import (
    load_relations as load_relations,
)
from .catalogue.annotations import (
    load_synonyms as load_synonyms,
)
from .catalogue.annotations import (
    load_texts as load_texts,
)
from .catalogue.annotations import (
    save_captions as save_captions,
)
from .catalogue.annotations import (
    save_events as save_events,
)
from .catalogue.annotations import (
    save_quality as save_quality,
)
from .catalogue.annotations import (
    save_relations as save_relations,
)
from .catalogue.annotations import (
    save_synonyms as save_synonyms,
)
from .catalogue.annotations import (
    save_tags as save_tags,
)
from .catalogue.cache import (
    CaptureRows as CaptureRows,
)
from .catalogue.cache import (
    Made as Made,
)
from .catalogue.cache import (
    cache_bytes as cache_bytes,
)
from .catalogue.cache import (
    cached_arrays as cached_arrays,
)
from .catalogue.cache import (
    cached_rows as cached_rows,
)
from .catalogue.cache import (
    cached_segment_rows as cached_segment_rows,
)
from .catalogue.cache import (
    is_cached as is_cached,
)
from .catalogue.cache import (
    lacking_rows as lacking_rows,
)
from .catalogue.captures import (
    MARKERS_ONLY as MARKERS_ONLY,
)
from .catalogue.captures import (
    NewCapture as NewCapture,
)
from .catalogue.captures import (
    has_body as has_body,
)
from .catalogue.captures import (
    load_capture as load_capture,
)
from .catalogue.captures import (
    load_captured as load_captured,
)
from .catalogue.captures import (
    load_captures as load_captures,
)
from .catalogue.captures import (
    load_digests as load_digests,
)
from .catalogue.captures import (
    load_motion as load_motion,
)
from .catalogue.captures import (
    load_named as load_named,
)
from .catalogue.captures import (
    load_poses as load_poses,
)
from .catalogue.captures import (
    load_totals as load_totals,
)
from .catalogue.captures import (
    readable_motions as readable_motions,
)
from .catalogue.captures import (
    remove_captures as remove_captures,
)
from .catalogue.captures import (
    rename_captures as rename_captures,
)
from .catalogue.captures import (
    save_capture as save_capture,
)
from .catalogue.captures import (
    save_captures as save_captures,
)
from .catalogue.captures import (
    unflatten_motion as unflatten_motion,
)
from .catalogue.joined_rows import (
    FileRows as FileRows,
)
from .catalogue.joined_rows import (
    JoinedRows as JoinedRows,
)
from .catalogue.names import (
    check_new_name as check_new_name,
)
from .catalogue.parquet_files import (
    load_parquet_files as load_parquet_files,
)
from .catalogue.runs import (
    SYNONYMS as SYNONYMS,
)
from .catalogue.runs import (
    UNDO as UNDO,
)
from .catalogue.runs import (
    Edit as Edit,
)
from .catalogue.runs import (
    change_tags as change_tags,
)
from .catalogue.runs import (
    copy_run as copy_run,
)
from .catalogue.runs import (
    find_undoable as find_undoable,
)
from .catalogue.runs import (
    finish_run as finish_run,
)
from .catalogue.runs import (
    load_edits as load_edits,
)
from .catalogue.runs import (
    load_run as load_run,
)
from .catalogue.runs import (
    load_runs as load_runs,
)
from .catalogue.runs import (
    load_trash as load_trash,
)
from .catalogue.runs import (
    note_in_run as note_in_run,
)
from .catalogue.runs import (
    noting_edits as noting_edits,
)
from .catalogue.runs import (
    restore_captures as restore_captures,
)
from .catalogue.runs import (
    running as running,
)
from .catalogue.runs import (
    save_runs as save_runs,
)
from .catalogue.runs import (
    start_run as start_run,
)
from .catalogue.selections import (
    MARKS as MARKS,
)
from .catalogue.selections import (
    SELECTION as SELECTION,
)
from .catalogue.selections import (
    Span as Span,
)
from .catalogue.selections import (
    join_selections as join_selections,
)
from .catalogue.selections import (
    read_selections as read_selections,
)
from .catalogue.selections import (
    write_selections as write_selections,
)
from .catalogue.sources import KnownFile as KnownFile
from .catalogue.sources import (
    NotSaved as NotSaved,
)
from .catalogue.sources import (
    Provenance as Provenance,
)
from .catalogue.sources import (
    SourceCapture as SourceCapture,
)
from .catalogue.sources import (
    fill_in as fill_in,
)
from .catalogue.sources import (
    is_noted as is_noted,
)
from .catalogue.sources import (
    load_faulty as load_faulty,
)
from .catalogue.sources import load_known_files as load_known_files
from .catalogue.sources import (
    load_left_out as load_left_out,
)
from .catalogue.sources import (
    load_packed_source as load_packed_source,
)
from .catalogue.sources import (
    load_provenance as load_provenance,
)
from .catalogue.sources import (
    load_same_files as load_same_files,
)
from .catalogue.sources import (
    load_source as load_source,
)
from .catalogue.sources import save_known_files as save_known_files
from .catalogue.sources import (
    save_not_saved as save_not_saved,
)
from .catalogue.sources import (
    save_provenance as save_provenance,
)
from .catalogue.sources import (
    to_provenance as to_provenance,
)
from .catalogue.where import (
    CAPTION as CAPTION,
)
from .catalogue.where import (
    COLUMNS as COLUMNS,
)
from .catalogue.where import (
    HEADS as HEADS,
)
from .catalogue.where import (
    Condition as Condition,
)
from .catalogue.where import (
    Filter as Filter,
)
from .catalogue.where import (
    OneOf as OneOf,
)
from .catalogue.where import (
    matches as matches,
)
from .catalogue.where import (
    parse_where as parse_where,
)
from .checks import (
    check_quickly as check_quickly,
)
from .checks import (
    check_store as check_store,
)
from .compaction import (
    backup as backup,
)
from .compaction import (
    compact as compact,
)
from .compaction import (
    count_rows as count_rows,
)
from .compaction import (
    unused_bytes as unused_bytes,
)
from .connection.faults import (
    DamagedFileError as DamagedFileError,
)
from .connection.faults import (
    damage_sentence as damage_sentence,
)
from .connection.handle import (
    Store as Store,
)
from .connection.handle import (
    bounded_memory as bounded_memory,
)
from .connection.handle import (
    released as released,
)
from .connection.migrations import motiondb_version as motiondb_version
from .connection.opening import (
    open_store as open_store,
)
from .connection.opening import (
    somebody_waits as somebody_waits,
)
from .connection.transactions import (
    check_writable as check_writable,
)
from .connection.transactions import (
    content_revision as content_revision,
)
from .connection.transactions import (
    reading as reading,
)
from .connection.transactions import (
    revision as revision,
)
from .connection.transactions import (
    transaction as transaction,
)
from .grammars import (
    Derivation as Derivation,
)
from .grammars import (
    GrammarSize as GrammarSize,
)
from .grammars import (
    GrammarSource as GrammarSource,
)
from .grammars import (
    StoredGrammar as StoredGrammar,
)
from .grammars import (
    load_derivation as load_derivation,
)
from .grammars import (
    load_derivations as load_derivations,
)
from .grammars import (
    load_grammar as load_grammar,
)
from .grammars import (
    load_grammar_names as load_grammar_names,
)
from .grammars import (
    load_grammar_sizes as load_grammar_sizes,
)
from .grammars import (
    load_source_numbers as load_source_numbers,
)
from .grammars import (
    remove_grammar as remove_grammar,
)
from .grammars import (
    save_derivation as save_derivation,
)
from .grammars import (
    save_grammar as save_grammar,
)
from .learned import (
    has_parameter as has_parameter,
)
from .learned import (
    is_learned as is_learned,
)
from .learned import (
    learning_is_current as learning_is_current,
)
from .learned import (
    learning_mark as learning_mark,
)
from .learned import (
    load_learned_captures as load_learned_captures,
)
from .learned import (
    load_learning as load_learning,
)
from .learned import (
    load_learning_size as load_learning_size,
)
from .learned import (
    load_parameters as load_parameters,
)
from .learned import (
    load_scores as load_scores,
)
from .learned import (
    load_segments as load_segments,
)
from .learned import (
    load_space as load_space,
)
from .learned import (
    load_symbols as load_symbols,
)
from .learned import (
    load_transition_counts as load_transition_counts,
)
from .learned import (
    load_unlearned as load_unlearned,
)
from .learned import (
    load_words as load_words,
)
from .learned import (
    save_learning as save_learning,
)
from .moving import (
    move_motions as move_motions,
)
from .salvage import (
    SalvagedCapture as SalvagedCapture,
)
from .salvage import (
    check_places as check_places,
)
from .salvage import (
    copy_shared as copy_shared,
)
from .salvage import (
    opened_damaged as opened_damaged,
)
from .salvage import (
    salvage_captures as salvage_captures,
)
from .salvage import (
    salvage_runs as salvage_runs,
)
from .salvage import (
    was_learned as was_learned,
)
from .scenes import (
    SceneClip as SceneClip,
)
from .scenes import (
    ScenePlayer as ScenePlayer,
)
from .scenes import (
    SceneRule as SceneRule,
)
from .scenes import (
    StoredScene as StoredScene,
)
from .scenes import (
    load_scene as load_scene,
)
from .scenes import (
    load_scene_captures as load_scene_captures,
)
from .scenes import (
    load_scene_names as load_scene_names,
)
from .scenes import (
    remove_scene as remove_scene,
)
from .scenes import (
    save_scene as save_scene,
)
