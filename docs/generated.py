"""Fill the generated parts of the pages from the program: `python docs/generated.py`.

A part stands between `<!-- NAME -->` and `<!-- end of NAME -->`. The pages on errors,
on the keys of an arm file and on the Python calls are generated as a whole.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import astuple
from pathlib import Path
from types import MappingProxyType

import arm_file_keys
import errors_page
import reference

from armdrive.cli.commands import EXIT_CODES, ROWS
from armdrive.cli.runner import command_parser
from armdrive.config.write import complete
from armdrive.programs.language import words as language
from armdrive.programs.shell import OWN_WORDS
from armdrive.registry import DIALECTS
from armdrive.registry.arm_files import parse_arm
from armdrive.sim.cia402.quirks import Cia402Quirks
from armdrive.sim.device import settings_of
from armdrive.sim.mks.quirks import MksQuirks
from armdrive.status import Evidence
from armdrive.text.toml import rule_of
from armdrive.trace.entries import EntryKind
from kinematics.spaces import POSE_FIELDS
from tui.keys.keyboard import DEFAULT_KEYS, as_rows
from tui.keys.table import SCREENS
from tui.settings import LOOKS

DOCS = Path(__file__).parent
MARK = re.compile(r"<!-- ([a-z ]+) -->\n(.*?)<!-- end of \1 -->", re.DOTALL)

WHOLE: Mapping[Path, Callable[[], str]] = MappingProxyType(
    {
        errors_page.PAGE: errors_page.page,
        arm_file_keys.PAGE: arm_file_keys.page,
        reference.PAGE: reference.page,
        reference.SCHEMA: reference.schema,
    }
)
"""Files that are generated from their first line to their last."""


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> Iterator[str]:
    """Yield the lines of a Markdown table."""
    titles = list(head)
    yield f"| {' | '.join(titles)} |"
    yield "|---" * len(titles) + "|"
    for row in rows:
        yield f"| {' | '.join(row)} |"


def _torque() -> Iterator[str]:
    head = ("controller", "after `disable`", "after `estop`", "without power", "port closed")
    return _table(head, ((row.title, *astuple(row.torque)) for row in DIALECTS.values()))


def _settings(kind: type) -> Iterator[str]:
    """Yield the settings of a simulated drive that are no quirks."""
    rows = (
        (f"`{name}`", _plain(each.default), rule_of(each).help)
        for name, each in settings_of(kind).items()
        if not rule_of(each).source
    )
    return _table(("setting", "default", "meaning"), rows)


def _quirks(kind: type) -> Iterator[str]:
    rows = []
    for name, each in settings_of(kind).items():
        rule = rule_of(each)
        if rule.source:
            words = f" ({', '.join(rule.words)})" if rule.words else ""
            source = re.sub("^guess:", "**guess**:", rule.source)
            rows.append((f"`{name}`", _plain(each.default), rule.help + words, source))
    return _table(("quirk", "default", "what drives do", "source"), rows)


def _plain(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)


SHOWN_ARM = """
model = "teachmover"
backlash_mm = 0.2
[connection]
dialect = "teachmover"
port = "/dev/ttyUSB0"
[park]
x_mm = 127.0
y_mm = 0.0
z_mm = 30.0
pitch_deg = -90.0
[tool]
along_mm = 60.0
[frames.board]
x_mm = 200.0
y_mm = 50.0
z_mm = 0.0
yaw_deg = 30.0
pitch_deg = 0.0
roll_deg = 0.0
[backlash_deg]
base = 0.6
[accelerations_deg_s2]
base = 200.0
[motor_signs]
base = 1
[joint_signs]
base = 1
wrist_roll = 1
"""
"""An arm file that has every section, some with one key for all."""

MANY_DIGITS = re.compile(r"\b\d+\.\d{5,}\b")


def _arm_file() -> Iterator[str]:
    table = tomllib.loads(SHOWN_ARM)
    text = complete(parse_arm(table, name="bench"), table)
    yield "```toml"
    for line in MANY_DIGITS.sub(lambda found: f"{float(found[0]):.6g}", text).splitlines():
        entry, sign, meaning = line.partition(" # ")
        yield f"{entry.rstrip():<29}{sign}{meaning}" if sign else entry
    yield "```"


def _keys() -> Iterator[str]:
    yield "| id | keys | on screen | does |"
    yield "|---|---|---|---|"
    for row in as_rows(DEFAULT_KEYS):
        keys = " ".join(f"`{key}`" for key in row["keys"])
        yield f"| `{row['id']}` | {keys} | {row['screen']} | {row['does']} |"


def _program_words() -> Iterator[str]:
    """Yield every word, form of a line and function of programs, in a section for each kind."""
    for title, words in language.GROUPS.items():
        rows = (
            (
                f"`{language.usage(word)}`",
                word.says,
                f"`{word.example}`",
                ", ".join(f"`{each.upper()}`" for each in word.old),
            )
            for word in words
        )
        head = ("word", "what it does", "example", "old spelling")
        yield from (f"### {title}", "", *_table(head, rows), "")
    forms = ((f"`{row.pattern}`", row.says) for row in language.FORMS)
    lines = _table(("line", "what it does"), forms)
    yield from ("### Lines that shape a program", "", *lines, "")
    yield from ("### Values", "", *_table(("value", "what it is", "example"), _functions()))


def _functions() -> Iterator[tuple[str, str, str]]:
    for row in language.FUNCTIONS.values():
        called = f"`{row.name}({language.values_form(row.slots)})`"
        yield called, row.says, f"`{row.example}`"
    yield (
        "`joints(NAME ANGLE, ...)`",
        "The place with these joint angles, deg; every joint of the arm is named.",
        "`joints(base 0, shoulder 40, elbow -60, wrist_pitch -70, wrist_roll 0)`",
    )
    yield "`here`", "The place where the arm stands.", "`above(here, 20)`"
    parts = ", ".join(f"`.{name}`" for name in POSE_FIELDS)
    yield parts, "The parts of a place, mm and deg.", "`pick.z`"


def _sentence(command: str, function: str) -> str:
    """Return what a command does, as its help begins."""
    sentence = str(command_parser(command, function).description)
    return sentence[0].lower() + sentence[1:].removesuffix(".")


PARTS: Mapping[str, Callable[[], Iterable[str]]] = MappingProxyType(
    {
        "commands": lambda: _table(
            ("command", "does"),
            ((f"`armdrive {name}`", _sentence(name, at)) for name, (at, _) in ROWS.items()),
        ),
        "exit codes": lambda: _table(
            ("code", "meaning"), ((str(code), text) for code, text in EXIT_CODES.items())
        ),
        "screens": lambda: _table(
            ("key", "screen", "purpose"),
            ((f"`{each.key}`", each.title, each.summary) for each in SCREENS),
        ),
        "looks": lambda: _table(
            ("look", ""), ((name, summary) for name, (_, summary) in LOOKS.items())
        ),
        "keys": _keys,
        "words": _program_words,
        "shell words": lambda: _table(
            ("word", "what it does"), ((f"`{row.pattern}`", row.says) for row in OWN_WORDS.values())
        ),
        "evidence": lambda: _table(
            ("observation", "position afterwards"),
            ((evidence.value, evidence.trust.value) for evidence in Evidence),
        ),
        "torque": _torque,
        "arm file": _arm_file,
        "mks settings": lambda: _settings(MksQuirks),
        "mks quirks": lambda: _quirks(MksQuirks),
        "drive settings": lambda: _settings(Cia402Quirks),
        "drive quirks": lambda: _quirks(Cia402Quirks),
        "kinds": lambda: _table(
            ("kind", "meaning"), ((f"`{kind.value}`", kind.meaning) for kind in EntryKind)
        ),
    }
)
"""The lines of each generated part."""


def filled(text: str) -> str:
    """Return a page with its generated parts as the program has them."""

    def part(found: re.Match[str]) -> str:
        lines = "".join(f"{line}\n" for line in PARTS[found[1]]())
        return f"<!-- {found[1]} -->\n{lines}<!-- end of {found[1]} -->"

    return MARK.sub(part, text)


def files() -> Iterator[tuple[Path, str]]:
    """Yield every file with a generated part, and its text as it should be."""
    for path, whole in WHOLE.items():
        yield path, whole()
    for path in sorted(DOCS.rglob("*.md")):
        text = path.read_text(encoding="utf-8")
        if path not in WHOLE and MARK.search(text):
            yield path, filled(text)


if __name__ == "__main__":
    for path, text in files():
        path.write_text(text, encoding="utf-8")
