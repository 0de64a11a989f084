"""Where the answers stand: __init__.py imports a module when one is used."""

from .catalogue import (
    CaptionVersion as CaptionVersion,
)
from .catalogue import (
    CaptureFacts as CaptureFacts,
)
from .catalogue import (
    CaptureQuality as CaptureQuality,
)
from .catalogue import (
    DataSet as DataSet,
)
from .catalogue import (
    Duplicates as Duplicates,
)
from .catalogue import (
    EventRow as EventRow,
)
from .catalogue import (
    Exported as Exported,
)
from .catalogue import (
    FaultyFile as FaultyFile,
)
from .catalogue import (
    GaitReport as GaitReport,
)
from .catalogue import (
    Ghost as Ghost,
)
from .catalogue import (
    ListedCapture as ListedCapture,
)
from .catalogue import (
    MatchFile as MatchFile,
)
from .catalogue import (
    PackWritten as PackWritten,
)
from .catalogue import (
    PerformerRate as PerformerRate,
)
from .catalogue import (
    QualityAnswer as QualityAnswer,
)
from .catalogue import (
    SameFile as SameFile,
)
from .catalogue import (
    SelectedPart as SelectedPart,
)
from .catalogue import (
    SelectionChanged as SelectionChanged,
)
from .catalogue import (
    SelectionRow as SelectionRow,
)
from .catalogue import (
    SheetWritten as SheetWritten,
)
from .catalogue import (
    ShownActivity as ShownActivity,
)
from .catalogue import (
    ShownEvent as ShownEvent,
)
from .catalogue import (
    ShownSegment as ShownSegment,
)
from .catalogue import (
    SymbolSegment as SymbolSegment,
)
from .catalogue import (
    TagRow as TagRow,
)
from .catalogue import (
    capture_quality as capture_quality,
)
from .catalogue import (
    listed_capture as listed_capture,
)
from .catalogue import (
    shown_event as shown_event,
)
from .database import (
    AddReport as AddReport,
)
from .database import (
    AddResult as AddResult,
)
from .database import (
    BackedUp as BackedUp,
)
from .database import (
    CaptionsSet as CaptionsSet,
)
from .database import (
    Cell as Cell,
)
from .database import (
    ChosenInterval as ChosenInterval,
)
from .database import (
    CoverageAnswer as CoverageAnswer,
)
from .database import (
    CurateAnswer as CurateAnswer,
)
from .database import (
    DatabaseInfo as DatabaseInfo,
)
from .database import (
    DiffAnswer as DiffAnswer,
)
from .database import (
    DroppedInterval as DroppedInterval,
)
from .database import (
    Evaluation as Evaluation,
)
from .database import (
    Faults as Faults,
)
from .database import (
    KnowledgeAnswer as KnowledgeAnswer,
)
from .database import (
    LearnedSummary as LearnedSummary,
)
from .database import (
    LearnResult as LearnResult,
)
from .database import (
    MergeReport as MergeReport,
)
from .database import (
    Moment as Moment,
)
from .database import (
    Removed as Removed,
)
from .database import (
    Renamed as Renamed,
)
from .database import (
    Score as Score,
)
from .database import (
    SharedCapture as SharedCapture,
)
from .database import (
    SplitChoice as SplitChoice,
)
from .database import (
    StartAnswer as StartAnswer,
)
from .database import (
    SymbolProbability as SymbolProbability,
)
from .database import (
    SymbolRow as SymbolRow,
)
from .database import (
    TagsSet as TagsSet,
)
from .database import (
    Undone as Undone,
)
from .database import (
    WordProbability as WordProbability,
)
from .database import (
    WordRow as WordRow,
)
from .database import (
    WordScore as WordScore,
)
from .database import (
    knowledge_answer as knowledge_answer,
)
from .database import (
    learned_summary as learned_summary,
)
from .grammars import (
    Alternative as Alternative,
)
from .grammars import (
    AlternativesAnswer as AlternativesAnswer,
)
from .grammars import (
    CompletedSentence as CompletedSentence,
)
from .grammars import (
    CompletionsAnswer as CompletionsAnswer,
)
from .grammars import (
    DoubtfulSentence as DoubtfulSentence,
)
from .grammars import (
    Foresight as Foresight,
)
from .grammars import (
    GrammarAnswer as GrammarAnswer,
)
from .grammars import (
    GrammarAsked as GrammarAsked,
)
from .grammars import (
    GrammarEdited as GrammarEdited,
)
from .grammars import (
    GrammarLearned as GrammarLearned,
)
from .grammars import (
    GrammarQuestion as GrammarQuestion,
)
from .grammars import (
    GrammarRow as GrammarRow,
)
from .grammars import (
    GrammarRules as GrammarRules,
)
from .grammars import (
    LearnedTake as LearnedTake,
)
from .grammars import (
    Medoid as Medoid,
)
from .grammars import (
    NextTerminal as NextTerminal,
)
from .grammars import (
    OfferedEdits as OfferedEdits,
)
from .grammars import (
    ParseAnswer as ParseAnswer,
)
from .grammars import (
    ParsedSentence as ParsedSentence,
)
from .grammars import (
    ParseFault as ParseFault,
)
from .grammars import (
    SequenceAnswer as SequenceAnswer,
)
from .grammars import (
    TerminalRow as TerminalRow,
)
from .grammars import (
    TerminalSpan as TerminalSpan,
)
from .grammars import (
    TerminalSymbol as TerminalSymbol,
)
from .grammars import (
    Unplayable as Unplayable,
)
from .grammars import (
    WayAnswer as WayAnswer,
)
from .grammars import (
    WrittenSequence as WrittenSequence,
)
from .making import (
    ActionVerdict as ActionVerdict,
)
from .making import (
    DecodedAction as DecodedAction,
)
from .making import (
    GeneratedAnswer as GeneratedAnswer,
)
from .making import (
    JoinedAnswer as JoinedAnswer,
)
from .making import (
    JoinedPart as JoinedPart,
)
from .making import (
    Judgement as Judgement,
)
from .making import (
    Source as Source,
)
from .making import (
    Variants as Variants,
)
from .making import (
    WrittenJoin as WrittenJoin,
)
from .making import (
    WrittenMotion as WrittenMotion,
)
from .plain import (
    OPTIONAL as OPTIONAL,
)
from .plain import (
    SPREAD as SPREAD,
)
from .plain import (
    Answer as Answer,
)
from .plain import (
    extended as extended,
)
from .plain import (
    to_json as to_json,
)
from .questions import (
    ActionTree as ActionTree,
)
from .questions import (
    AnythingTree as AnythingTree,
)
from .questions import (
    Comparison as Comparison,
)
from .questions import (
    DescribedWord as DescribedWord,
)
from .questions import (
    ExplainedMatch as ExplainedMatch,
)
from .questions import (
    JoinedTree as JoinedTree,
)
from .questions import (
    JointDistance as JointDistance,
)
from .questions import (
    LastingTree as LastingTree,
)
from .questions import (
    LikeAnswer as LikeAnswer,
)
from .questions import (
    QuestionTree as QuestionTree,
)
from .questions import (
    RepeatedTree as RepeatedTree,
)
from .questions import (
    SearchAnswer as SearchAnswer,
)
from .questions import (
    SideOfAction as SideOfAction,
)
from .questions import (
    UnderstoodQuestion as UnderstoodQuestion,
)
from .questions import (
    WithoutTree as WithoutTree,
)
from .questions import (
    WordsOfQuestion as WordsOfQuestion,
)
from .questions import (
    WordsOverTime as WordsOverTime,
)
from .questions import (
    WrittenAnswer as WrittenAnswer,
)
from .questions import (
    known_words as known_words,
)
from .questions import (
    like_answer as like_answer,
)
from .questions import (
    question_tree as question_tree,
)
from .questions import (
    search_answer as search_answer,
)
from .questions import (
    understood_question as understood_question,
)
from .questions import (
    words_over_time as words_over_time,
)
from .scenes import (
    ActionString as ActionString,
)
from .scenes import (
    CheckedGrammar as CheckedGrammar,
)
from .scenes import (
    DiagramPlayer as DiagramPlayer,
)
from .scenes import (
    DrawnDiagram as DrawnDiagram,
)
from .scenes import (
    MeasuredRule as MeasuredRule,
)
from .scenes import (
    NextAction as NextAction,
)
from .scenes import (
    NextActions as NextActions,
)
from .scenes import (
    SceneAnswer as SceneAnswer,
)
from .scenes import (
    SceneDetails as SceneDetails,
)
from .scenes import (
    SceneMade as SceneMade,
)
from .scenes import (
    SceneRow as SceneRow,
)
from .scenes import (
    StartSymbol as StartSymbol,
)
from .scenes import (
    ValidatedActions as ValidatedActions,
)
from .scenes import (
    scene_row as scene_row,
)
