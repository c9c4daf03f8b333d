"""What an Armdroid cannot carry cannot be built, and the refusal names the field."""

import pytest

from firmware_protocol.armdroid import (
    ArgumentsReported,
    DriveAll,
    DriveNone,
    DriveOne,
    InterfaceReported,
    OddSpeed,
    OffsetsReported,
    SetSpeed,
    SpeedReported,
    Torque,
    TorqueReported,
    VersionReported,
)
from firmware_protocol.errors import BadField

REFUSED = [
    (lambda: DriveOne(0, 5), "motor"),
    (lambda: DriveOne(7, 5), "motor"),
    (lambda: DriveOne(True, 5), "motor"),
    (lambda: DriveOne(1, 32768), "steps"),
    (lambda: DriveOne(1, 1.0), "steps"),
    (lambda: DriveAll((1, 2, 3, 4, 5)), "steps"),
    (lambda: DriveAll("123456"), "steps"),
    (lambda: DriveAll((0, 0, 0, -32769, 0, 0)), "steps[3]"),
    (lambda: SetSpeed(0), "rpm"),  # the sketch divides by it
    (lambda: SetSpeed(1251), "rpm"),  # the interval becomes 0 ms
    (lambda: Torque(1), "on"),
    (lambda: DriveNone(3, 5), "motor"),
    (lambda: DriveNone(256, 5), "motor"),
    (lambda: OddSpeed(100), "rpm"),
    (lambda: OffsetsReported((0,) * 7), "offsets"),
    (lambda: SpeedReported(40000), "rpm"),
    (lambda: TorqueReported("on"), "on"),
    (lambda: VersionReported(""), "firmware"),
    (lambda: VersionReported("2.0", "1/0"), "protocol"),
    (lambda: InterfaceReported("two words"), "kind"),
    (lambda: ArgumentsReported((0,) * 6, 0), "arguments"),
    (lambda: ArgumentsReported((0,) * 5, None), "accumulator"),
]


@pytest.mark.parametrize(("build", "field"), REFUSED)
def test_what_does_not_fit_is_refused_by_name(build, field):
    with pytest.raises(BadField) as refusal:
        build()
    assert refusal.value.field == field


def test_a_list_of_steps_becomes_a_value():
    assert DriveAll([1, 2, 3, 4, 5, 6]) == DriveAll((1, 2, 3, 4, 5, 6))
    assert hash(OffsetsReported([0] * 6)) == hash(OffsetsReported((0,) * 6))
