"""Where the public names stand: __init__.py imports a module when one is used."""

from .answers.catalogue import (
    listed_capture as listed_capture,
)
from .answers.catalogue import (
    shown_event as shown_event,
)
from .answers.database import (
    learned_summary as learned_summary,
)
from .answers.grammars import (
    GrammarAnswer as GrammarAnswer,
)
from .answers.making import (
    Source as Source,
)
from .answers.plain import (
    to_json as to_json,
)
from .answers.questions import (
    like_answer as like_answer,
)
from .answers.questions import (
    search_answer as search_answer,
)
from .answers.questions import (
    words_over_time as words_over_time,
)
from .answers.scenes import (
    scene_row as scene_row,
)
from .body.gait import (
    GaitCycle as GaitCycle,
)
from .body.gait import (
    GaitMeasure as GaitMeasure,
)
from .body.kinematics import (
    forward_kinematics as forward_kinematics,
)
from .database import (
    MotionDB as MotionDB,
)
from .database.captures import Captures as Captures
from .database.catalogue.cataloguing import (
    check_captures as check_captures,
)
from .database.catalogue.exporting import (
    MotionChanges as MotionChanges,
)
from .database.catalogue.file_reading import (
    AddSettings as AddSettings,
)
from .database.catalogue.file_reading import (
    read_joint_map as read_joint_map,
)
from .database.catalogue.parts import (
    check_motion_file as check_motion_file,
)
from .database.catalogue.rescuing import (
    rescue as rescue,
)
from .database.checking import (
    check_file as check_file,
)
from .database.cluster import (
    Cluster as Cluster,
)
from .database.curating import CurateSettings as CurateSettings
from .database.generated_files import (
    Joined as Joined,
)
from .database.generating import (
    ActionPlace as ActionPlace,
)
from .database.generating import (
    Generated as Generated,
)
from .database.grammars.grammar_facts import (
    ParsedMotion as ParsedMotion,
)
from .database.grammars.grammar_facts import (
    grammar_row as grammar_row,
)
from .database.grammars.grammar_learning import (
    GrammarSettings as GrammarSettings,
)
from .database.grammars.grammar_sequences import (
    Edit as Edit,
)
from .database.grammars.grammar_sequences import (
    GrammarSequence as GrammarSequence,
)
from .database.grammars.grammars import (
    Grammars as Grammars,
)
from .database.learn.start import (
    load_knowledge as load_knowledge,
)
from .database.learn.start import (
    shipped_starts as shipped_starts,
)
from .database.loading import LearnedGrammar as LearnedGrammar
from .database.opening import (
    changes_saved as changes_saved,
)
from .database.opening import check_merge as check_merge
from .database.opening import (
    compact as compact,
)
from .database.opening import (
    open as open,
)
from .database.questions import (
    Question as Question,
)
from .database.scenes.scene_making import (
    SceneSettings as SceneSettings,
)
from .database.scenes.scene_texts import (
    SceneText as SceneText,
)
from .database.scenes.scenes import (
    Scene as Scene,
)
from .database.scenes.scenes import (
    Scenes as Scenes,
)
from .database.selections import Selections as Selections
from .database.tables import (
    Tables as Tables,
)
from .database.words import Symbols as Symbols
from .database.words import Words as Words
from .errors import (
    CaptureError as CaptureError,
)
from .errors import (
    ClusterError as ClusterError,
)
from .errors import (
    HeldError as HeldError,
)
from .errors import (
    ImplausibleError as ImplausibleError,
)
from .errors import (
    KnowledgeError as KnowledgeError,
)
from .errors import (
    MotionDBError as MotionDBError,
)
from .errors import (
    NotLearnedError as NotLearnedError,
)
from .errors import (
    QueryError as QueryError,
)
from .errors import (
    SceneError as SceneError,
)
from .errors import (
    SheetError as SheetError,
)
from .errors import (
    SkeletonError as SkeletonError,
)
from .errors import (
    StoreError as StoreError,
)
from .errors import (
    UnknownWordsError as UnknownWordsError,
)
from .fetch import (
    CMU_TERMS as CMU_TERMS,
)
from .fetch import (
    CMU_URL as CMU_URL,
)
from .fetch import (
    FetchLimits as FetchLimits,
)
from .fetch import (
    FetchSettings as FetchSettings,
)
from .fetch import (
    fetch_cmu as fetch_cmu,
)
from .files.bvh_writer import (
    write_bvh as write_bvh,
)
from .files.formats import (
    read_capture as read_capture,
)
from .files.gltf_writer import (
    write_gltf as write_gltf,
)
from .files.limits import (
    ReadLimits as ReadLimits,
)
from .files.limits import (
    check_up as check_up,
)
from .files.own_files import (
    check_overwriting as check_overwriting,
)
from .files.own_files import (
    protect_others as protect_others,
)
from .files.rigs import (
    JointProposal as JointProposal,
)
from .files.rigs import (
    propose_joints as propose_joints,
)
from .files.safe_files import (
    read_user_text as read_user_text,
)
from .files.sheet_writer import (
    plain_cell as plain_cell,
)
from .files.sheet_writer import (
    write_table as write_table,
)
from .files.units import (
    unit_from_name as unit_from_name,
)
from .generate.shown_actions import (
    JudgedAction as JudgedAction,
)
from .grammar.cfg.context_free import (
    Tree as Tree,
)
from .grammar.derivation.plan import (
    Plan as Plan,
)
from .language.question.readings import (
    KnownQuestion as KnownQuestion,
)
from .language.question.tree import (
    NotUsed as NotUsed,
)
from .learn.drift import (
    Drift as Drift,
)
from .learn.knowledge import (
    Knowledge as Knowledge,
)
from .learn.recognition import (
    LearnSettings as LearnSettings,
)
from .page.serve import (
    serve as serve,
)
from .page.settings import (
    PageSettings as PageSettings,
)
from .page.standalone import (
    StandalonePage as StandalonePage,
)
from .records import (
    Caption as Caption,
)
from .records import (
    CaptureInfo as CaptureInfo,
)
from .records import (
    Clip as Clip,
)
from .records import (
    Event as Event,
)
from .records import (
    Match as Match,
)
from .records import (
    Motion as Motion,
)
from .records import (
    MotionSymbols as MotionSymbols,
)
from .records import (
    Relation as Relation,
)
from .scene.clips.caption_actions import (
    ShownAction as ShownAction,
)
from .scene.language.motion_grammar import (
    MotionGrammar as MotionGrammar,
)
from .scene.services.services import (
    GrammarReport as GrammarReport,
)
from .scene.services.services import (
    Suggestions as Suggestions,
)
from .scene.services.services import (
    Validation as Validation,
)
from .search.asked_words import (
    WrittenWord as WrittenWord,
)
from .search.by_example import (
    ExampleAnswer as ExampleAnswer,
)
from .search.by_words import (
    WordAnswer as WordAnswer,
)
from .search.chances import (
    WordSource as WordSource,
)
from .search.reasons import (
    ExplainedWord as ExplainedWord,
)
from .search.reasons import (
    Explanation as Explanation,
)
from .search.takings import (
    Taking as Taking,
)
from .store import (
    GrammarSize as GrammarSize,
)
from .store import (
    StoredScene as StoredScene,
)

__version__: str
