"""Two dances, and settings to learn a grammar of them quickly."""

from __future__ import annotations

from motiondb.database.grammars.grammar_learning import GrammarSettings
from motiondb.grammar.terminals.terminals import TerminalSettings

TAKES = ("ana/long_dance_2", "dora/long_dance_1")
QUICK = TerminalSettings(n_starts=1, n_trials=150)
SETTINGS = GrammarSettings(n_terminals=8, seed=1, search=QUICK, evaluations=300)
