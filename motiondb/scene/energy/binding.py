"""Binding: from the semantic rules of a grammar and a diagram to the rule table of a scene's trees.

Every action is subject to the rules of its symbol, below the ancestors that it has in its tree. The
rules of a nonterminal are about the sequence of actions that it derives, those of the diagram about
its items. Roles are resolved by the diagram's items: the player who is passed to or screened is the
receiver; the player who is screened, guarded, blocked or run at is the opponent; elsewhere the
opponent is ``diagram.opponent_of``. A rule is unmet if nobody fills its role (a pass that no item
asks for).

Choices that the paper leaves open: if several consecutive actions of one item have the same rule
``at end`` (``at start``), it holds only for the last (first), because a circle is the end of a move
and not of each step. A synchronisation whose partner's action no item names refers to the partner's
action that fulfils it best.

Source: K. Hyun, K. Lee and J. Lee, "Motion Grammars for Character Animation", Computer Graphics
Forum 35 (2016), sections 3.1 and 4.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motiondb.errors import SceneError
from motiondb.grammar.cfg.context_free import Tree
from motiondb.records import IntArray
from motiondb.scene.language.activity import (
    GIVE,
    OPPONENT,
    PARTNER,
    PLAYER,
    PUT,
    RECEIVER,
    SEND,
    STRIKE,
    TAKE,
    TARGET,
    Activity,
    Answers,
    Place,
)
from motiondb.scene.language.expressions import (
    DiagramRule,
    Item,
    Spans,
    assignments,
    auxiliary_rules,
    expressions,
    g_user,
    spans,
    step_of,
    unlinked_orders,
)
from motiondb.scene.language.motion_grammar import (
    Annotation,
    MotionGrammar,
    counts_elsewhere,
    nodes_of,
)
from motiondb.scene.language.possession import lies_at
from motiondb.scene.language.semantic_rules import (
    END,
    EVENT,
    PATH,
    START,
    DirectionRule,
    DistanceRule,
    LineRule,
    Moment,
    PositionRule,
    SemanticRule,
    Spot,
    SynchronisationRule,
    Target,
)
from motiondb.scene.language.semantic_rules import THROUGHOUT as THROUGHOUT_NAME
from motiondb.scene.language.tactics import Diagram, Directed, answered

POSITION, DIRECTION, SYNCHRONISATION, DISTANCE, LINE, UNMET, ORDER = range(7)
AT_START, AT_END, AT_EVENT, THROUGHOUT, ON_THE_WAY = range(5)
POINT, HEADING = -1, -2
_NOTHING = POINT, 0.0, 0.0  # A rule without a target, or without another end

KINDS: dict[type, int] = {
    PositionRule: POSITION,
    DirectionRule: DIRECTION,
    SynchronisationRule: SYNCHRONISATION,
    DistanceRule: DISTANCE,
    LineRule: LINE,
}  # Number of each kind of rule

ORDER_WEIGHT, THROUGH_WEIGHT = 0.5, 0.05
"""c_k of a late step, s, and of a way through a table, a share of frames. Chosen by hand."""
_FAR = 1.0
"""Metres beyond a distance of an act's rule from which on somebody goes there first; half of it
where something is taken or put, which nobody does while walking."""
UNMET_WEIGHT = 0.1  # c_k of a rule whose role nobody fills: it costs 10, like a broken distance

ROW = np.dtype(
    [(name, np.int64) for name in ("kind", "player", "first", "last", "moment")]
    + [("fraction", np.float64), ("target", np.int64), ("x", np.float64), ("z", np.float64)]
    + [("other", np.int64), ("other_x", np.float64), ("other_z", np.float64)]
    + [("near", np.float64), ("far", np.float64), ("lag", np.float64)]
    + [(name, np.int64) for name in ("partner", "partner_first", "partner_last")]
    + [("weight", np.float64)]
)  # Fields of a row, each aligned to 8 bytes


@dataclass(frozen=True, eq=False)
class RuleTable:
    """The rules of a scene.

    A row is one rule f_k of a sequence of a player's actions. All players that it is about are
    resolved to a player's number or a point on the ground::

      kind      what is measured: POSITION, DIRECTION, SYNCHRONISATION, DISTANCE, LINE; UNMET if
                nobody fills a role: then f = 1
      player    whose rule it is; first, last: the actions, half-open
      moment    AT_START (first frame of the actions), AT_END (their last one), AT_EVENT (the event
                of the first action, or the middle of its clip), THROUGHOUT (mean over the frames),
                ON_THE_WAY (the frame at which ``fraction`` of the distance has been covered)
      target    a player, or POINT (x, z), or HEADING (theta in ``x``); other, other_x, other_z: the
                second end of a line
      near, far of a distance, metres; of a direction ``near`` is the angle to it
      lag       of a synchronisation, seconds; NaN for a ball's flight
      partner   of a synchronisation; its actions are ``partners[partner_first:partner_last]``; the
                action that fulfils the rule best counts
      weight    c_k: f_k / c_k is the row's part of -log P(Y)

    A table depends on the trees alone, not on clips and places. It is computed again when the
    structure changes, and not when clips are exchanged.

    Beside the rules there are wishes, which only the sampling weighs, and which the report tells in
    other words if they are not fulfilled: nobody walks through what stands on the ground, and
    (ORDER) action ``first`` of the player comes before action ``partner_first`` of the player
    ``target``, because the diagram draws it in an earlier step. Their events count; of a way its
    beginning (AT_START) and its end (``fraction`` is 1).
    """

    players: tuple[str, ...]  # Names in the order of the diagram; the rows hold their indices
    actions: tuple[tuple[str, ...], ...]  # The action string of every player
    rows: NDArray[np.void]
    partners: IntArray  # (n,), int: actions that synchronisation rules may refer to
    # (n, 4), int: player, action, player, action of those who are meant to touch
    contacts: IntArray
    rules: tuple[SemanticRule, ...]  # The rule that each row was made from; also for unmet rules
    # (rules,), int: the class of the player's expression that the row belongs to, or -1
    items: IntArray
    stray: int = 0  # Number of actions of all players that belong to no class
    activity: Activity = field(default_factory=Activity)  # That of the grammar
    # Player and action -> name of the place or player that the object is sent or put to
    aims: Mapping[tuple[int, int], str] = field(default_factory=dict)
    places: Mapping[str, Place] = field(default_factory=dict)  # With their positions in the diagram
    diagram: Diagram = field(default_factory=lambda: Diagram("", (), ()))
    annotations: tuple[Annotation, ...] = ()  # The rules of the grammar
    # The step of the diagram, the player and the actions [first, last) of every item
    steps: tuple[tuple[int, int, int, int], ...] = ()
    wishes: NDArray[np.void] = field(default_factory=lambda: np.zeros(0, ROW))
    unasked: tuple[tuple[str, ...], ...] = ()  # By player, as ``MotionGrammar.unasked`` says

    @property
    def weighed(self) -> RuleTable:
        """The table with its wishes as rows, for the sampling."""
        return replace(self, rows=np.concatenate([self.rows, self.wishes]))


_MOMENTS = {START: AT_START, END: AT_END, THROUGHOUT_NAME: THROUGHOUT, PATH: ON_THE_WAY}
_CONTACT = "contact"  # Event of actions of two players that are meant to touch


@dataclass(frozen=True)
class _Stretch:
    """Actions [first, last) of a player, the item that they belong to (-1: none), their rule."""

    player: int
    first: int
    last: int
    item: int
    rule: SemanticRule
    partner_item: int = -1
    meant: tuple[int, ...] | None = None  # The partner's actions, if they are known


@dataclass(frozen=True)
class BoundString:
    """A player's actions with their rules: the binding without other players."""

    tree: Tree
    actions: tuple[str, ...]
    spans: Spans
    stretches: tuple[_Stretch, ...]
    rows: tuple[tuple[float, ...], ...]
    """Rows of the rule table; () for synchronisations, which depend on other players."""

    @property
    def stray(self) -> int:
        """Number of actions that belong to no class of the expression."""
        return len(self.actions) - sum(end - first for first, end in self.spans)


_Resolved = tuple[int, float, float]
"""A target: a player's number, POINT or HEADING, and x, z (or theta, 0)."""


@dataclass(frozen=True, eq=False)
class Binder:
    """Binding for many trees of one diagram and grammar."""

    diagram: Diagram
    grammar: MotionGrammar

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The players, in the order of the diagram."""
        return tuple(player.name for player in self.diagram.players)

    @cached_property
    def items(self) -> tuple[tuple[Item, ...], ...]:
        """The expression of every player."""
        items_of = expressions(self.diagram)
        return tuple(items_of[name] for name in self.names)

    @cached_property
    def _number(self) -> dict[str, int]:
        return {name: number for number, name in enumerate(self.names)}

    @cached_property
    def _places(self) -> dict[str, Spot]:
        return dict(self.diagram.places)

    @cached_property
    def _auxiliary(self) -> tuple[tuple[DiagramRule, ...], ...]:
        away = {name: self._away(player) for player, name in enumerate(self.names)}
        rules = [
            rule
            for rule in auxiliary_rules(self.diagram, self.grammar)
            if rule.rule.moment.name != START or rule.item not in away[rule.player]
        ]
        return tuple(tuple(r for r in rules if r.player == name) for name in self.names)

    def _away(self, player: int) -> set[int]:
        """Return the items that begin elsewhere than they are drawn, until a way ends at a point.

        Somebody who acts with a person or thing that is far from there goes to it.
        """
        found, away = set(), False
        for number, item in enumerate(self.items[player]):
            moves = len(item.way) > 1
            if away or (item.element >= 0 and not moves and self._is_far(player, number)):
                away = not moves
                found.add(number)
            away = away or item.beside != ""
        return found

    def _is_far(self, player: int, number: int) -> bool:
        """Return whether the rules of all actions of an item ask for somewhere else."""
        item, place_at = self.items[player][number], self.diagram.place_at
        here, step = item.way[0], self.diagram.elements[item.element].step
        deeds = {self.grammar.activity.deed(action) for action in item.actions}
        asked = [set(self.grammar.rules_of(action, ())) for action in item.actions]
        for rule in set.intersection(*asked):
            if not isinstance(rule, DistanceRule):
                continue
            target = self._resolved(rule.target, _Stretch(player, 0, 1, number, rule))
            ends = [Spot(*target[1:])] if target else [here]
            if target and target[0] >= 0:
                ends = [place_at(self.names[target[0]], when) for when in (step - 1, step)]
            apart = min(math.hypot(spot.x - here.x, spot.z - here.z) for spot in ends)
            if apart > rule.far + (_FAR if deeds.isdisjoint((TAKE, PUT)) else _FAR / 2.0):
                return True
        return False

    def assignments(self, player: int, actions: tuple[str, ...]) -> tuple[Spans, ...]:
        """Return the ways to assign a player's actions to their items."""
        return assignments(actions, self.items[player])

    def bind(self, strings: Sequence[BoundString]) -> RuleTable:
        """Return the table of the players' strings, in the order of the diagram."""
        rows, partners, contacts, used = [], list[int](), set[tuple[int, int, int, int]](), []
        for one in strings:
            for stretch, known in zip(one.stretches, one.rows, strict=True):
                rows.append(known or self._row(stretch, strings, partners, contacts))
                used.append(stretch)
        for stretch in (*self._answering(strings), *self._timed(strings), *self._keeping(strings)):
            rows.append(self._row(stretch, strings, partners, contacts))
            used.append(stretch)
        return RuleTable(
            self.names,
            tuple(string.actions for string in strings),
            np.array(rows, dtype=ROW),
            np.array(partners, dtype=np.int64),
            np.array(sorted(contacts), dtype=np.int64).reshape(-1, 4),
            tuple(stretch.rule for stretch in used),
            np.array([stretch.item for stretch in used], dtype=np.int64),
            sum(string.stray for string in strings),
            self.grammar.activity,
            {key: name for n, one in enumerate(strings) for key, name in self._aims(n, one)},
            self._grounded,
            self.diagram,
            self.grammar.annotations,
            tuple(self._steps(strings)),
            np.array([*self._orders(strings), *self._ways(strings)], dtype=ROW),
            self._unasked,
        )

    @cached_property
    def _unasked(self) -> tuple[tuple[str, ...], ...]:
        return tuple(self.grammar.unasked(one.team) for one in self.diagram.players)

    def _orders(self, strings: Sequence[BoundString]) -> Iterator[tuple[float, ...]]:
        """Yield that players do a step before others do a later one."""
        for one, k, other, m in self._unlinked:
            first, last = strings[one].spans[k][0], strings[other].spans[m][1] - 1
            moment = AT_START if self.items[one][k].repeated else AT_EVENT
            until = float(self.items[other][m].repeated)
            yield (
                *(ORDER, one, first, first + 1, moment, until, other, 0.0, 0.0, *_NOTHING),
                *(0.0, math.inf, 0.0, -1, last, last, ORDER_WEIGHT),
            )

    @cached_property
    def _unlinked(self) -> tuple[tuple[int, int, int, int], ...]:
        return tuple(unlinked_orders(self.diagram, self.items))

    def _ways(self, strings: Sequence[BoundString]) -> Iterator[tuple[float, ...]]:
        """Yield that nobody walks through what stands on the ground, unless a rule leads there."""
        for place in self._grounded.values():
            if place.at is None or not place.is_in_the_way:
                continue
            at, near = (POINT, place.at.x, place.at.z), place.width / 2.0
            for player, string in enumerate(strings):
                rows = np.array([row for row in string.rows if row], dtype=ROW)
                if not place.leading_into(rows).any():
                    whole = DISTANCE, player, 0, len(string.actions), THROUGHOUT, 0.0
                    yield *whole, *at, *_NOTHING, near, math.inf, 0.0, -1, -1, -1, THROUGH_WEIGHT

    def _steps(self, strings: Sequence[BoundString]) -> Iterator[tuple[int, int, int, int]]:
        """Yield the step of every drawn item, its player, and its actions [first, last)."""
        for player, string in enumerate(strings):
            for item, (first, last) in zip(self.items[player], string.spans, strict=True):
                if item.element >= 0:
                    yield step_of(self.diagram, self.names[player], item), player, first, last

    def _timed(self, strings: Sequence[BoundString]) -> Iterator[_Stretch]:
        """Yield the synchronisations of steps of which the diagram says how far they are apart."""
        if not self.diagram.times:
            return
        of: dict[int, tuple[int, int, int]] = {}
        for step, player, first, last in self._steps(strings):
            of.setdefault(step, (player, first, last - 1))
        for step, lag, since in self.diagram.times:
            if step in of and since in of:  # from the end of a way to the beginning of one
                (one, _, k), (other, m, _) = of[since], of[step]
                action = strings[other].actions[m]
                rule = SynchronisationRule(self.names[other], (action,), lag, Moment(EVENT))
                yield _Stretch(one, k, k + 1, -1, rule, meant=(m,))

    def _keeping(self, strings: Sequence[BoundString]) -> Iterator[_Stretch]:
        """Yield the distances that players keep from one step to another.

        They are looked at while either of the two acts, so that who keeps the distance goes with
        who leaves.
        """
        for kept in self.diagram.stretches:
            if not kept.other:
                continue
            for name, other in ((kept.player, kept.other), (kept.other, kept.player)):
                player = self._number[name]
                inside = [
                    (first, last)
                    for step, who, first, last in self._steps(strings)
                    if who == player and kept.first <= step <= (kept.last or step)
                ]
                if not kept.last:
                    inside = [(0, len(strings[player].actions))]
                if not inside:
                    continue
                rule = DistanceRule(other, kept.near, kept.far)
                first, last = min(a for a, _ in inside), max(b for _, b in inside)
                yield _Stretch(player, first, last, -1, rule)

    @cached_property
    def _grounded(self) -> dict[str, Place]:
        known = self.grammar.activity.place
        return {n: replace(known.get(n, Place(n)), at=at) for n, at in self._places.items()}

    def _aims(self, player: int, string: BoundString) -> Iterator[tuple[tuple[int, int], str]]:
        """Yield a player's actions that send or put the object, with the names of their targets."""
        items = self.items[player]
        sends = self.grammar.activity.doing(SEND, STRIKE, PUT)
        for k, action in enumerate(string.actions):
            if action in sends:
                of = [n for n, (first, last) in enumerate(string.spans) if first <= k < last]
                item = items[of[0]] if of else Item((action,))
                yield (player, k), self.role(TARGET, item, self.names[player])

    def string(self, player: int, tree: Tree, chosen: Spans | None = None) -> BoundString:
        """Return a player's rules in a tree.

        ``chosen`` are the actions of the player's items; None means the first that match.
        """
        name, items = self.names[player], self.items[player]
        actions = tree.leaves()
        parts = chosen or spans(actions, items)
        if not actions or parts is None:
            wanted = "".join(map(str, items)) or "at least one action"
            missed = g_user(actions, [item.actions for item in items])
            raise SceneError(
                f"{self.diagram.name}: expected of {name} actions that fit {wanted}, found"
                f" '{' '.join(actions)}', with g_user = {missed}. Take a tree with g_user = 0, as"
                " cast() finds it."
            )
        item_of = [-1] * len(actions)
        for item, (first, last) in enumerate(parts):
            item_of[first:last] = [item] * (last - first)
        clips = []
        nodes = list(nodes_of(tree))
        of_action = [self.grammar.rules_of(n.symbol, n.above) for n in nodes if n.is_leaf]
        for node in nodes:
            if node.is_leaf:
                k = node.first
                for rule in of_action[k]:
                    if not counts_elsewhere(rule, k, item_of, of_action):
                        clips.append(_Stretch(player, k, k + 1, item_of[k], rule))
            elif node.last > node.first:
                for rule in self.grammar.rules_of(node.symbol, node.above):
                    clips.append(_Stretch(player, node.first, node.last, -1, rule))
        for said in self._auxiliary[player]:
            first, last = parts[said.item] if said.item >= 0 else (0, len(actions))
            clips.append(_Stretch(player, first, last, said.item, said.rule, said.partner_item))
        rows = tuple(
            () if isinstance(one.rule, SynchronisationRule) else self._row(one, [], [], set())
            for one in clips
        )
        return BoundString(tree, actions, parts, tuple(clips), rows)

    def _row(
        self,
        stretch: _Stretch,
        strings: Sequence[BoundString],
        partners: list[int],
        contacts: set[tuple[int, int, int, int]],
    ) -> tuple[float, ...]:
        """Return the numbers of one rule; its partners are added to ``partners``."""
        rule = stretch.rule
        target: _Resolved | None = (POINT, 0.0, 0.0)
        other: _Resolved | None = (POINT, 0.0, 0.0)
        near, far, lag, partner, since = 0.0, math.inf, 0.0, -1, len(partners)
        if isinstance(rule, PositionRule | DirectionRule | DistanceRule):
            target = self._resolved(rule.target, stretch)
        if isinstance(rule, DistanceRule):
            near, far = rule.near, rule.far
        if isinstance(rule, DirectionRule):
            near = rule.turn
        if isinstance(rule, LineRule):
            target = self._resolved(rule.first, stretch)
            other = self._resolved(rule.second, stretch)
        if isinstance(rule, SynchronisationRule):
            lag = math.nan if rule.lag is None else rule.lag
            partner, meant = self._partner(rule, stretch, strings)
            partners.extend(meant)
            target = target if meant else None
            said = self.grammar.terminal
            if said[strings[stretch.player].actions[stretch.first]].event == _CONTACT:
                theirs = strings[partner].actions if meant else ()
                touched = [m for m in meant if said[theirs[m]].event == _CONTACT]
                contacts.update((stretch.player, stretch.first, partner, m) for m in touched)
        kind, weight = KINDS[type(rule)], rule.weight
        if target is None or other is None:
            kind, weight, target, other = UNMET, UNMET_WEIGHT, (POINT, 0.0, 0.0), (POINT, 0.0, 0.0)
        moment = _MOMENTS.get(rule.moment.name, AT_EVENT)
        return (
            *(kind, stretch.player, stretch.first, stretch.last, moment, rule.moment.fraction),
            *target,
            *other,
            *(near, far, lag, partner, since, len(partners), weight),
        )

    def _resolved(self, target: Target | float, stretch: _Stretch) -> _Resolved | None:
        """Return a target of a rule, or None if it is a role that nobody fills."""
        if isinstance(target, Spot):
            return POINT, target.x, target.z
        if isinstance(target, float | int):
            return HEADING, float(target), 0.0
        target = self._named(target, stretch)
        if target in self._number:
            return self._number[target], 0.0, 0.0
        spot = self._places.get(target)
        return (POINT, spot.x, spot.z) if spot else None

    def _named(self, name: str, stretch: _Stretch) -> str:
        """Return the player or place that a name in a rule means, or ""."""
        if name in self._number or name in self._places:
            return name
        item = self.items[stretch.player][stretch.item] if stretch.item >= 0 else None
        element = self.diagram.elements[item.element] if item and item.element >= 0 else None
        thing = self.grammar.activity.thing
        if thing and name == thing.name:
            return lies_at(self.diagram, element)
        return self.role(name, item, self.names[stretch.player])

    def role(self, role: str, item: Item | None, who: str) -> str:
        """Return the player or place that fills a role in an action of a player, or ""."""
        other = item.other if item else ""
        activity, player = self.grammar.activity, self.diagram.player
        if role == TARGET and item:
            return item.target or other or activity.aim(item.actions[0])
        same = other and player[other].team == player[who].team != PLAYER
        passes = item is not None and activity.deed(item.actions[0]) in (GIVE, TAKE)
        meant = role in (RECEIVER, PARTNER) or (role == OPPONENT and not same and not passes)
        if other and (meant or player[other].team == role):
            return other
        return self.diagram.filled(role, who)

    def _partner(
        self, rule: SynchronisationRule, stretch: _Stretch, strings: Sequence[BoundString]
    ) -> tuple[int, list[int]]:
        """Return the partner of a synchronisation, and the partner's actions that may be meant."""
        name = self._named(rule.partner, stretch)
        if name not in self._number:
            return -1, []
        partner = self._number[name]
        if stretch.meant is not None:
            return partner, list(stretch.meant)
        theirs = strings[partner]
        item = stretch.partner_item
        if item < 0 and stretch.item >= 0:
            thrown = self.items[stretch.player][stretch.item]
            item = thrown.other_item if thrown.other == name else -1
        if item >= 0 and theirs.actions[theirs.spans[item][0]] in rule.actions:
            return partner, [theirs.spans[item][0]]
        return partner, [m for m, action in enumerate(theirs.actions) if action in rule.actions]

    def _answering(self, strings: Sequence[BoundString]) -> Iterator[_Stretch]:
        """Yield the synchronisations of acts with their answers, one to one and in order.

        An act without an answer, and an answer to nothing, are rules that nobody fills.
        """
        for said in self.grammar.activity.answers:
            acts = [self._directed(n, string, said.acts) for n, string in enumerate(strings)]
            replies = [self._directed(n, string, said.answers) for n, string in enumerate(strings)]
            for act, reply in answered(said, acts, replies):
                yield self._answer(said, act, reply)

    def _answer(self, said: Answers, act: tuple[int, int], reply: tuple[int, int]) -> _Stretch:
        """Return the rule of an act and its answer, either of which may be missing (-1)."""
        (one, k), (other, m) = act, reply
        moment = Moment(EVENT)
        if k < 0:
            rule = SynchronisationRule(self.names[one], said.acts, -said.lag, moment)
            return _Stretch(other, m, m + 1, -1, rule, meant=())
        rule = SynchronisationRule(self.names[other], said.answers, said.lag, moment)
        return _Stretch(one, k, k + 1, -1, rule, meant=(m,) if m >= 0 else ())

    def _directed(
        self, player: int, string: BoundString, actions: tuple[str, ...]
    ) -> list[Directed]:
        """Return a player's actions of a kind."""
        found = []
        for k, action in enumerate(string.actions):
            if action not in actions:
                continue
            of = [n for n, (first, last) in enumerate(string.spans) if first <= k < last]
            item = self.items[player][of[0]] if of else None
            element = self.diagram.elements[item.element] if item and item.element >= 0 else None
            to = item.other if item and element else self.diagram.partner_of(self.names[player])
            if element and element.player == self.names[player]:
                to = self.diagram.faced(element)
            target = self._number.get(to, -1)
            found.append((k, element.step if element else -1, target))
        return found


def bind(
    diagram: Diagram,
    grammar: MotionGrammar,
    trees: Sequence[Tree] | Mapping[str, Tree],
    chosen: Sequence[Spans | None] | None = None,
) -> RuleTable:
    """Return the table of the players' trees, given in the order of the diagram or by name.

    ``chosen`` are the actions of each player's items; None means the first that match.
    """
    if isinstance(trees, Mapping):
        trees = [trees[player.name] for player in diagram.players]
    if len(trees) != len(diagram.players):
        raise SceneError(
            f"{diagram.name}: expected {len(diagram.players)} trees, one for each player,"
            f" found {len(trees)}. Give the trees in the order of the players."
        )
    binder = Binder(diagram, grammar)
    of = chosen or [None] * len(trees)
    return binder.bind([binder.string(n, tree, of[n]) for n, tree in enumerate(trees)])
