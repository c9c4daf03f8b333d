"""The rules of a message's fields: what they keep, what they refuse, and in which words."""

from dataclasses import FrozenInstanceError
from enum import IntEnum

import pytest

from firmware_protocol.errors import BadField
from firmware_protocol.fields import (
    BYTE,
    an_instance,
    boolean,
    each,
    message,
    numbered,
    optional,
    row_of,
    whole_from,
)


class Colour(IntEnum):
    RED = 1
    BLUE = 2


PAIR = row_of(whole_from(-3, 3), 2, "two numbers")


@message(colour=numbered(Colour), pair=PAIR)
class Message:
    colour: Colour
    pair: tuple[int, ...] = (0, 0)

    def __post_init__(self) -> None:
        if self.colour is Colour.RED and any(self.pair):
            raise BadField("pair", self.pair, "zeros where it is red")


@pytest.mark.parametrize(
    ("rule", "given", "kept"),
    [
        (BYTE, 255, 255),
        (boolean, False, False),
        (numbered(Colour), 2, Colour.BLUE),
        (an_instance(str, "text"), "a", "a"),
        (optional(BYTE), None, None),
        (optional(BYTE), 7, 7),
        (each(BYTE), [], ()),
        (each(BYTE), [1, 2], (1, 2)),
        (PAIR, [3, -3], (3, -3)),
        (row_of(BYTE, range(1, 3), "one or two"), (9,), (9,)),
    ],
)
def test_a_rule_keeps_what_fits(rule, given, kept):
    found = rule("field", given)
    assert found == kept
    assert type(found) is type(kept)


@pytest.mark.parametrize(
    ("rule", "given", "field", "allowed"),
    [
        (BYTE, 256, "field", "a whole number from 0 to 255"),
        (BYTE, True, "field", "a whole number from 0 to 255"),
        (boolean, 1, "field", "True or False"),
        (numbered(Colour), 3, "field", "a whole number from 1 to 2"),
        (an_instance(str, "text"), b"a", "field", "text"),
        (optional(BYTE), -1, "field", "a whole number from 0 to 255"),
        (each(BYTE), [1, "2"], "field", "a whole number from 0 to 255"),
        (PAIR, (1, 2, 3), "field", "two numbers"),
        (PAIR, 12, "field", "two numbers"),
        (PAIR, (1, 4), "field[1]", "a whole number from -3 to 3"),
        (row_of(BYTE, range(1, 3), "one or two"), (), "field", "one or two"),
    ],
)
def test_a_rule_refuses_what_does_not_fit_and_names_it(rule, given, field, allowed):
    with pytest.raises(BadField) as refused:
        rule("field", given)
    assert (refused.value.field, refused.value.allowed) == (field, allowed)


def test_a_message_keeps_what_its_rules_return_and_is_frozen():
    message = Message(2, [1, 2])
    assert message == Message(Colour.BLUE, (1, 2))
    assert message.colour is Colour.BLUE
    with pytest.raises(FrozenInstanceError):
        message.colour = Colour.RED


@pytest.mark.parametrize(("colour", "pair"), [(0, (0, 0)), (2, (9, 0)), (1, (1, 0))])
def test_fields_are_checked_one_by_one_and_then_together(colour, pair):
    with pytest.raises(BadField):
        Message(colour, pair)
