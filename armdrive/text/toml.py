"""The schema of a file that people write as TOML: how its tables are read and checked.

A section of a file is a frozen dataclass. Its fields are the keys, each with its type and default
and, where `setting` makes the field, with its bounds and with what it means: the same line checks
a key, writes it and documents it. Tables that hold one value for each joint or motor, and arrays
of tables, are read by `TomlTable`.

What programs write as JSON is read the same way: `plain` makes plain data of a section, whose
fields may also be enums and other sections, and `section_of` reads it again.

Reading goes on past a fault as if the key at fault were not there, and notes the fault in
`Problems`: one reading finds everything that is wrong.
"""

from __future__ import annotations

import functools
import json
import math
import re
import types
import typing
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, Field, dataclass, field, fields, is_dataclass
from enum import Enum
from typing import Any, TypeAlias, TypeVar

from armdrive.errors import ArmFileError, BadRequest
from armdrive.text.reading import Failure
from kinematics.errors import BadNumber, KinematicsError, did_you_mean, finite
from kinematics.limits import JointRange
from kinematics.text import counted, filled

S = TypeVar("S")
D = TypeVar("D")

# Reads one value; the text says where it stands, for the error. Raises `ArmFileError`.
Read: TypeAlias = Callable[[object, str], S]

# A file with more problems is not a damaged arm file but something else.
MOST_PROBLEMS = 50


class Problems:
    """The problems of a file: sentences in the order in which they were found.

    `count` includes those that were not kept because there were too many.
    """

    def __init__(self) -> None:
        self.found: list[str] = []
        self.count = 0

    @property
    def room(self) -> int:
        """How many more sentences can be kept."""
        return MOST_PROBLEMS - len(self.found)

    def note(self, sentence: str) -> None:
        """Add a sentence, unless it is there: some tables are read twice."""
        self.count += 1
        if self.room and sentence not in self.found:
            self.found.append(sentence)

    def attempt(self, read: Callable[[], S], otherwise: D) -> S | D:
        """Return what `read` returns; where it raises, note why and return the other value."""
        try:
            return read()
        except (ArmFileError, BadRequest, KinematicsError) as error:
            self.note(str(error))
            return otherwise

    def required(self, found: S | None) -> S:
        """Return what was read, or raise `ArmFileError` for the first problem."""
        if self.found or found is None:
            raise ArmFileError(self.found[0])
        return found


# The keys of a section, as fields of a dataclass.


@dataclass(frozen=True, slots=True)
class Rule:
    """What a key of a section may be, and what it means."""

    low: float = -math.inf
    high: float = math.inf
    words: tuple[Any, ...] = ()
    hint: str = ""
    help: str = ""
    source: str = ""

    def check(self, value: object, where: str) -> None:
        """Raise `ArmFileError` for a value that the key cannot have; None is always allowed.

        Of a list, every entry is checked.
        """
        if isinstance(value, tuple):
            for index, entry in enumerate(value):
                self.check(entry, f"{where}[{index}]")
        elif self.words and value not in self.words:
            words = ", ".join(map(str, self.words))
            raise ArmFileError(f"{where} is one of {words}, not {value!r:.80}")
        elif isinstance(value, int | float):
            within(where, value, self.low, self.high, self.hint)


_RULE = "rule"
_NO_RULE = Rule()


def setting(
    default: Any = MISSING,
    means: str = "",
    *,
    low: float = -math.inf,
    high: float = math.inf,
    words: tuple[Any, ...] = (),
    source: str = "",
) -> Any:
    """Declare a key of a section: what it means, its bounds or choices, and who has observed it."""
    rule = Rule(low, high, words, help=means, source=source)
    return field(default=default, metadata={_RULE: rule})


def rule_of(key: Field[Any]) -> Rule:
    """Return what a key may be and what it means."""
    rule: Rule = key.metadata.get(_RULE, _NO_RULE)
    return rule


def check_settings(section: Any, where: str) -> None:
    """Raise `ArmFileError` for the first key of a section that is out of its bounds."""
    for each in fields(section):
        rule_of(each).check(getattr(section, each.name), f"{where}.{each.name}")


# A table while it is read.


@dataclass(frozen=True, slots=True)
class TomlTable:
    """One table of a file, where it stands in it, and where faults are noted."""

    entries: Mapping[str, Any]
    where: str
    problems: Problems

    def at(self, key: str) -> str:
        """Return where a key of this table stands."""
        return f"{self.where}.{key}" if self.where else key

    def allow(self, known: Iterable[str]) -> None:
        """Note every unknown key, with the nearest known one."""
        known = list(known)
        unknown = [key for key in self.entries if key not in known]
        for key in unknown[: self.problems.room]:  # to find the nearest key takes time
            place = f"in [{self.where}]" if self.where else "at the top"
            hint = did_you_mean(key, known, f"known are {', '.join(known) or 'none'}")
            self.problems.note(f"unknown key {key!r} {place}; {hint}")

    def value(self, key: str, read: Read[S], default: D) -> S | D:
        """Read the value of a key; the default is returned where it is missing or wrong."""
        if key not in self.entries:
            return default
        return self.problems.attempt(lambda: read(self.entries[key], self.at(key)), default)

    def required(self, key: str, read: Read[S]) -> S | None:
        """Read the value of a key that must be there: `read` refuses None by its own sentence."""
        return self.problems.attempt(lambda: read(self.entries.get(key), self.at(key)), None)

    def table(self, key: str) -> TomlTable:
        """Return a table in this table, which is empty where it is missing or no table."""
        return TomlTable(self.value(key, require_table, {}), self.at(key), self.problems)

    def rows(self, key: str) -> list[TomlTable]:
        """Return the tables of an array `[[key]]`, without those that are no tables."""
        where = self.at(key)
        listed = self.value(key, lambda rows, _: require_list(rows, where, f"[[{where}]]"), [])
        tables = []
        for index, row in enumerate(listed, 1):
            at = f"{where}[{index}]"
            inside = self.problems.attempt(functools.partial(require_table, row, at), None)
            if inside is not None:
                tables.append(TomlTable(inside, at, self.problems))
        return tables

    def by_name(
        self, key: str, names: Iterable[str], read: Read[S], *, all_since: str | None = None
    ) -> dict[str, S]:
        """Read a table that has a value for some of these names, as those of joints or motors.

        With `all_since` each name must be there; the text says why, after the names that are not.
        """
        table = self.table(key)
        names = list(names)
        table.allow(names)
        missing = [name for name in names if name not in table.entries]
        if missing and all_since is not None:
            self.problems.note(f"[{table.where}] is missing {', '.join(missing)}{all_since}")
        found = {name: table.value(name, read, None) for name in names}
        return {name: value for name, value in found.items() if value is not None}

    def section(
        self,
        kind: type[S],
        own: Mapping[str, Any] | None = None,
        elsewhere: Iterable[str] = (),
        *,
        whole: bool = False,
    ) -> S | None:
        """Read this table as a section; return None if its problems leave none.

        `own` are values in the place of the section's defaults. The keys `elsewhere` are known
        too, and are read by the caller. Of a `whole` section only keys that default to None may be
        missing.
        """
        keys, needed = _keys_of(typing.cast(typing.Hashable, kind), whole)
        self.allow([*keys, *elsewhere])
        given = {
            name: self.value(name, read, MISSING)
            for name, read in keys.items()
            if name in self.entries
        }
        values = dict(own or {})
        values |= {name: each for name, each in given.items() if each is not MISSING}
        missing = [name for name in needed if name not in {*values, *given}]
        if missing:
            name = f"[{self.where}]" if self.where else "it"
            self.problems.note(f"{name} is missing {', '.join(missing)}")
        if not values.keys() >= set(needed):
            return None
        # A section may check its keys against one another. The key at fault is the one without
        # which the complaint is another one, or none.
        section, complaint = _made(kind, values)
        while complaint:
            named = self.where in complaint
            self.problems.note(complaint if named else f"{self.where}: {complaint}")
            others = [
                {k: v for k, v in values.items() if k != key} for key in values if key not in needed
            ]
            better = [each for each in others if _made(kind, each)[1] != complaint]
            if not better:
                return None
            values = better[0]
            section, complaint = _made(kind, values)
        return section


def section_of(kind: type[S], data: object, where: str = "", *, whole: bool = True) -> S:
    """Return plain data as a section. Raises `ArmFileError` for the first problem."""
    problems = Problems()
    table = TomlTable(require_table(data, where), where, problems)
    return problems.required(table.section(kind, whole=whole))


def plain(value: Any) -> Any:
    """Return what `section_of` reads: a section as a table, an enum's member as its value."""
    if is_dataclass(value):
        return {each.name: plain(getattr(value, each.name)) for each in fields(value)}
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, Mapping):
        return {str(name): plain(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    return value


@functools.cache
def _keys_of(kind: type[Any], whole: bool) -> tuple[Mapping[str, Read[Any]], tuple[str, ...]]:
    """Return what reads each key of a section, and the keys that it needs."""
    hints = typing.get_type_hints(kind)
    keys = {each.name: checked(hints[each.name], rule_of(each)) for each in fields(kind)}
    optional = [each for each in fields(kind) if each.default is not MISSING]
    if whole:
        optional = [each for each in optional if each.default is None]
    return keys, tuple(each.name for each in fields(kind) if each not in optional)


def _made(kind: type[S], values: Mapping[str, Any]) -> tuple[S | None, str]:
    """Return a section with these values, or what it says against them."""
    try:
        return kind(**values), ""
    except (ArmFileError, BadRequest, KinematicsError) as error:
        return None, str(error)


# Single values.


def require_table(table: object, where: str) -> Mapping[str, Any]:
    """Return the table, or say that something else stands there."""
    if not isinstance(table, Mapping):
        place = f"{where} must be a table, written [{where}]" if where else "it must be a table"
        raise ArmFileError(f"{place}, not {table!r:.80}")
    return table


def require_list(value: object, where: str, example: str) -> list[Any]:
    """Return the list, or say that something else stands there."""
    if not isinstance(value, list):
        raise ArmFileError(f"{where} must be a list, written for example {example}, not {value!r}")
    return value


def checked(wanted: Any, rule: Rule) -> Read[Any]:
    """Return what reads a value of an annotated type and applies the rule of its key."""

    def read(value: object, where: str) -> Any:
        read_value = _convert(wanted, value, where)
        rule.check(read_value, where)
        return read_value

    return read


def _convert(wanted: Any, value: object, where: str) -> Any:
    """Check one value against its annotation; whole numbers are fine where floats belong."""
    origin, inner = typing.get_origin(wanted), typing.get_args(wanted)
    if origin in (types.UnionType, typing.Union):
        if value is None and types.NoneType in inner:  # never in TOML, but a null in JSON
            return None
        kinds = [one for one in inner if one is not type(None)]
        plain = isinstance(value, int | float) and not isinstance(value, bool)
        return _convert(float if plain and float in kinds else kinds[0], value, where)
    if origin is tuple:
        return _convert_tuple(inner, value, where)
    if origin in (Mapping, dict):
        table = require_table(value, where)
        return {
            _name(inner[0], name, where): _convert(inner[1], one, f"{where}.{name}")
            for name, one in table.items()
        }
    if wanted is float:
        return number(value, where)
    if wanted is int and type(value) is int:
        number(value, where)  # TOML allows more digits than any number here can have
        return value
    if wanted is object or (wanted in (str, bool) and type(value) is wanted):
        return value
    if isinstance(wanted, type) and is_dataclass(wanted):
        return section_of(wanted, value, where)
    if isinstance(wanted, type) and issubclass(wanted, Enum):
        return _member(wanted, value, where)
    raise ArmFileError(f"{where} must be {_WORDS.get(wanted, wanted)}, not {value!r:.80}")


def _name(wanted: Any, name: str, where: str) -> Any:
    """Return a key of a table that has no fixed keys: text, or a number up to nine digits."""
    if wanted is str:
        return name
    if not re.fullmatch(r"[0-9]{1,9}", name):
        raise ArmFileError(f"the keys of {where} are whole numbers, not {name!r:.80}")
    return int(name)


def _member(wanted: type[Enum], value: object, where: str) -> Enum:
    for member in wanted:
        if type(value) is type(member.value) and value == member.value:
            return member
    words = ", ".join(str(member.value) for member in wanted)
    raise ArmFileError(f"{where} is one of {words}, not {value!r:.80}")


def _convert_tuple(inner: tuple[Any, ...], value: object, where: str) -> tuple[Any, ...]:
    if not isinstance(value, list | tuple):
        raise ArmFileError(f"{where} must be a list, not {value!r:.80}")
    if len(inner) == 2 and inner[1] is Ellipsis:
        inner = (inner[0],) * len(value)
    if len(value) != len(inner):
        entries = counted(len(inner), "entry", "entries")
        raise ArmFileError(f"{where} must have {entries}, not {len(value)}")
    return tuple(
        _convert(kind, item, f"{where}[{i}]")
        for i, (kind, item) in enumerate(zip(inner, value, strict=True))
    )


def text(value: object, where: str) -> str:
    """Return text."""
    return str(_convert(str, value, where))


def whole(value: object, where: str) -> int:
    """Return a whole number."""
    return int(_convert(int, value, where))


def named(value: object, where: str) -> str:
    """Return the name of a row of an array."""
    if not isinstance(value, str) or not value:
        raise ArmFileError(f'{where.removesuffix(".name")} needs a name, for example name = "base"')
    return value


def number(value: object, where: str) -> float:
    """Return a finite number, or raise `ArmFileError` that names the key."""
    try:
        return finite(where, value)
    except BadNumber as error:
        raise ArmFileError(str(error)) from None


def within(where: str, value: float, low: float, high: float, hint: str = "") -> None:
    """Raise `ArmFileError` for a number out of its bounds."""
    if not low <= value <= high:
        why = f": {hint}" if hint else ""
        span = f"from {low:.12g} to {high:.12g}" if math.isfinite(high) else f"at least {low:.12g}"
        raise ArmFileError(f"{where} must be {span}, not {value:.12g}{why}")


def between(low: float, high: float, hint: str = "") -> Read[float]:
    """Return what reads a number between these bounds, both included."""
    return checked(float, Rule(low, high, hint=hint))


def joint_range(value: object, where: str) -> JointRange:
    """Return a range of the file, a pair of degrees."""
    if not isinstance(value, list) or len(value) != 2:
        raise ArmFileError(f"{where} must be a pair of degrees, for example [-90, 90]")
    low, high = (number(one, where) for one in value)
    if low >= high:
        raise ArmFileError(f"{where}: the first number must be below the second")
    return JointRange(math.radians(low), math.radians(high))


_WORDS: Mapping[Any, str] = types.MappingProxyType(
    {int: "a whole number", str: "text", bool: "true or false"}
)


# The version of a file that people keep: an arm file, a model file, a file of points.

FORMAT_KEY = "format"
# The format that this armdrive reads and writes. Files from before the key existed have it too.
FORMAT = 1


def require_format(table: Mapping[str, Any], failure: Failure = ArmFileError) -> None:
    """Raise the error that `failure` makes unless this armdrive knows the format of a file.

    Call this before reading any other key: in another format, the same key may mean something else.
    """
    given = table.get(FORMAT_KEY, FORMAT)
    if type(given) is not int or given < FORMAT:  # neither true nor 1.0 is a whole number here
        raise failure(f"{FORMAT_KEY}: expected the whole number {FORMAT}, got {given!r:.40}")
    if given > FORMAT:
        raise failure(
            f"{FORMAT_KEY} {given} is newer than this armdrive reads ({FORMAT}). Update armdrive."
        )


# Values as TOML.

_BARE = r"[A-Za-z0-9_-]+"


def key(name: str) -> str:
    """Return a key, quoted where it is no single word."""
    return name if re.fullmatch(_BARE, name) else value(name)


def value(given: Any) -> str:
    """Return a value as TOML: text, numbers, true and false, lists, inline tables."""
    if isinstance(given, bool):
        return "true" if given else "false"
    if isinstance(given, str):
        return json.dumps(given, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(given, float):
        return _float(given)
    if isinstance(given, Mapping):
        inside = ", ".join(f"{key(name)} = {value(one)}" for name, one in given.items())
        return f"{{ {inside} }}"
    if isinstance(given, list | tuple):
        return f"[{', '.join(map(value, given))}]"
    return str(given)


def _float(given: float) -> str:
    """Return the shortest text that reads back as the same number."""
    if given == int(given) and abs(given) < 1e15:
        return str(int(given))
    return repr(given)


# A document for people: sections whose lines carry comments.
#
# Plain text is written rather than a document edited, which would need a further library.

# The column that comments begin in, where the line before them is shorter.
COMMENT_AT = 30

# The longest line of a heading.
WIDTH = 96


@dataclass(frozen=True, slots=True)
class TomlEntry:
    """One key with its value, and what a reader should know of it."""

    key: str
    value: Any
    comment: str = ""


# The first key of every file that armdrive writes for people.
FORMAT_ENTRY = TomlEntry(FORMAT_KEY, FORMAT)


@dataclass(frozen=True, slots=True)
class TomlSection:
    """A table of a document; the first one has no name, and one of an array says so."""

    name: str
    entries: tuple[TomlEntry, ...]
    comment: str = ""
    array: bool = field(default=False)


def document(sections: Iterable[TomlSection], heading: str = "") -> str:
    """Return the text of a document, one line at the end."""
    lines = [each for line in heading.splitlines() for each in filled(line, WIDTH)]
    blocks = ["\n".join(f"# {line}" for line in lines)] if lines else []
    blocks += [_section(each) for each in sections if each.entries]
    return "\n\n".join(blocks) + "\n"


def _section(section: TomlSection) -> str:
    lines = []
    if section.name:
        brackets = f"[[{section.name}]]" if section.array else f"[{section.name}]"
        lines.append(_commented(brackets, section.comment))
    lines += [
        _commented(f"{key(each.key)} = {value(each.value)}", each.comment)
        for each in section.entries
    ]
    return "\n".join(lines)


def _commented(line: str, comment: str) -> str:
    return f"{line.ljust(COMMENT_AT - 1)} # {comment}" if comment else line
