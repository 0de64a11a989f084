"""Every numeric option of every command has a range; senseless numbers end with exit code 2."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import typer

from motiondb.cli.main import make_app

NUMBERS = {"integer": int, "integer range": int, "float": float, "float range": float}
"""Types of options by the names that Typer gives them."""
CHECKED = {
    # No range of Typer: the settings refuse it (``SceneSettings``), with this text.
    ("scene make", "--chains"): "chains: expected 1 to 64",
}


class NumericOption(NamedTuple):
    """An option of a command that takes a number."""

    command: str
    option: str
    kind: type
    least: float | None
    most: float | None


def commands(name: str, group: Any) -> Iterator[tuple[str, Any]]:
    for part, command in getattr(group, "commands", {}).items():
        yield f"{name}{part}", command
        yield from commands(f"{name}{part} ", command)


COMMANDS = dict(commands("", typer.main.get_command(make_app())))


def numeric_options() -> Iterator[NumericOption]:
    for name, command in COMMANDS.items():
        for parameter in command.params:
            kind = NUMBERS.get(parameter.type.name) if parameter.opts else None
            if kind is not None:
                least, most = (getattr(parameter.type, end, None) for end in ("min", "max"))
                yield NumericOption(name, parameter.opts[0], kind, least, most)


OPTIONS = list(numeric_options())
WAIT = next(option for option in OPTIONS if option.option == "--wait")
TRIED = [WAIT, *(option for option in OPTIONS if option.option != "--wait")]
"""Every command has ``--wait``, which is written once."""


def arguments(command: str) -> list[str]:
    """Required arguments and options of a command, with values that would be read later."""
    words: list[str] = []
    for parameter in COMMANDS[command].params:
        if parameter.required:
            value = "1" if parameter.type.name in NUMBERS else "x.bvh"
            words += [parameter.opts[0], value] if parameter.opts[0].startswith("-") else [value]
    return words


def refused(run: Any, command: str, option: str, value: str) -> Any:
    words = arguments(command)
    if option in words:  # a required option: replace its value
        words[words.index(option) + 1] = value
        return run(*command.split(), *words)
    return run(*command.split(), *words, option, value)


@pytest.mark.parametrize("option", TRIED, ids=lambda o: f"{o.command} {o.option}")
def test_numeric_options_refuse_what_makes_no_sense(
    command: Callable[..., Any], option: NumericOption
) -> None:
    senseless = ["nan", "inf", "-inf"] if option.kind is float else ["nan", "inf", "1.5"]
    for value in [*senseless, "-1", "-1e999" if option.kind is float else "-99999999999999999999"]:
        ended = refused(command, option.command, option.option, value)
        text = CHECKED.get((option.command, option.option))
        assert ended.code == (1 if text and text in ended.err else 2), (value, ended.err)
        assert (text and text in ended.err) or option.option in ended.err, (value, ended.err)
        assert "Traceback" not in ended.err
    assert list(Path().iterdir()) == []


def test_numeric_options_have_a_least_value_and_floats_a_largest() -> None:
    assert len(OPTIONS) > 30
    for option in OPTIONS:
        if (option.command, option.option) not in CHECKED:
            assert option.least is not None, option
            assert option.kind is int or option.most is not None, option


def test_finite_lets_numbers_pass_and_names_others() -> None:
    from motiondb.cli.options import finite

    assert (finite(1.5), finite(None), finite(0.0)) == (1.5, None, 0.0)
    for value in (float("nan"), float("inf")):
        with pytest.raises(typer.BadParameter, match=f"expected a finite number, found {value}"):
            finite(value)
