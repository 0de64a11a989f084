"""Former names of verbs of MotionDB, and where they are now; kept for a while."""

from collections.abc import Mapping
from types import MappingProxyType

_SAME_NAME: Mapping[str, str] = MappingProxyType(
    {
        "captures": "activities all_events animate browse browsed check_name_free draw "
        "draw_matches draw_reasons duplicates event_rows events export_matches facets "
        "faulty_files features import_events provenance relations remove rename same_files "
        "save_generated segments set_tags show tag_rows taken_in_filter unlearned",
        "words": "all_captions captions set_captions set_synonyms vocabulary why_unchecked",
        "symbols": "drift export_knowledge start_facts start_knowledge",
    }
)
FORMER: Mapping[str, str] = MappingProxyType(
    {name: f"{space}.{name}" for space, names in _SAME_NAME.items() for name in names.split()}
    | {"set_words": "words.set", "add_words": "words.add", "caption_history": "words.history"}
    | {"export_words": "words.export", "import_words": "words.import_sheet"}
    | {"word_rows": "words.rows", "word_sources": "words.sources"}
    | {"symbol_rows": "symbols.rows", "symbol_segments": "symbols.segments"}
    | {"draw_symbols": "symbols.draw", "damage_note": "session.damage_note"}
    | {"log_note": "session.store.log_note", "file_notes": "session.store.notes"}
)
"""Name -> attribute of :class:`MotionDB` that it stands for."""
