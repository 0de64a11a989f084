"""The verbs that make motion from sentences."""

from __future__ import annotations

from motiondb import store
from motiondb.database.ask.question_verbs import QuestionVerbs
from motiondb.database.generate import generating
from motiondb.database.generate.keeping import keep_generated
from motiondb.records import Caption, CaptureInfo


class MakingVerbs(QuestionVerbs):
    """Verbs that make motion; those that ask are inherited."""

    def generate(
        self,
        words: str,
        seed: int = 0,
        method: str = "stitched",
        exact: bool = False,
        anyway: bool = False,
    ) -> generating.Generated:
        """Generate a motion from a sentence.

        ``shown`` of the result says for every action whether the motion shows it.

        Parameters
        ----------
        words : str
            The sentence, such as "a person walks slowly, then kicks twice".
        seed : int
            The same seed gives the same motion, another seed another one if there is a choice.
        method : str
            "stitched" (excerpts of captures), "trajectory" (most probable smooth trajectory) or
            "montecarlo" (every frame drawn).
        exact : bool
            Whether words that no caption holds are left out; otherwise a word that may be taken as
            a known one is replaced by the likeliest.
        anyway : bool
            Whether to generate the nearest motion if nothing in the database shows an action.

        Raises
        ------
        NotLearnedError
            When the database has not learned, or learned no words.
        QueryError
            For an unknown method, no known word, or an action that nothing in the database shows.
        """
        settings = generating.GenerateSettings(method, exact, anyway)
        return generating.generate(self.session, words, seed, settings)[0]

    def generate_variants(
        self,
        words: str,
        number: int,
        seed: int = 0,
        method: str = "stitched",
        exact: bool = False,
        anyway: bool = False,
    ) -> list[generating.Generated]:
        """Make several motions from one sentence: those of the seed and of the following seeds.

        Stitched motions that are made from the same places of captures as an earlier one are left
        out. If there are fewer different ones than asked for, fewer are returned.

        Parameters
        ----------
        words : str
            The sentence.
        number : int
            Most motions.
        seed : int
            The same seed gives the same motions.
        method : str
            As for :meth:`generate`; "trajectory" has one motion only.
        exact : bool
            As for :meth:`generate`.
        anyway : bool
            As for :meth:`generate`.

        Raises
        ------
        NotLearnedError
            When the database has not learned, or learned no words.
        QueryError
            As for :meth:`generate`, and for more motions than the method has.
        """
        settings = generating.GenerateSettings(method, exact, anyway)
        return generating.generate(self.session, words, seed, settings, number)

    def save_generated(
        self, name: str, words: str, made: generating.Generated, seed: int
    ) -> CaptureInfo:
        """Keep a generated motion as a capture, with the origin of every frame.

        Parameters
        ----------
        name : str
            Name of the new capture.
        words : str
            Its caption.
        made : Generated
            The motion.
        seed : int
            Seed that the run names.
        """
        with store.transaction(self.store):
            run_id = store.start_run(self.store, "generate", {"words": words}, seed)
            captions = [Caption(words)]
            info = keep_generated(self.store, name, made.motion, made.provenance, captions, run_id)
            store.finish_run(self.store, run_id)
        return info
