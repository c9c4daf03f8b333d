"""What can go wrong with CiA 402 drives in motion: said clearly, the arm stands, and it is mended.

Every row ends in the same program: with the fault over it is reconnected or reset, referenced, and
moves again.
"""

from __future__ import annotations

import pytest
from can_fault_bench import Bus, brought_back, is_told_and_stands

from firmware_protocol.canopen import Nmt, NmtCommand
from firmware_protocol.frames import pack

AFTER_S = 0.3
WATCHED_S = 1.2
LOST, FAULT, SILENT, RESTARTED = "E407", "E501", "E502", "E718"
ELBOW = r"drive 3 \(elbow\)"
ROWS = {
    "the interface goes down": ("unplug", "unplugged: plug it in", LOST),
    "the adapter leaves the bus": ("bus-off", "bus-off.*resistors and the bit rate", LOST),
    "nobody acknowledges": ("alone", "no answer.*power.*120 ohm.*bit rate", SILENT),
    "nothing is heard": ("mute", "no answer.*power.*120 ohm.*bit rate", SILENT),
    "a node is reset": ("drive-reset 3", f"{ELBOW} (was reset|.*power.*plug)", FAULT),
    "a node says nothing": ("drive-mute 3", f"{ELBOW} .*power.*plug", FAULT),
    "a node dies": ("drive-dead 3", f"{ELBOW} .*power.*plug", FAULT),
    "a node is too hot": ("drive-fault 3 4310", f"{ELBOW} is in fault.*too hot", FAULT),
    "a shaft is left behind": ("drive-fault 3 8611", f"{ELBOW} is in fault.*following", FAULT),
    "a node gets another mode": ("drive-mode 3 3", f"{ELBOW} .*mode", FAULT),
    "a node gets the number of another": ("drive-id 3 2", "drive [23]", FAULT),
    "all lose their power": ("brown-out", "power|reset", RESTARTED),
    "all are reset": ("reset", "power|reset", FAULT),
    "a node is made pre-operational": (
        NmtCommand.PRE_OPERATIONAL, f"program has ordered {ELBOW} to be pre-operational", FAULT),
    "a node is stopped": (NmtCommand.STOP, f"program has ordered {ELBOW} to be stopped", FAULT),
}  # fmt: skip


def ordered(bus, command):
    """Return what has another master order the elbow's drive to be something."""
    frame = pack(Nmt(command, 3).frame)
    return lambda: bus.twin.device.receive(frame, bus.twin.device.now_s)


BY_PROFILE = (
    "the interface goes down",
    "a node is reset",
    "a node is too hot",
    "a node is made pre-operational",
)
"""In bursts, what ends them is found in another way: of each kind of fault, one."""
CASES = [(name, "cyclic") for name in ROWS] + [(name, "profile") for name in BY_PROFILE]


@pytest.mark.parametrize(("name", "strategy"), CASES)
def test_it_is_said_the_arm_stands_and_it_is_mended_in_the_same_program(name, strategy):
    fault, words, code = ROWS[name]
    bus = Bus("cia402", settings={"strategy": strategy})
    arm = bus.ready()
    begin = ordered(bus, fault) if isinstance(fault, NmtCommand) else fault
    is_told_and_stands(arm, words, code, begin, after_s=AFTER_S, watched_s=WATCHED_S)
    brought_back(arm, bus.motors)
