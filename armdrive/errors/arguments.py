"""Checks the arguments of public calls by their annotations, with one mechanism for all calls.

A class of public calls is decorated with `checked_calls(RULES)`. `RULES` has a rule for each
annotation, as it is written in the signature; `"frame: str"` is the rule for parameters of that
name, `"_s: float"` for all times. A wrong value raises an `ArmError` that names the parameter,
before the call begins: nothing has been sent, and no state has changed. So do too many arguments
and unknown keywords.

`known_attributes` checks in the same way what a program assigns to an object.
"""

from __future__ import annotations

import contextlib
import functools
import inspect
import math
import operator
from collections.abc import Callable, Iterable, Mapping
from typing import Any, SupportsIndex, TypeVar

from armdrive.blocking import blocking, waiting_part
from armdrive.errors import BadArgument
from armdrive.errors.kinematic import refusal_of
from kinematics.errors import KinematicsError, finite, suggestion

# More than eleven days. A longer time is a slip that real timers cannot count (they overflow at
# 292 years), and whose end a simulation, which reads the registers all the while, never reaches.
LONGEST_TIME_S = 1e6

# Characters of a wrong value that an error quotes.
LONGEST_SHOWN = 80

# Returns the checked value of an argument, or raises the error that names the argument.
Rule = Callable[[str, object], object]


def anything(_: str, value: object) -> object:
    """Accept any value."""
    return value


def number(name: str, value: object) -> object:
    """Accept a finite number, also numpy's; raises `BadNumber`."""
    checked = finite(name, value)
    return value if type(value) in (int, float) else checked


def duration(name: str, value: object) -> object:
    """Accept a time in seconds from 0 to `LONGEST_TIME_S`."""
    if _time_s(name, value) > LONGEST_TIME_S:
        raise wrong(name, value, f"at most {LONGEST_TIME_S:.0f} seconds")
    return number(name, value)


def _time_s(name: str, value: object) -> float:
    time_s = finite(name, value)
    if time_s < 0.0:
        raise wrong(name, value, "0 or more seconds")
    return time_s


def limit(name: str, value: object) -> object:
    """Accept a time that limits a wait; beyond `LONGEST_TIME_S` it means no limit."""
    endless = isinstance(value, float) and value == math.inf
    if endless or _time_s(name, value) > LONGEST_TIME_S:
        return math.inf
    return number(name, value)


def whole(name: str, value: object) -> int:
    """Accept a whole number, also numpy's; raises `BadNumber` for anything but a number."""
    finite(name, value)
    if isinstance(value, SupportsIndex):
        with contextlib.suppress(TypeError):  # an array has an index as well, and refuses
            return operator.index(value)
    raise wrong(name, value, "a whole number")


def flag(name: str, value: object) -> bool:
    """Accept True or False, or 1 or 0."""
    if isinstance(value, bool):
        return value
    with contextlib.suppress(KinematicsError):
        if finite(name, value) in (0.0, 1.0):
            return bool(value)
    raise wrong(name, value, "True or False")


def expected(words: str, example: str, fits: Callable[[object], bool]) -> Rule:
    """Return the rule for values that fit."""

    def rule(name: str, value: object) -> object:
        if fits(value):
            return value
        raise wrong(name, value, words, example)

    return rule


def made_of(kinds: type | tuple[type, ...], words: str, example: str = "") -> Rule:
    """Return the rule for instances of some classes."""
    return expected(words, example, lambda value: isinstance(value, kinds))


text = made_of(str, "text")
call = expected("a function", "", callable)


def several(each: Rule, words: str, example: str) -> Rule:
    """Return the rule for a list or tuple whose values all follow a rule. Text is not a list."""

    def rule(name: str, value: object) -> object:
        if not isinstance(value, Iterable) or isinstance(value, str | bytes | Mapping):
            raise wrong(name, value, words, example)
        return tuple(each(f"{name}[{index}]", one) for index, one in enumerate(value))

    return rule


# The rules of Python's own types, by their annotations.
BASIC: Mapping[str, Rule] = {
    "float": number,
    "_s: float": duration,
    "for_s: float": limit,
    "timeout_s: float": limit,
    "within_s: float": limit,
    "int": whole,
    "bool": flag,
    "str": text,
    "object": anything,
}


def wrong(name: str, value: object, words: str, example: str = "") -> BadArgument:
    """Return the error for an argument: what it must be, what it is, and an example."""
    shown = repr(value)
    if len(shown) > LONGEST_SHOWN:
        shown = f"{shown[:LONGEST_SHOWN]}..."
    hint = f"; for example {example}" if example else ""
    return BadArgument(f"{name} must be {words}, not {shown}{hint}")


def rule_of(name: str, annotation: str, rules: Mapping[str, Rule]) -> Rule | None:
    """Return the rule of a parameter, `"frame: str"`, or of its annotation, or None.

    Parameters whose name ends in a unit can have a rule as well, `"_s: float"`.
    """
    plain, unit = annotation.removesuffix(" | None"), name.rpartition("_")[2]
    keys = (f"{name}: {plain}", f"_{unit}: {plain}", plain)
    rule = next((rules[key] for key in keys if key in rules), None)
    if rule is None or plain == annotation:
        return rule
    return lambda name, value: None if value is None else rule(name, value)


# Applying the rules to the public calls of a class.

C = TypeVar("C", bound=type)
Method = Callable[..., Any]

_EVERY, _NAMED = inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD


class Arguments:
    """The parameters of one method: their number, names and rules.

    The signature is read at the first call, because a program uses few of all methods.
    """

    def __init__(self, method: Method, rules: Mapping[str, Rule]) -> None:
        self._method = method
        self._known = rules

    @functools.cached_property
    def _signature(self) -> inspect.Signature:
        return inspect.signature(self._method)

    @functools.cached_property
    def _rules(self) -> Mapping[str, tuple[Any, Rule]]:
        return {
            each.name: (each.kind, rule)
            for each in self._signature.parameters.values()
            if (rule := rule_of(each.name, str(each.annotation), self._known)) is not None
        }

    def taken(
        self, words: tuple[Any, ...], named: dict[str, Any]
    ) -> tuple[tuple[Any, ...], dict[str, Any]]:
        """Return the checked arguments of a call, `self` first; raises `BadArgument`."""
        try:
            bound = self._signature.bind(*words, **named)
        except TypeError as error:
            raise BadArgument(self._wrong_count(str(error), named)) from None
        given = bound.arguments
        for name, (kind, rule) in self._rules.items():
            if name not in given:
                continue
            if kind is _EVERY:
                given[name] = tuple(rule(name, each) for each in given[name])
            elif kind is _NAMED:
                given[name] = {word: rule(word, each) for word, each in given[name].items()}
            else:
                given[name] = rule(name, given[name])
        return bound.args, bound.kwargs

    def _wrong_count(self, why: str, named: Mapping[str, Any]) -> str:
        known = [name for name in self._signature.parameters if name not in ("self", "cls")]
        strange = next((name for name in named if name not in known), "")
        hint = suggestion(strange, known) if strange else ""
        takes = ", ".join(known) or "nothing"
        return f"{self._method.__name__}(): {why}{hint}; it takes {takes}"


def checked(rules: Mapping[str, Rule]) -> Callable[[Method], Method]:
    """Return a decorator that checks arguments, and makes kinematic refusals `ArmError`s."""

    def decorate(method: Method) -> Method:
        if (waiting := waiting_part(method)) is not None:
            return blocking(decorate(waiting))

        arguments = Arguments(method, rules)

        if inspect.iscoroutinefunction(method):

            @functools.wraps(method)
            async def awaited(*words: Any, **named: Any) -> Any:
                try:
                    words, named = arguments.taken(words, named)
                    return await method(*words, **named)
                except KinematicsError as error:
                    raise refusal_of(error) from None

            return awaited

        @functools.wraps(method)
        def called(*words: Any, **named: Any) -> Any:
            try:
                words, named = arguments.taken(words, named)
                return method(*words, **named)
            except KinematicsError as error:
                raise refusal_of(error) from None

        return called

    return decorate


def _is_public(name: str) -> bool:
    return not name.startswith("_") or name in ("__getitem__", "__setitem__", "__delitem__")


def checked_calls(rules: Mapping[str, Rule], *only: str) -> Callable[[C], C]:
    """Return a decorator that checks every public call of a class, or only the named ones."""
    check = checked(rules)

    def decorate(kind: C) -> C:
        known = {name: each for base in reversed(kind.__mro__) for name, each in vars(base).items()}
        for name in only or filter(_is_public, sorted(known)):
            found = known[name]
            if inspect.isfunction(found) and not hasattr(
                waiting_part(found) or found, "__wrapped__"
            ):
                setattr(kind, name, check(found))
            elif isinstance(found, classmethod):
                setattr(kind, name, classmethod(check(found.__func__)))
            elif isinstance(found, property) and found.fset is not None:
                setattr(kind, name, found.setter(check(found.fset)))
        return kind

    return decorate


# Attributes that a program assigns.

# The attribute of an object whose `__init__` has ended.
_COMPLETE = "_complete"


def known_attributes(kind: C) -> C:
    """Refuse to assign an attribute that `__init__` and the class do not have.

    Python would create it, and nothing would ever read it: after `arm.speed_overide = 0.5` a
    program believes that the arm is slow. A call cannot become a value either, as in
    `arm.pause = True`; another function can replace it. Private attributes are left to the class,
    and a subclass decides for itself.
    """
    made: Any = kind
    begin = made.__init__

    @functools.wraps(begin)
    def complete(self: Any, *words: Any, **named: Any) -> None:
        begin(self, *words, **named)
        if type(self) is kind:
            vars(self)[_COMPLETE] = True

    def assign(self: Any, name: str, value: object) -> None:
        own = vars(self)
        if name in own and not callable(own[name]):  # as for each jump of a clock
            own[name] = value
            return
        if _COMPLETE in own and not name.startswith("_"):
            _require_known(self, name, value)
        object.__setattr__(self, name, value)

    # set here, because type checkers allow any attribute of a class that defines `__setattr__`
    for name, method in (("__init__", complete), ("__setattr__", assign)):
        setattr(kind, name, method)
    return kind


def _require_known(owner: object, name: str, value: object) -> None:
    kind = type(owner)
    if callable(getattr(kind, name, None)) and not callable(value):
        raise BadArgument(f"{kind.__name__}.{name} is a call, not a value: write {name}(...)")
    if name in vars(owner) or hasattr(kind, name):
        return
    known = [*vars(owner), *(each for each in dir(kind) if _is_variable(getattr(kind, each)))]
    hint = suggestion(name, [each for each in known if not each.startswith("_")])
    raise BadArgument(f"{kind.__name__} has no attribute {name!r:.40}{hint}")


def _is_variable(found: object) -> bool:
    """Return whether an attribute of a class can be assigned: neither a call nor read-only."""
    return found.fset is not None if isinstance(found, property) else not callable(found)
