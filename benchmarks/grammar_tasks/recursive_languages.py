"""Languages that repeat and nest, for the tasks ``recursive`` and ``development``."""

from __future__ import annotations

LANGUAGES = {
    "repetition": "S -> stand A rest\nA -> left right A [0.6] | left right [0.4]",
    "separated list": "S -> walk L sit\nL -> I then L [0.6] | I [0.4]\nI -> wave | clap | bow",
    "brackets": "S -> l Q r S [0.45] | l Q r [0.55]\nQ -> S [0.4] | empty [0.6]",
    "two brackets": "S -> P S [0.4] | P [0.6]\nP -> l Q r | k Q t\nQ -> S [0.45] | empty [0.55]",
    "a^n b^n": "S -> a S b [0.65] | a b [0.35]",
    "mirror": "S -> a S a [0.35] | b S b [0.3] | m [0.35]",
    "arithmetic": (
        "E -> E plus T [0.4] | T [0.6]\nT -> T times F [0.35] | F [0.65]\n"
        "F -> l E r [0.28] | x [0.4] | y [0.32]"
    ),
    "nested play": "S -> start P shoot\nP -> dribble P [0.3] | pass P return [0.3] | fake [0.4]",
    "loop in a loop": (
        "S -> walk P shoot\nP -> D E P | D E\nD -> dribble D | dribble\nE -> pass | fake"
    ),
    "one to three times": "S -> stand A rest\nA -> l r | l r l r | l r l r l r",
}
"""Languages of the table, with which today's learner is compared with others."""

DEVELOPMENT = {
    "two loops": "S -> start A mid B end\nA -> a A [0.6] | a [0.4]\nB -> b B [0.6] | b [0.4]",
    "two loops, no marks": "S -> A B\nA -> l r A [0.6] | l r [0.4]\nB -> k B [0.6] | k [0.4]",
    "choices": "S -> go L stop\nL -> I L [0.6] | I [0.4]\nI -> x | y z | w",
    "counted middle": "S -> a S b [0.6] | M [0.4]\nM -> c M [0.5] | c [0.5]",
    "list of lists": (
        "S -> open L close\nL -> I comma L [0.45] | I [0.55]\n"
        "I -> x [0.4] | y [0.3] | open L close [0.3]"
    ),
    "phrases": (
        "S -> N V\nN -> the man [0.35] | the dog [0.35] | the man that V [0.3]\n"
        "V -> runs [0.4] | sees N [0.6]"
    ),
    "zero or more": "S -> up A down\nA -> step A [0.6] | empty [0.4]",
    "loop of loops": "S -> X S [0.5] | X [0.5]\nX -> a B c\nB -> b B [0.55] | b [0.45]",
    "two nests": "S -> A B\nA -> a A b [0.55] | a b [0.45]\nB -> c B d [0.55] | c d [0.45]",
    "even palindromes": "S -> a S a [0.3] | b S b [0.3] | a a [0.2] | b b [0.2]",
    "one of two loops": (
        "S -> in A out | in B out\nA -> x A [0.6] | x [0.4]\nB -> y z B [0.6] | y z [0.4]"
    ),
    "combinations": (
        "S -> guard R guard\nR -> jab C R [0.55] | jab C [0.45]\n"
        "C -> cross [0.4] | hook [0.3] | empty [0.3]"
    ),
    "steps and turns": ("S -> walk W stop\nW -> step W [0.35] | step turn W [0.3] | step [0.35]"),
    "answers": (
        "S -> A dot\nA -> ask R A [0.4] | ask R [0.6]\nR -> yes [0.4] | no [0.3] | since A [0.3]"
    ),
    "two kinds of nest": "S -> l S r [0.3] | k S t [0.3] | x [0.2] | y [0.2]",
    "any, then one": "S -> up W down\nW -> a W [0.35] | b W [0.35] | c [0.3]",
    "program": "S -> begin B finish\nB -> do B [0.35] | if B fi B [0.25] | empty [0.4]",
    "a^n b^m c^n": "S -> a S c [0.55] | a B c [0.45]\nB -> b B [0.5] | b [0.5]",
    "alternation": "S -> a T [0.7] | a [0.3]\nT -> b S [0.7] | b [0.3]",
    "pairs": "S -> P S [0.6] | P [0.4]\nP -> x x | y y | z z",
    "long unit": (
        "S -> run A shoot | run A out\n"
        "A -> dribble pass catch fake A [0.55] | dribble pass catch fake [0.45]"
    ),
    "steps and kicks": (
        "S -> bow A bow\nA -> W K A [0.5] | W K [0.5]\nW -> step W [0.5] | step [0.5]\n"
        "K -> kick | punch"
    ),
    "first and last agree": (
        "S -> left M left [0.5] | right M right [0.5]\n"
        "M -> step M [0.35] | turn M [0.2] | step [0.45]"
    ),
    "loop in an option": (
        "S -> bow O bow\nO -> wave A clap [0.6] | clap [0.4]\nA -> step A [0.6] | step [0.4]"
    ),
    "two loops around a choice": (
        "S -> A M B\nA -> run A [0.55] | run [0.45]\nM -> jump | duck\n"
        "B -> hop spin B [0.55] | hop spin [0.45]"
    ),
    "counts a b a b": "S -> P P\nP -> a P b [0.5] | a b [0.5]",
    "mirrored pairs in a list": (
        "S -> M next S [0.45] | M [0.55]\nM -> x M x [0.25] | y M y [0.25] | z [0.5]"
    ),
    "option after a nest": (
        "S -> N E end\nN -> open N close [0.5] | open close [0.5]\nE -> shake [0.5] | empty [0.5]"
    ),
}
"""Languages on which faults of the search and of the evidence were looked for and mended."""
