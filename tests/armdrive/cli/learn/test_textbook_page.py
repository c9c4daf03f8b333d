"""The pages of the textbook name only functions that exist and commands that work."""

import importlib
import re

import pytest
from amounts import every_row
from cli_calls import Caller
from pages import page

from kinematics.textbook import systems
from kinematics.textbook.systems import SYSTEMS, System

PAGE = page("textbook")
NOTES = page("notes")
PROSE = re.sub(r"^```.*?^```$", "", PAGE + NOTES, flags=re.DOTALL | re.MULTILINE)
SPANS = sorted({" ".join(span.split()) for span in re.findall(r"`([^`]+)`", PROSE)})

NAMES = [span for span in SPANS if re.fullmatch(r"(kinematics|armdrive)(\.\w+)+", span)]
PLACEHOLDERS = ("SYSTEM", "FILE")
COMMANDS = [
    span
    for span in SPANS
    if span.startswith("armdrive ")
    and not any(word in span for word in PLACEHOLDERS)
    and span != "armdrive plot"
    and "jog" not in span  # needs a terminal
]


@every_row("name", NAMES)
def test_a_name_leads_to_something(name):
    *path, last = name.split(".")
    found = importlib.import_module(path[0])
    for part in path[1:]:
        try:
            found = getattr(found, part)
        except AttributeError:
            found = importlib.import_module(f"{found.__name__}.{part}")
    assert getattr(found, last) is not None


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_works(command, capsys):
    called = Caller(capsys)(*command.split()[1:], code=0)
    assert called.out


def test_every_named_system_is_on_the_page():
    called = {one.name: name for name, one in vars(systems).items() if isinstance(one, System)}
    for name, system in SYSTEMS.items():
        assert f"`armdrive explain {name}" in PAGE, name
        assert f"`kinematics.textbook.systems.{called[system.name]}`" in PAGE, name


def numbers(pattern, last):
    """Return the numbers that the page names alone or as ends of a span, of 1 to `last`."""
    found = set()
    for first, end in re.findall(pattern, NOTES):
        found |= set(range(int(first), int(end or first) + 1))
    return sorted(found & set(range(1, last + 1)))


@every_row(
    "pattern, last",
    [
        (r"\(2\.(\d+)\)(?: to \(2\.(\d+)\))?", 48),
        (r"(?:figures? |, )2\.(\d+)()", 20),
        (r"Exercises (\d+) to (\d+)", 11),
        (r"^\| (\d+) ()", 16),
        (r"^\| \d+ Link types (\d+) to (\d+)", 8),
    ],
)
def test_every_item_of_the_notes_is_on_their_page(pattern, last):
    assert numbers(f"(?m){pattern}", last) == list(range(1, last + 1))


def test_every_section_of_the_notes_is_on_the_page():
    for section in range(1, 17):
        assert re.search(rf"^\| {section} ", PAGE, re.MULTILINE), section
    for section in ("2.1", "2.2", "2.3", "2.4", "2.5", "2.5.2", "2.6"):
        assert f"| {section} " in PAGE
