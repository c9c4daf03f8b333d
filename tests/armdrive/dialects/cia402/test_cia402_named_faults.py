"""What only CiA 402 drives can have in motion: faults of their own, and orders of another master.

`tests/conformance/expected_errors.py` lists the faults that drives of every kind can have. Each row
ends in the same program, where the arm moves again.
"""

from __future__ import annotations

import pytest
from can_fault_bench import Bus, check_recovery, check_reported_and_stopped

from firmware_protocol.canopen import Nmt, NmtCommand
from firmware_protocol.frames import pack

FAULT = "E501"
ELBOW = r"drive 3 \(elbow\)"
TOO_HOT = ("drive-fault 3 4310", f"{ELBOW} is in fault.*too hot")
LEFT_BEHIND = ("drive-fault 3 8611", f"{ELBOW} is in fault.*following")
ORDERED = (NmtCommand.PRE_OPERATIONAL, f"program has ordered {ELBOW} to be pre-operational")
STOPPED = (NmtCommand.STOP, f"program has ordered {ELBOW} to be stopped")


def ordered(bus, command):
    """Return what has another master order the elbow's drive to be something."""
    frame = pack(Nmt(command, 3).frame)
    return lambda: bus.twin.device.receive(frame, bus.twin.device.now_s)


@pytest.mark.parametrize(
    ("fault", "words", "strategy"),
    [(*TOO_HOT, "cyclic"), (*TOO_HOT, "profile"), (*LEFT_BEHIND, "cyclic"), (*ORDERED, "cyclic"),
     (*ORDERED, "profile"), (*STOPPED, "cyclic")],
)  # fmt: skip
def test_it_is_reported_and_mended_in_the_same_program(fault, words, strategy):
    bus = Bus("cia402", settings={"strategy": strategy})
    arm = bus.ready()
    begin = ordered(bus, fault) if isinstance(fault, NmtCommand) else fault
    check_reported_and_stopped(arm, words, FAULT, begin, after_s=0.3, watched_s=1.2)
    check_recovery(arm, bus.motors)
