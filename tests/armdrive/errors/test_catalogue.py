"""The catalogue of errors: every kind has a row, no code stands twice, everybody is shown it."""

import ast
import copy
import functools
import importlib
import json
import pickle
import pkgutil
import re
import signal
import traceback
from itertools import product
from pathlib import Path

import pytest

import armdrive
import firmware_protocol
import kinematics
import tui
from armdrive import Arm
from armdrive.cli.runner import CommandEnded
from armdrive.errors import ArmError, NoSuchPort, NotReferenced, WrongState
from armdrive.errors.actions import ACTIONS, COMMAND_LINE, PHRASES, SHELL, desk_words, presented
from armdrive.errors.table import ENTRIES, entry, entry_of
from armdrive.runtime.states import TRANSITIONS, Belief, Event, after, require_reference
from armdrive.status import Evidence, State, Trust
from firmware_protocol.errors import ProtocolError
from kinematics.errors import KinematicsError, remade
from tui.keys.keyboard import DEFAULT_KEYS

NAMES = {row.name for row in ENTRIES}
NO_ERRORS = {
    "OSError", "KeyboardInterrupt", "CommandEnded", "Unexpected",
    "EMERGENCY_STOP", "RECONNECTED", "ALARM_VOUCHED", "LOCKED",
}  # fmt: skip
"""Rows of what is neither an error of ours nor evidence."""


def kinds() -> set[type]:
    """Return every public class of errors of the three rooms, in whichever file it stands."""
    for room in (armdrive, kinematics, firmware_protocol):
        for found in pkgutil.walk_packages(room.__path__, f"{room.__name__}."):
            if not found.name.startswith("armdrive.cli") and not found.name.endswith("__main__"):
                importlib.import_module(found.name)
    found = {kind for root in (ArmError, KinematicsError, ProtocolError) for kind in below(root)}
    return {kind for kind in found if not kind.__name__.startswith("_")}


def below(kind: type) -> set[type]:
    """Return a class and all that are made from it, without those of tests."""
    found = {each for sub in kind.__subclasses__() for each in below(sub)}
    return {each for each in found | {kind} if each.__module__.split(".")[0] in ROOMS}


ROOMS = ("armdrive", "kinematics", "firmware_protocol")


def test_every_error_can_be_copied_and_sent_to_another_process():
    """Without this, a pool of processes waits for ever for the result of a worker that raised."""
    for kind in below(ArmError) | below(KinematicsError):
        error = remade(kind, ("what is wrong",), {"nearest": 3.0})
        error.add_note("by whom")
        for again in (pickle.loads(pickle.dumps(error)), copy.copy(error), copy.deepcopy(error)):
            assert (type(again), again.args, vars(again)) == (kind, error.args, vars(error))


def test_a_traceback_ends_with_the_code_the_effect_on_the_arm_and_the_remedy():
    with Arm.connect("sim:teachmover") as arm, pytest.raises(NotReferenced) as refusal:
        arm.move_j(base_deg=20)
    *_, message, advice = traceback.format_exception(refusal.value)
    assert message.startswith("armdrive.errors.NotReferenced: planned motion needs")
    assert advice.startswith("[E203] Nothing was sent, nothing moved. Look at the arm, then call")
    refusal.value.add_note("in the second loop")
    assert traceback.format_exception(refusal.value)[-1] == "in the second loop\n"


def test_every_error_of_armdrive_has_the_code_of_its_row():
    codes = {row.name: row.code for row in ENTRIES}
    for kind in below(ArmError):
        assert vars(kind)["code"] == codes[kind.__name__], kind


def test_every_evidence_against_a_position_has_a_row():
    for evidence in Evidence:
        assert (entry_of(evidence) is None) == (evidence.trust is Trust.REFERENCED), evidence


def test_every_kind_of_error_has_a_row_and_no_row_is_left_over():
    errors = {kind.__name__ for kind in kinds()}
    assert errors <= NAMES
    assert errors | {each.name for each in Evidence} | NO_ERRORS >= NAMES


def test_every_row_says_everything():
    for row in ENTRIES:
        assert not row.title.endswith("."), row
        for text in (row.cause, row.effect, row.remedy):
            assert text.rstrip("*").endswith("."), row
            assert "|" not in text, row


def test_an_error_is_found_by_its_own_class_or_the_nearest():
    class Stranger(WrongState):
        """An error of somebody's own."""

    assert entry(NoSuchPort("gone")).name == "NoSuchPort"
    assert Stranger("no").code == WrongState("no").code == entry(WrongState("no")).code
    assert entry(FileNotFoundError("x")).name == "OSError"
    assert entry(ZeroDivisionError("x")).name == "ArmError"
    assert entry(CommandEnded(signal.SIGTERM)).code == "E004"


def test_the_command_looks_errors_up_by_their_codes(call):
    text = call("errors", "[e407]", code=0).out
    assert text.startswith("E407: the connection was lost (LinkLost)")
    assert "`armdrive reset`" in text
    assert "did you mean E407?" in call.refused("errors", "E4077", code=2)
    assert "E999" in call.refused("errors", "E999", code=2)
    listed = call("errors", code=0).out
    assert all(row.code in listed for row in ENTRIES)
    lines = call("errors", "--json", code=0).json_lines
    assert [each["code"] for each in lines] == [row.code for row in ENTRIES]


def test_the_command_line_says_the_code_and_with_json_the_whole(call):
    sentence = call.refused("move", "--x", "250", code=3)
    assert sentence.startswith("armdrive: [E203] ")
    called = call("move", "--x", "250", "--json", code=3)
    assert called.out == ""
    told = json.loads(called.err)
    assert set(told) == {"code", "title", "message", "effect", "remedy"}
    assert told["code"] == "E203"
    assert told["message"] in sentence
    far = ("ik", "--x", "900", "--y", "0", "--z", "1", "--pitch", "0")  # of the mathematics
    assert "[E604] " in call.refused(*far, code=3)


def test_the_status_carries_the_codes_with_their_words():
    with Arm.connect("sim:teachmover") as arm:
        assert arm.status.trust_code == entry_of(Evidence.NO_RECORD).code
        arm.home()
        assert arm.status.trust_code == ""
        arm.estop()
        arm.sleep(0.5)
        assert arm.status.error_code == "E303"
        assert "error     [E303] emergency stop" in str(arm.status)
        with pytest.raises(WrongState):
            arm.move_j(shoulder_deg=40)
        arm.reset()
        assert arm.status.error_code == ""
        arm.parts.core.notify("somebody moved it", Evidence.MOVED_BY_OTHERS)
        assert arm.status.notice_code == entry_of(Evidence.MOVED_BY_OTHERS).code
        arm.parts.core.notify("all is well")
        assert arm.status.notice_code == ""


# What an error asks a person to do stands in the words of the interface that shows it.


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


def refusals() -> list[str]:
    """Return what is said of transitions that there are not, and of motion without trust."""
    said = []
    for state, event in product(State, Event):
        if (state, event) not in TRANSITIONS:
            with pytest.raises(WrongState) as refused:
                after(state, event)
            said.append(str(refused.value))
    for trust in set(Trust) - {Trust.REFERENCED}:
        with pytest.raises(ArmError) as distrusted:
            require_reference(Belief(trust, "for a reason"), allow_restored=False)
        said.append(str(distrusted.value))
    return said


SENTENCES = (
    *(text for row in ENTRIES for text in (row.cause, row.effect, row.remedy)),
    *refusals(),
    *(each.python for each in PHRASES),
)


SAID = {
    "command line": "Look at the arm, run `armdrive reset`, then `armdrive home`.",
    "shell": "Look at the arm, type `reset`, then `home`.",
    "desk": "Look at the arm, press R, then H.",
}


@pytest.mark.parametrize("interface", INTERFACES)
def test_each_interface_has_its_own_words_and_none_speaks_python_to_a_person(interface):
    words = INTERFACES[interface]
    assert presented("Look at the arm, call `reset()`, then `home()`.", words) == SAID[interface]
    assert presented("Call `home()`.", COMMAND_LINE) == "Run `armdrive home`."
    for phrase in PHRASES:  # one whose beginning is an action of its own stays whole
        assert presented(phrase.python, SHELL) == phrase.shell
    for sentence in SENTENCES:
        shown = presented(sentence, words)
        assert not PYTHON.search(shown), shown
        assert presented(shown, words) == shown


@functools.cache
def literals(path: Path) -> list[str]:
    """Return the strings of a file that are no docstrings."""
    nodes = [*ast.walk(ast.parse(path.read_text(encoding="utf-8")))]
    docs = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    strings = (node for node in nodes if isinstance(node, ast.Constant))
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
