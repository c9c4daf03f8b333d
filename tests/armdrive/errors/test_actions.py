"""What an error asks a person to do stands in the words of the interface that shows it."""

from __future__ import annotations

import ast
import functools
import re
from pathlib import Path

import pytest

import armdrive
import tui
from armdrive.cli.commands import COMMANDS
from armdrive.errors import ArmError, WrongState
from armdrive.errors.actions import ACTIONS, COMMAND_LINE, PHRASES, SHELL, desk_words, presented
from armdrive.errors.table import ENTRIES
from armdrive.programs.language.words import WORDS
from armdrive.programs.shell import OWN_WORDS
from armdrive.runtime.states import TRANSITIONS, Belief, Event, after, require_reference
from armdrive.status import State, Trust
from tui.keys.keyboard import DEFAULT_KEYS

INTERFACES = {
    "command line": COMMAND_LINE,
    "shell": SHELL,
    "desk": desk_words(DEFAULT_KEYS.label),
}
PYTHON = re.compile(r"\b[a-z_.]+\((?:\.\.\.|[a-z_]+=[^)]*)?\)|\b[a-z_]+=(?:True|False|None)\b")
"""A call, or an option of one."""

NO_SENTENCES = (
    "programs/", "sim/", "testing/", "transports/ports.py", "errors/actions.py", "errors/table.py",
    "arm/arguments.py", "moves.py",
)  # fmt: skip
"""The language of programs has calls of its own; the rest prints mathematics or Python itself, or
is about an argument, which only a Python program has. The catalogue is checked row by row above.
"""


def refusals_of_states() -> list[str]:
    """Return what is said of every transition that there is not."""
    said = []
    for state in State:
        for event in Event:
            if (state, event) not in TRANSITIONS:
                with pytest.raises(WrongState) as refused:
                    after(state, event)
                said.append(str(refused.value))
    return said


def refusals_of_trust() -> list[str]:
    """Return what is said of planned motion under each trust that refuses it."""
    said = []
    for trust in set(Trust) - {Trust.REFERENCED}:
        with pytest.raises(ArmError) as refused:
            require_reference(Belief(trust, "for a reason"), allow_restored=False)
        said.append(str(refused.value))
    return said


SENTENCES = (
    *(text for row in ENTRIES for text in (row.cause, row.effect, row.remedy)),
    *refusals_of_states(),
    *refusals_of_trust(),
    *(each.python for each in PHRASES),
)


@pytest.mark.parametrize("interface", INTERFACES)
def test_no_sentence_of_the_catalogue_speaks_python_to_a_person(interface):
    for sentence in SENTENCES:
        shown = presented(sentence, INTERFACES[interface])
        assert not PYTHON.search(shown), shown
        assert presented(shown, INTERFACES[interface]) == shown


def test_python_programs_read_python():
    with pytest.raises(ArmError, match=re.escape("connect with `allow_restored=True`")):
        require_reference(Belief(Trust.RESTORED, "found so"), allow_restored=False)
    with pytest.raises(WrongState, match=re.escape("call `reset()`")):
        after(State.ERROR_STOP, Event.MOVE)


@pytest.mark.parametrize(
    ("interface", "said"),
    [
        ("command line", "Look at the arm, run `armdrive reset`, then `armdrive home`."),
        ("shell", "Look at the arm, type `reset`, then `home`."),
        ("desk", "Look at the arm, press R, then H."),
    ],
)
def test_each_interface_has_its_own_words(interface, said):
    sentence = "Look at the arm, call `reset()`, then `home()`."
    assert presented(sentence, INTERFACES[interface]) == said
    assert presented("Call `home()`.", COMMAND_LINE) == "Run `armdrive home`."


def test_every_action_is_offered_by_every_interface():
    for action in ACTIONS:
        assert action.command_line.split()[1] in COMMANDS
        assert action.shell in {*OWN_WORDS, *WORDS}
        assert DEFAULT_KEYS.label(action.desk.strip("{}"))
    typed = " ".join(f"{each.command_line} {each.shell} {each.desk}" for each in PHRASES)
    assert set(re.findall(r"`armdrive ([a-z]+)", typed)) <= set(COMMANDS)


@functools.cache
def literals(path: Path) -> list[str]:
    """Return the strings of a file that are no docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    docs = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    strings = (node for node in ast.walk(tree) if isinstance(node, ast.Constant))
    return [node.value for node in strings if isinstance(node.value, str) and id(node) not in docs]


@pytest.mark.parametrize("package", [armdrive, tui], ids=lambda each: each.__name__)
def test_no_sentence_names_a_call_that_has_no_row(package):
    root = Path(package.__path__[0])
    named = [
        f"{path}: {text!r}"
        for path in root.rglob("*.py")
        if not path.relative_to(root).as_posix().startswith(NO_SENTENCES)
        for text in literals(path)
        if " " in text
        and ("(" in text or "=" in text)  # one word is code: a key's action
        and PYTHON.search(presented(text, COMMAND_LINE))
    ]
    assert not named, "\n".join(named)


def test_no_sentence_of_an_arm_sends_a_person_at_the_desk_to_the_command_line():
    """A desk holds its arm, so a command of another terminal could not do what a key does."""
    commands = [f"`{action.command_line}`" for action in ACTIONS]
    root = Path(armdrive.__path__[0])
    named = [
        f"{path}: {text!r}"
        for part in ("arm", "connect", "dialects", "dialog", "motion", "runtime")
        for path in (root / part).rglob("*.py")
        for text in literals(path)
        if any(command in text for command in commands)
    ]
    assert not named, "\n".join(named)


def test_a_command_that_may_be_refused_for_a_restored_position_can_allow_it(call):
    for command in ("move", "run", "shell", "verify", "demo", "disable"):
        assert "--allow-restored" in call(command, "--help", code=0).out


def test_reset_says_how_the_arm_is_then(call):
    assert "reset: state standby" in call("reset", code=0).out
    assert call("reset", "--json", code=0).json["state"] == "standby"
