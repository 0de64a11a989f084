"""Reading diagrams from text: one statement a line, in metres; ``#`` begins a comment.

::

    diagram "Give and Go"                     # its title
    grammar basketball                        # the grammar that it is played by
    court half                                # the grammar's ground; or: ground 8 x 6
    place bench at 6 2                        # where a place is that rules may name
    ball A1                                   # who has the object, if no element implies it

    attack A1 at 0 8                          # a circle: role, name, x and z
    defence D1 at 0 6.5 guards A1             # or: follower F1 at 0 6 follows L1

    1 pass A1 to A2                           # the number is the step; a later catch: caught 2
    1 feint D1 to 1 6
    2 cut A1 via 1.5 5 to 0.6 1.4             # via may name several points, divided by commas
    3 layup A1 at rim                         # at, on, with, to: a player or a place
    1 does D1 guard* then run | walk          # exactly these actions, in this order

    D1 keeps 0.5 m .. 2 m to A1 from 1 to 4   # a distance, from one step to another
    D1 keeps moving
    step 3 comes 0.6 s after 2

Verbs are the actions of the grammar, and those that it declares (:mod:`.grammar_file`).
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

from motiondb.errors import Fault, SceneError, suggestion
from motiondb.scene.language.activity import GIVE, PLAYER, Activity, Ground, Step
from motiondb.scene.language.possession import check_diagram
from motiondb.scene.language.semantic_rules import Spot
from motiondb.scene.language.tactics import DOES, Diagram, Element, Player, Stretch
from motiondb.scene.language.texts import LARGEST, Quantity, Reading, read_statements

if TYPE_CHECKING:
    from lark import Token

# Writing tactics diagrams as text, which :func:`read_diagram` reads again.


def format_diagram(diagram: Diagram) -> str:
    r"""Return the text of a diagram.

    >>> from motiondb.scene.language.tactics import Player
    >>> shooter = Player("A1", "attack", Spot(0.0, 8.0))
    >>> play = Diagram("Drill", (shooter,), (Element("layup", 1, "A1"),))
    >>> print(format_diagram(play))
    diagram "Drill"
    grammar basketball
    <BLANKLINE>
    attack A1 at 0 8
    <BLANKLINE>
    1 layup A1
    <BLANKLINE>

    Places are written to the centimetre: nobody draws more exactly.
    """
    head = [f'diagram "{diagram.name}"', f"grammar {diagram.grammar}"]
    if diagram.ground is not None:
        head.append(f"ground {_number(diagram.ground.width)} x {_number(diagram.ground.length)}")
    head += [f"place {name} at {_spot(at)}" for name, at in diagram.own_places]
    if diagram.ball:
        head.append(f"{_thing(diagram.activity)} {diagram.ball}")
    players = [
        f"{player.team} {player.name} at {_spot(player.at)}"
        + (f" guards {player.guards}" if player.guards else "")
        for player in diagram.players
    ]
    drawn = [_element(one, diagram) for one in diagram.elements if one.kind != DOES]
    parts = (head, players, drawn, other_statements(diagram))
    return "\n\n".join("\n".join(lines) for lines in parts if lines) + "\n"


def other_statements(diagram: Diagram) -> list[str]:
    """Return the lines of a diagram that nothing is drawn for."""
    lines = [_element(one, diagram) for one in diagram.elements if one.kind == DOES]
    lines += [str(one) for one in diagram.stretches]
    within = diagram.times
    return lines + [f"step {step} comes {lag:g} s after {since}" for step, lag, since in within]


def _thing(activity: Activity) -> str:
    """Return how diagrams call the object; "ball" where the grammar is not known."""
    if activity.thing:
        return activity.thing.name
    return "" if activity.actions else "ball"


def _number(value: float) -> str:
    return f"{round(value, 2) + 0.0:g}"


def _spot(spot: Spot) -> str:
    return f"{_number(spot.x)} {_number(spot.z)}"


def _element(element: Element, diagram: Diagram) -> str:
    text = f"{element.step} {element.kind} {element.player}"
    if element.kind == DOES:
        return f"{text} {' then '.join(map(_step, element.steps))}"
    about, verb = element.other or element.target, diagram.verb(element)
    if about:
        text += f" {element.link or verb.link or 'on'} {about}"
    if element.caught:
        text += f" caught {element.caught}"
    if element.via:
        text += f" via {', '.join(map(_spot, element.via))}"
    return text + (f" to {_spot(element.to)}" if element.to else "")


def _step(step: Step) -> str:
    return " | ".join(step.actions) + "*" * bool(step.repeated)


_KEYWORDS = ("diagram", "grammar", "court", "ground", "place", "step")
_LINKS = ("at", "to", "via", "caught", "with")  # What a link may be a slip of
_LONGEST_NAME = 60  # Most characters of a player's name, which becomes part of the names of files
_LAST_STEP = 10_000  # Largest step. A larger number is a slip
_LONGEST_TIME = 60.0  # Longest time between two steps, s
_GRAMMAR = re.compile(r"^[ \t]*grammar[ \t]+([^\W\d]\w*(?:-\w+)*)", re.MULTILINE)


def grammar_name(text: str) -> str:
    """Return the name of the grammar that a diagram's text is played by."""
    match = _GRAMMAR.search(text)
    return match[1] if match else Diagram.grammar


def read_diagram(
    text: str,
    where: str = "diagram",
    activity: Activity | None = None,
    is_kept: bool = False,
) -> Diagram:
    """Read a diagram from its text, and check that it can be played.

    `activity`: That of its grammar (:attr:`.motion_grammar.MotionGrammar.activity`); without, any
    word is a verb. `is_kept`: Whether it is of a scene that an earlier version made, which allowed
    slips.
    """
    diagram = parse_diagram(text, where, activity, is_kept)
    check_diagram(diagram, where)
    return diagram


def parse_diagram(
    text: str,
    where: str = "diagram",
    activity: Activity | None = None,
    is_kept: bool = False,
) -> Diagram:
    """Read a diagram from its text, whether or not it can be played."""
    reading = _DiagramReading(where, activity or Activity(), is_kept)
    read_statements("diagram", text, reading)
    reading.refuse_lone_roles()
    diagram = reading.diagram
    if not diagram.players:
        team = diagram.activity.teams[0]
        advice = f"Write '{team} A1 at 0 8'."
        raise SceneError(Fault("at least one player", "none", advice, code="nobody"), where=where)
    elements = tuple(_aimed(element, diagram) for element in diagram.elements)
    return replace(diagram, name=diagram.name or where, elements=elements)


def _aimed(element: Element, diagram: Diagram) -> Element:
    """Return an element about a place, where its name is that of a place and of no player."""
    is_place = element.other in dict(diagram.places) or element.other in diagram.activity.place
    if not is_place or element.other in diagram.player:
        return element
    return replace(element, other="", target=element.other)


class _DiagramReading(Reading):
    """The statements of a diagram (``diagram.lark``) read so far."""

    advice: ClassVar = {
        "NAME": "See the format of diagrams.",
        "_DIAGRAM": 'Write diagram "Give and Go".',
        "_GRAMMAR": "Write 'grammar basketball'.",
        "_PLACE": "Write 'place bench at 6 2'.",
        "_STEP": "Write 'step 3 comes 0.6 s after 2'.",
        "_KEEPS": "Write 'A1 keeps 0.5 m .. 2 m to A2 from 1 to 4', or 'A1 keeps moving'.",
        "_DOES": "Write '1 does A1 walk* then bow | wave'.",
        "_GROUND": "Write width and length in metres: 'ground 8 x 6'.",
        "_COURT": "Write width and length in metres: 'court 8 x 6'.",
        "STEP": "Write '1 pass A1 to A2'.",
        "HEAD": "Write 'attack A1 at 0 8'.",
    }
    expected: ClassVar = {
        "TEXT": "the diagram's title in quotes",
        "WHO": "a player's name",
        "AIM": "a player's or a place's name",
        "VERB": "what is done",
        "ACTION": "an action",
        "X": "x, metres",
        "Z": "z, metres",
    }

    def __init__(self, where: str, activity: Activity, is_kept: bool) -> None:
        super().__init__(where, is_kept)
        self.diagram = Diagram("", (), (), activity=activity)
        self.roles: list[Token] = []  # Those of players, as they are written

    def advise(self, before: list[Token]) -> str:
        """Return what to do; for an element, how it is written with a link."""
        if len(before) > 2 and before[1].type == "VERB":
            link = self.diagram.activity.verb(before[1]).link or "to"
            return f"Write '{' '.join(before[:3])} {link} {self._other(before[2])}'."
        return super().advise(before)

    def _other(self, who: str) -> str:
        """Return a player beside another one, for advice."""
        return next((one.name for one in self.diagram.players if one.name != who), "D1")

    def _add(self, **more: Any) -> None:  # noqa: ANN401
        self.diagram = replace(self.diagram, **more)

    def _diagram(self, word: Token, title: Token) -> None:
        self.once(word, "diagram", "'diagram' once")
        self._add(name=title.strip('"'))

    def _grammar(self, word: Token, name: Token) -> None:
        self.once(word, "grammar", "'grammar' once")
        self._add(grammar=str(name))

    def _ground(self, word: Token, said: Token | tuple[float, float]) -> None:
        self.once(word, "ground", f"'{word}' once")
        named = self.diagram.activity.ground.name
        if isinstance(said, tuple):
            self._add(ground=Ground.field(*said))
        elif said != (named or "half"):  # as older diagrams say of any ground
            advice = f"Write width and length in metres: '{word} 8 x 6'"
            advice += f", or '{word} {named}'." if named else "."
            what = f"the ground of the grammar ({named})" if named else "a size"
            self.fail(said, what, suggestion(said, [named]).strip() or advice)

    def _place(self, word: Token, name: Token, _: Token, x: Token, z: Token) -> None:
        self.once(word, f"place {name}", f"'place {name}' once")
        spot = self._spot(x, z)
        if max(abs(spot.x), abs(spot.z)) > LARGEST:
            self.fail(x, f"a place within {LARGEST:g} metres", "Lengths are metres.")
        given = {each for each, _ in self.diagram.own_places}
        missing = [each for each in self.diagram.activity.place if each not in given]
        near = "" if name in self.diagram.activity.place else self.slip(name, missing)
        if near and near.rstrip("0123456789") != name.rstrip("0123456789"):
            self.fail(name, f"the place {near} of the grammar", f"Did you mean {near}?")
        self._add(own_places=(*self.diagram.own_places, (str(name), spot)))

    def _number_of(self, token: Token) -> int:
        value = self.number(token)
        if value != int(value) or not 1 <= value <= _LAST_STEP:
            end = f"to {_LAST_STEP}" if value > _LAST_STEP else "on"
            self.fail(token, f"a whole number from 1 {end}", "Steps are counted 1, 2, 3.")
        return int(value)

    def _times(self, later: Token, lag: Quantity, earlier: Token) -> None:
        step, since = self._number_of(later), self._number_of(earlier)
        if since >= step or not 0.0 <= lag[0] <= _LONGEST_TIME:
            what = f"a step before {step}, and a time from 0 to {_LONGEST_TIME:g} s"
            self.fail(earlier, what, self.advice["_STEP"])
        self.once(earlier, ("times", step, since), f"once how long after {since} step {step} comes")
        self._add(times=(*self.diagram.times, (step, lag[0], since)))

    def _keeps(self, who: Token, kept: Token | tuple[float, float], *more: Any) -> None:  # noqa: ANN401
        *others, first, last = more
        stretch = Stretch(str(who), line=who.line or 0)
        if isinstance(kept, tuple):
            stretch = replace(stretch, near=kept[0], far=kept[1], other=str(others[0]))
        if first:
            stretch = replace(stretch, first=self._number_of(first), last=self._number_of(last))
            if stretch.last < stretch.first:
                self.fail(first, "an earlier step first", self.advice["_KEEPS"])
        self.once(who, replace(stretch, line=0), "every line once")
        self._add(stretches=(*self.diagram.stretches, stretch))

    def _held(self, word: Token, who: Token, *more: object) -> None:
        activity, thing = self.diagram.activity, _thing(self.diagram.activity)
        if word == thing and not any(more):
            self.once(word, "ball", f"'{thing}' once")
            self._add(ball=str(who))
            return
        words = (*_KEYWORDS, *([thing] if thing else []), *activity.teams)
        near = suggestion(word, words).strip()
        if word in activity.verbs:
            near = f"Write the step before it: '1 {word} ...'."
        if word in activity.teams:
            near = f"Write '{word} {who} at 0 8'."
        what = f"a step's number, or one of {', '.join(words)}"
        self.fail(word, what, near or "See the format of diagrams.")

    def _player(self, team: Token, name: Token, at: Spot, _: object, guards: Token | None) -> None:
        activity = self.diagram.activity
        if activity.roles and team not in activity.teams:
            self._held(team, name, at)
        self.roles.append(team)
        for other in self.diagram.players:  # some file systems do not tell upper from lower case
            if other.name.casefold() == name.casefold():
                self.fail(name, "a name of their own", f"Line {other.line} has the same.")
        if len(name) > _LONGEST_NAME:
            self.fail(name, f"a name of at most {_LONGEST_NAME} characters", "Shorten it.")
        player = Player(str(name), str(team), at, str(guards or ""), team.line or 0)
        self._add(players=(*self.diagram.players, player))

    def refuse_lone_roles(self) -> None:
        """Refuse a role that one player has and that is spelt like a keyword but for a letter.

        Without roles in the grammar any word is one. People rarely mistake the first letter.
        """
        for role in self.roles:
            near = self.slip(role, (*_KEYWORDS, PLAYER))
            is_own = role in self.diagram.activity.teams or self.roles.count(role) > 1
            if near and near[0] == role[0] and not is_own:
                what = f"'{near}', or a role of several players or of the grammar"
                self.fail(
                    role, what, f"Did you mean {near}? Or write 'role {role}' in the grammar."
                )

    def _class(self, *names: Token | None) -> Step:
        *actions, again = names
        known = self.diagram.activity.actions
        for action in actions:
            if action and known and action not in known:
                self.unknown(action, "an action", known)
        return Step(tuple(map(str, actions)), again == "*")

    def _does(self, step: Token, who: Token, *steps: Step) -> None:
        element = Element(DOES, self._number_of(step), str(who), line=who.line or 0, steps=steps)
        self._drawn(element, who)

    def _drawn(self, element: Element, who: Token) -> None:
        plain = replace(element, line=0)
        before = [replace(e, line=0) for e in self.diagram.elements if e.player == element.player]
        n_others = sum(each != plain for each in before)  # what is between two of the same
        self.once(who, (plain, n_others), f"'{element}' once in step {element.step}")
        self._add(elements=(*self.diagram.elements, element))

    def _via(self, *spots: Spot) -> dict[str, Any]:
        return {"via": spots}

    def _caught(self, step: Token) -> dict[str, Any]:
        return {"caught": self._number_of(step)}

    def _element(self, step: Token, kind: Token, who: Token, *tails: Any) -> None:  # noqa: ANN401
        activity, written = self.diagram.activity, f"{step} {kind} {who}"
        if activity.actions and kind not in activity.verbs:
            self.unknown(kind, "what is done", (*activity.verbs, DOES))
        verb, verbs = activity.verb(kind), activity.verbs.get(kind, ())
        links = [tail for tail in tails[:-1] if isinstance(tail, tuple)]
        element = Element(str(kind), self._number_of(step), str(who), line=who.line or 0)
        *others, goes = tails
        for tail in others:
            if isinstance(tail, dict):
                element = replace(element, **tail)
        element = replace(element, to=goes[0] if goes else None)
        for link, name in links:
            if not verb.link and (near := self.slip(link, _LINKS)):
                self.fail(link, repr(near), f"Did you mean {near}?")
            if link != (verb.link or link) or len(links) > 1:
                what = repr(verb.link) if verb.link else "one player or place"
                self.fail(link, what, f"Write '{written} {verb.link or link} {self._other(who)}'.")
            element = replace(element, link=str(link), other=str(name))
        gives = any(activity.deed(a) == GIVE for one in verbs for a in one.last)
        if element.caught and activity.actions and not gives and not self.is_kept:
            self.fail(who, "'caught' behind what gives", "Leave it out.", f"'caught' behind {kind}")
        must_go = element.to is None and (verb.must_go or element.via)
        if must_go or any(isinstance(tail, Spot) for tail in tails):
            self.fail(who, f"'to' behind {who}", f"Write where {who} goes: 'to 0.5 2'.", "no way")
        if verb.link and not links and verb.role != "target":
            advice = f"Write '{written} {verb.link} {self._other(who)}'."
            self.fail(who, f"'{verb.link}' behind {who}", advice, "nobody")
        self._drawn(element, who)
