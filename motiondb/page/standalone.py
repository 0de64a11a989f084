"""One HTML file with the page, an answer and its motions, which can be sent to others.

The file needs no server and loads nothing: it contains the script and the style, and its content
security policy allows only these two, by their hashes. The answer has the form that the route of
the same name gives. Motions are containers (:mod:`motiondb.page.motion`) in base64, by
ref.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from motiondb.answers.plain import to_json
from motiondb.body.features import FEATURE_STEP
from motiondb.database import MotionDB
from motiondb.database.generating import Generated
from motiondb.database.grammars.grammar_sequences import GrammarSequence
from motiondb.errors import MotionDBError
from motiondb.files.own_files import SEAL, sealed
from motiondb.files.safe_files import write_bytes
from motiondb.page import replies
from motiondb.page.motion import body_track, pack, pack_scene
from motiondb.page.settings import BUNDLE, NO_BUNDLE, VERSION, is_built
from motiondb.records import MOTION_FPS, Match, Motion
from motiondb.search.by_example import ExampleAnswer
from motiondb.search.by_words import WordAnswer

if TYPE_CHECKING:
    from motiondb.database.scenes.scenes import Scene

STYLE, SCRIPT = (
    '<link rel="stylesheet" href="app.css">',
    '<script type="module" src="app.js"></script>',
)
"""Elements that the page's ``index.html`` contains exactly once."""
GENERATOR = f'<meta name="generator" content="{SEAL}">'
MARGIN = 1.0  # Seconds that are shown before and after a match
EXAMPLE = "example"  # Key of the motion of an example that is no stored capture


@dataclass(frozen=True, eq=False)
class StandalonePage:
    """The contents of the file."""

    kind: str
    """"search", "like", "generate", "capture", "sequence" or "scene"."""
    title: str
    """Title of the page."""
    database: str
    """Name of the database file."""
    answer: object
    """The reply that the route of this kind gives."""
    motions: Mapping[str, bytes]
    """Containers by ref."""

    def write(self, path: str | Path) -> Path:
        """Write the file, whole or not at all.

        Raises
        ------
        MotionDBError
            The page was not built, or the file cannot be written.
        """
        self.check()
        data = sealed(standalone_page(self).encode("utf-8", "replace"))
        return write_bytes(Path(path), data)

    @staticmethod
    def check() -> None:
        """Check that the page was built, before anything is computed.

        Raises
        ------
        MotionDBError
            The page was not built.
        """
        if not is_built(BUNDLE):
            raise MotionDBError(f"--html: expected the files of the page, found none. {NO_BUNDLE}")

    @staticmethod
    def of_search(db: MotionDB, answer: WordAnswer) -> StandalonePage:
        """Return the page of an answer to words."""
        motions = _matched(db, answer.matches)
        reply = replies.search_reply(db, answer)
        return StandalonePage("search", answer.question.text, _name(db), reply, motions)

    @staticmethod
    def of_like(
        db: MotionDB,
        answer: ExampleAnswer,
        example: str,
        start: float | None = None,
        end: float | None = None,
        motion: Motion | None = None,
    ) -> StandalonePage:
        """Return the page of an answer to an example: a file or a capture, or a part of it.

        `motion`: the example, where it was read already.
        """
        part = db.motion(example if motion is None else motion, start, end)
        shown = _packed(example, EXAMPLE, part, start or 0.0)
        motions = {**_matched(db, answer.matches), EXAMPLE: shown}
        reply = replies.like_reply(db, answer, EXAMPLE, start, end)
        return StandalonePage("like", f"like {example}", _name(db), reply, motions)

    @staticmethod
    def of_generated(db: MotionDB, made: Generated, saved: str = "") -> StandalonePage:
        """Return the page of a generated motion; ``saved`` is the capture that holds it."""
        variant = replies.made_reply(db, made, "file", saved)
        motions = {variant.ref: _packed(made.words, variant.ref, made.motion)}
        reply = replies.generate_reply(made, [variant])
        return StandalonePage("generate", made.words, _name(db), reply, motions)

    @staticmethod
    def of_capture(db: MotionDB, name: str) -> StandalonePage:
        """Return the page of a stored capture.

        Raises
        ------
        QueryError
            No capture has this name.
        """
        motion, full = db.motion(name), db.captures.show(name).capture
        row = db.captures.browsed(full)
        assert row is not None
        ref = f"capture:{full}"
        motions = {ref: _packed(full, ref, motion)}
        return StandalonePage("capture", full, _name(db), replies.capture_details(db, row), motions)

    @staticmethod
    def of_sequence(db: MotionDB, sequence: GrammarSequence, seed: int = 0) -> StandalonePage:
        """Return the page of a sequence of a grammar."""
        reply = replies.sequence_reply(db, sequence, seed, "file")
        motions = {reply.ref: _packed(sequence.grammar, reply.ref, sequence.motion)}
        return StandalonePage("sequence", sequence.grammar, _name(db), reply, motions)

    @staticmethod
    def of_scene(scene: Scene, database: str = "") -> StandalonePage:
        """Return the page of a made scene; ``database`` names the file it was made from."""
        ref, trace = "scene:file", scene.made.trace.best
        curve = [(n / max(len(trace) - 1, 1), float(error)) for n, error in enumerate(trace)]
        motions = {ref: pack_scene(scene.made.polished, scene.made.text.diagram, ref)}
        reply = replies.made_scene_reply(ref, scene, curve)
        return StandalonePage("scene", scene.record.name, database, reply, motions)


def standalone_page(shown: StandalonePage) -> str:
    """Return the text of the file."""
    index, script, style = (
        (BUNDLE / name).read_text(encoding="utf-8").replace("\r\n", "\n")
        for name in ("index.html", "file.js", "app.css")
    )
    if index.count(STYLE) != 1 or index.count(SCRIPT) != 1 or "</body>" not in index:
        raise MotionDBError(
            f"{BUNDLE / 'index.html'}: expected one style and one script, found others. Build the"
            " page again: python build_backend.py."
        )
    script = script.replace("</script", "<\\/script").replace("<!--", "<\\!--")
    policy = (
        f"default-src 'none'; script-src {_hash(script)}; style-src {_hash(style)};"
        " img-src data: blob:; base-uri 'none'; form-action 'none'"
    )
    meta = f'<meta http-equiv="Content-Security-Policy" content="{html.escape(policy)}">'
    data = f'<script type="application/json" id="motiondb-data">{_data(shown)}</script>'
    body, end = index.replace(SCRIPT, "").rsplit("</body>", 1)
    page = body.replace(STYLE, f"{meta}\n<style>{style}</style>")
    page = page.replace("<head>", f"<head>\n    {GENERATOR}", 1)
    return f"{page}{data}\n<script>{script}</script>\n</body>{end}"


def _hash(text: str) -> str:
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode()}'"


def _data(shown: StandalonePage) -> str:
    facts = {
        "format": 1,
        "kind": shown.kind,
        "title": shown.title,
        "version": VERSION,
        "database": shown.database,
        "answer": to_json(shown.answer),
        "motions": {ref: base64.b64encode(data).decode() for ref, data in shown.motions.items()},
    }
    return json.dumps(facts, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")


def _name(db: MotionDB) -> str:
    return db.store.path.name


def _matched(db: MotionDB, matches: Iterable[Match]) -> dict[str, bytes]:
    """Return the motion of each matched capture, from before its first match to after its last."""
    spans: dict[str, tuple[float, float]] = {}
    for match in matches:
        low, high = spans.get(match.capture, (match.start, match.end))
        spans[match.capture] = (min(low, match.start), max(high, match.end))
    motions = {}
    for name, (low, high) in spans.items():
        row = db.captures.browsed(name)
        assert row is not None
        start, end = max(low - MARGIN, 0.0), high + MARGIN
        whole_end = None if end >= row.info.motion_frames / MOTION_FPS else end
        first = round(start * MOTION_FPS / FEATURE_STEP) * FEATURE_STEP / MOTION_FPS
        ref = f"capture:{name}"
        motions[ref] = _packed(name, ref, db.motion(name, start, whole_end), first)
    return motions


def _packed(name: str, ref: str, motion: Motion, start: float = 0.0) -> bytes:
    return pack([body_track(name, ref, motion, start)])
