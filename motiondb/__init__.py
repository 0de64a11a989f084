"""motiondb: a motion-capture database that understands what is in it.

Open a database with :func:`open`; everything that the commands do is a method of the
:class:`MotionDB` that it gives, or a function here if it needs no open database. The commands
use nothing but these names.

>>> import motiondb
>>> [name for name in dir(motiondb) if name.startswith("write")]
['write_bvh', 'write_gltf', 'write_table']
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from motiondb.answers.catalogue import listed_capture, shown_event
    from motiondb.answers.database import Compacted
    from motiondb.answers.grammars import GrammarAnswer
    from motiondb.answers.learning import learned_summary
    from motiondb.answers.making import Source
    from motiondb.answers.plain import to_json
    from motiondb.answers.questions import like_answer, search_answer, words_over_time
    from motiondb.answers.scenes import scene_row
    from motiondb.body.kinematics import forward_kinematics
    from motiondb.database import MotionDB
    from motiondb.database.catalogue.cataloguing import Progress, check_captures
    from motiondb.database.catalogue.exporting import MotionChanges
    from motiondb.database.catalogue.file_reading import AddSettings, read_joint_map
    from motiondb.database.catalogue.parts import check_motion_file
    from motiondb.database.catalogue.rescuing import rescue
    from motiondb.database.check_process import check_file
    from motiondb.database.cluster import Cluster
    from motiondb.database.generating import ActionPlace, Generated
    from motiondb.database.grammars.grammar_facts import grammar_row
    from motiondb.database.grammars.grammar_learning import GrammarSettings
    from motiondb.database.grammars.grammar_parsing import ParsedMotion
    from motiondb.database.grammars.grammar_sequences import Edit, GrammarSequence
    from motiondb.database.grammars.grammars import Grammars
    from motiondb.database.joining import Joined
    from motiondb.database.learn.start import load_knowledge, shipped_starts
    from motiondb.database.learned_grammar import LearnedGrammar
    from motiondb.database.questions import Question
    from motiondb.database.scenes.scene_making import SceneSettings
    from motiondb.database.scenes.scene_texts import SceneText
    from motiondb.database.scenes.scenes import Scene, Scenes
    from motiondb.database.tables import Tables
    from motiondb.errors import (
        CaptureError,
        ClusterError,
        HeldError,
        ImplausibleError,
        KnowledgeError,
        MotionDBError,
        NotLearnedError,
        QueryError,
        SceneError,
        SheetError,
        SkeletonError,
        StoreError,
        UnknownWordsError,
    )
    from motiondb.fetch import CMU_TERMS, CMU_URL, FetchLimits, FetchSettings, fetch_cmu
    from motiondb.files.formats import read_capture
    from motiondb.files.limits import ReadLimits, check_up
    from motiondb.files.own_files import check_overwriting, protect_others
    from motiondb.files.rigs import JointProposal, propose_joints
    from motiondb.files.safe_files import read_user_text
    from motiondb.files.sheet_writer import plain_cell, write_table
    from motiondb.files.units import unit_from_name
    from motiondb.generate.shown_actions import JudgedAction
    from motiondb.grammar.cfg.context_free import Tree
    from motiondb.grammar.derivation.plan import Plan
    from motiondb.language.question.readings import KnownQuestion
    from motiondb.language.question.tree import NotUsed
    from motiondb.learn.drift import Drift
    from motiondb.learn.knowledge import Knowledge
    from motiondb.learn.recognition import LearnSettings
    from motiondb.page.serve import serve
    from motiondb.page.settings import PageSettings
    from motiondb.page.standalone import StandalonePage
    from motiondb.records import (
        Caption,
        CaptureInfo,
        Clip,
        Event,
        Match,
        Motion,
        MotionSymbols,
        Relation,
    )
    from motiondb.scene.clips.caption_actions import ShownAction
    from motiondb.scene.language.motion_grammar import MotionGrammar
    from motiondb.scene.services.services import GrammarReport, Suggestions, Validation
    from motiondb.search.asked_words import WrittenWord
    from motiondb.search.by_example import ExampleAnswer
    from motiondb.search.by_words import WordAnswer
    from motiondb.search.chances import WordSource
    from motiondb.search.reasons import ExplainedWord, Explanation
    from motiondb.search.takings import Taking
    from motiondb.store import GrammarSize, StoredScene

__all__ = [
    "CMU_TERMS",
    "CMU_URL",
    "ActionPlace",
    "AddSettings",
    "Caption",
    "CaptureError",
    "CaptureInfo",
    "Clip",
    "Cluster",
    "ClusterError",
    "Drift",
    "Edit",
    "Event",
    "ExampleAnswer",
    "ExplainedWord",
    "Explanation",
    "FetchLimits",
    "FetchSettings",
    "Generated",
    "GrammarAnswer",
    "GrammarReport",
    "GrammarSequence",
    "GrammarSettings",
    "GrammarSize",
    "Grammars",
    "HeldError",
    "ImplausibleError",
    "Joined",
    "JointProposal",
    "JudgedAction",
    "Knowledge",
    "KnowledgeError",
    "KnownQuestion",
    "LearnSettings",
    "LearnedGrammar",
    "Match",
    "Motion",
    "MotionChanges",
    "MotionDB",
    "MotionDBError",
    "MotionGrammar",
    "MotionSymbols",
    "NotLearnedError",
    "NotUsed",
    "PageSettings",
    "ParsedMotion",
    "Plan",
    "QueryError",
    "Question",
    "ReadLimits",
    "Relation",
    "Scene",
    "SceneError",
    "SceneSettings",
    "SceneText",
    "Scenes",
    "SheetError",
    "ShownAction",
    "SkeletonError",
    "Source",
    "StandalonePage",
    "StoreError",
    "StoredScene",
    "Suggestions",
    "Tables",
    "Taking",
    "Tree",
    "UnknownWordsError",
    "Validation",
    "WordAnswer",
    "WordSource",
    "WrittenWord",
    "__version__",
    "changes_saved",
    "check_captures",
    "check_file",
    "check_motion_file",
    "check_overwriting",
    "check_up",
    "compact",
    "fetch_cmu",
    "forward_kinematics",
    "grammar_row",
    "learned_summary",
    "like_answer",
    "listed_capture",
    "load_knowledge",
    "open",
    "plain_cell",
    "propose_joints",
    "protect_others",
    "read_capture",
    "read_joint_map",
    "read_user_text",
    "rescue",
    "scene_row",
    "search_answer",
    "serve",
    "shipped_starts",
    "shown_event",
    "to_json",
    "unit_from_name",
    "words_over_time",
    "write_bvh",
    "write_gltf",
    "write_table",
]
__version__ = "0.1.0"

_PLACES = {
    "motiondb.answers.questions": "like_answer search_answer words_over_time",
    "motiondb.answers.catalogue": "listed_capture shown_event",
    "motiondb.answers.grammars": "GrammarAnswer",
    "motiondb.answers.learning": "learned_summary",
    "motiondb.answers.making": "Source",
    "motiondb.answers.plain": "to_json",
    "motiondb.answers.scenes": "scene_row",
    "motiondb.body.kinematics": "forward_kinematics",
    "motiondb.database.tables": "Tables",
    "motiondb.database.grammars.grammar_facts": "grammar_row",
    "motiondb.files.formats": "read_capture",
    "motiondb.files.limits": "ReadLimits check_up",
    "motiondb.files.units": "unit_from_name",
    "motiondb.files.rigs": "JointProposal propose_joints",
    "motiondb.files.safe_files": "read_user_text",
    "motiondb.files.sheet_writer": "plain_cell write_table",
    "motiondb.files.own_files": "check_overwriting protect_others",
    "motiondb.database": "MotionDB",
    "motiondb.database.questions": "Question",
    "motiondb.database.catalogue.cataloguing": "check_captures",
    "motiondb.database.check_process": "check_file",
    "motiondb.database.cluster": "Cluster",
    "motiondb.database.learned_grammar": "LearnedGrammar",
    "motiondb.database.catalogue.exporting": "MotionChanges",
    "motiondb.database.catalogue.parts": "check_motion_file",
    "motiondb.database.catalogue.file_reading": "AddSettings read_joint_map",
    "motiondb.database.catalogue.rescuing": "rescue",
    "motiondb.database.grammars.grammar_learning": "GrammarSettings",
    "motiondb.database.grammars.grammar_parsing": "ParsedMotion",
    "motiondb.database.grammars.grammar_sequences": "Edit GrammarSequence",
    "motiondb.database.grammars.grammars": "Grammars",
    "motiondb.database.learn.start": "load_knowledge shipped_starts",
    "motiondb.database.generating": "ActionPlace Generated",
    "motiondb.database.joining": "Joined",
    "motiondb.database.scenes.scene_making": "SceneSettings",
    "motiondb.database.scenes.scene_texts": "SceneText",
    "motiondb.database.scenes.scenes": "Scene Scenes",
    "motiondb.errors": "CaptureError ClusterError HeldError ImplausibleError KnowledgeError "
    "MotionDBError NotLearnedError QueryError SceneError SheetError SkeletonError StoreError "
    "UnknownWordsError",
    "motiondb.fetch": "CMU_TERMS CMU_URL FetchLimits FetchSettings fetch_cmu",
    "motiondb.grammar.cfg.context_free": "Tree",
    "motiondb.grammar.derivation.plan": "Plan",
    "motiondb.search.by_example": "ExampleAnswer",
    "motiondb.search.reasons": "ExplainedWord Explanation",
    "motiondb.search.by_words": "WordAnswer",
    "motiondb.search.chances": "WordSource",
    "motiondb.learn.drift": "Drift",
    "motiondb.generate.shown_actions": "JudgedAction",
    "motiondb.learn.knowledge": "Knowledge",
    "motiondb.learn.recognition": "LearnSettings",
    "motiondb.page.serve": "serve",
    "motiondb.page.settings": "PageSettings",
    "motiondb.page.standalone": "StandalonePage",
    "motiondb.search.asked_words": "WrittenWord",
    "motiondb.search.takings": "Taking",
    "motiondb.records": "Caption CaptureInfo Clip Event Match Motion MotionSymbols Relation",
    "motiondb.scene.clips.caption_actions": "ShownAction",
    "motiondb.scene.language.motion_grammar": "MotionGrammar",
    "motiondb.scene.services.services": "GrammarReport Suggestions Validation",
    "motiondb.store": "GrammarSize StoredScene",
    "motiondb.language.question.readings": "KnownQuestion",
    "motiondb.language.question.tree": "NotUsed",
}  # The public names of each module, separated by spaces
_PUBLIC = {name: module for module, names in _PLACES.items() for name in names.split()}


def open(
    path: str | Path = "motions.duckdb", *, read_only: bool = False, wait: float = 0.0
) -> MotionDB:
    """Open a motion database, or make a new one.

    Parameters
    ----------
    path : str or Path
        The DuckDB file.
    read_only : bool
        Whether only to ask; several processes may do so at once.
    wait : float
        Seconds to wait for another process that holds the file.

    Raises
    ------
    MotionDBError
        When another process holds the file, or it is not a database of motiondb, or was written by
        a newer motiondb.
    """
    from motiondb.database import MotionDB

    return MotionDB(path, read_only=read_only, wait=wait)


def compact(
    path: str | Path,
    wait: float = 0.0,
    motions_to: str | None = None,
    progress: Progress | None = None,
) -> Compacted:
    """Rewrite a database file without the space that removed rows left.

    Parameters
    ----------
    path : str or Path
        The DuckDB file; no process may have it open.
    wait : float
        Seconds to wait for another process that holds the file.
    motions_to : str, optional
        Where motions, original files and scores of segments are to lie: a folder, or a URL that
        fsspec knows, such as "s3://bucket/motions"; "here": in the database file. None leaves them
        where they are.
    progress : callable, optional
        Called with the name of the step, the number done, and the total number.

    Returns
    -------
    Compacted
        Size in bytes before and after, and what was moved.

    Raises
    ------
    MotionDBError
        When another process holds the file, it is not a database of motiondb, or the place cannot
        be written. What was moved until then stays moved; the others are as they were.
    """
    from motiondb import store
    from motiondb.answers import Compacted

    return Compacted(
        **vars(store.compact(Path(path), wait=wait, motions_to=motions_to, progress=progress))
    )


def changes_saved() -> bool:
    """Whether this process has saved a change to a database, for messages after an interrupt."""
    handle = sys.modules.get("motiondb.store.connection.handle")  # absent: nothing was opened
    return handle is not None and bool(handle.Store.changes_saved)


def write_bvh(motion: Clip | Motion, path: str | Path) -> None:
    """Write a clip or a motion as BVH; the file appears whole or not at all.

    Parameters
    ----------
    motion : Clip or Motion
        A motion is written on the canonical body in the performer's size, 30 frames a second.
    path : str or Path
        The file.

    Raises
    ------
    MotionDBError
        When it is neither, has no frames or numbers that are not finite, or the file cannot be
        written.
    """
    from motiondb.files import bvh_writer

    bvh_writer.write_bvh(_to_clip(motion), path)


def write_gltf(motion: Clip | Motion, path: str | Path) -> None:
    """Write a clip or a motion as glTF (.glb or .gltf); see :func:`write_bvh`.

    Parameters
    ----------
    motion : Clip or Motion
        As in :func:`write_bvh`.
    path : str or Path
        The file.
    """
    from motiondb.files import gltf_writer

    gltf_writer.write_gltf(_to_clip(motion), path)


def _to_clip(motion: Clip | Motion) -> Clip:
    from motiondb.body import retarget
    from motiondb.records import Motion

    return retarget.to_clip(motion) if isinstance(motion, Motion) else motion


def __getattr__(name: str) -> object:
    """Import a public name when it is first used, so that the command line starts fast."""
    if name not in _PUBLIC:
        raise AttributeError(f"module 'motiondb' has no attribute {name!r}")
    from importlib import import_module

    public = getattr(import_module(_PUBLIC[name]), name)
    globals()[name] = public
    return public


def __dir__() -> list[str]:
    """The public names, and those that every module has."""
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})
