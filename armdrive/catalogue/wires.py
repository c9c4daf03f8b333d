"""E4, E5 and E8: ports and wires, what the controller does, and bytes that make no sense."""

from __future__ import annotations

from armdrive.catalogue.calls import LATCHED
from armdrive.catalogue.entry import NOTHING_SENT, Entry

NOTHING_OPENED = "Nothing was opened, nothing moved."

WIRES = (
    Entry(
        "E401", "LinkError", "something is wrong with the wire",
        "What the sentence says.",
        "The arm stands once its last burst has ended.",
        "Check the cable and the port.",
    ),
    Entry(
        "E402", "PortUnavailable", "the port cannot be opened",
        "Its name, its settings or the environment forbid it; the sentence says which.",
        NOTHING_OPENED,
        "Do what the sentence says; `armdrive ports` lists what is there.",
    ),
    Entry(
        "E403", "NoSuchPort", "there is no such port",
        "The adapter is not plugged in, has another name, or no port has that USB serial number.",
        NOTHING_OPENED,
        "Check the cable; `armdrive ports` lists what is there. `usb_serial` in the arm file finds "
        "an adapter under any name.",
    ),
    Entry(
        "E404", "PortInUse", "another program has the port",
        "A port is opened by one program alone, and another one was first.",
        NOTHING_OPENED,
        "End the program that the sentence names.",
    ),
    Entry(
        "E405", "PortForbidden", "no permission to open the port",
        "The port belongs to a group that this user is no member of.",
        NOTHING_OPENED,
        "Join the group that the sentence names, then log in again.",
    ),
    Entry(
        "E406", "NoConnection", "nobody answers on the network",
        "The host is not known, is off, or no program listens at that port.",
        NOTHING_OPENED,
        "Check the address, that the controller is on, and the network.",
    ),
    Entry(
        "E407", "LinkLost", "the connection was lost",
        "The cable was pulled, the adapter or the network has gone, or the port was closed.",
        "What was sent already is finished, which the status bounds in seconds and mm; then the "
        "arm stands. Nothing that was queued here is ever sent. A position that was lost in motion "
        "is suspect.",
        "Plug the cable in and connect again, or have it looked for (docs/reconnecting.md): that "
        "ends in error-stop, which only `reset()` leaves, and moves nothing.",
    ),
    Entry(
        "E408", "ArmInUse", "another program holds the arm",
        "One program drives an arm at a time, and another one was first.",
        NOTHING_OPENED,
        "End the program that the sentence names; `armdrive stop` stops what it moves.",
    ),
    Entry(
        "E409", "RECONNECTED", "the connection was lost and is back",
        "The wire broke meanwhile, and the controller was found again.",
        LATCHED + " The position is not more than restored: somebody may have moved the arm.",
        "Look at the arm, call `reset()`, and confirm the drawn posture or call `home()`.",
    ),
)  # fmt: skip

CONTROLLERS = (
    Entry(
        "E501", "DeviceFault", "the controller says no",
        "The controller refused, or answered something else than it should have: a garbled byte, "
        "another dialect, a fault of its own.",
        LATCHED,
        "Look at the arm and the cable, then call `reset()`. At connecting, `armdrive doctor` "
        "finds out what is on the port.",
    ),
    Entry(
        "E502", "NoAnswer", "the controller does not answer",
        "The deadline for the answer has passed: switched off, wrong baud rate, a cable, or the "
        "pendant has control; or something else is on the wire. A call that moves nothing takes "
        "20 s at most, and the sentence says what was received.",
        "A motion that was sent may have been made or not: the arm stands once it has ended, its "
        "position is suspect, and error-stop is latched.",
        "Check that the arm is on and its cable plugged in, look at it, then call "
        "`reset()` and `home()`.",
    ),
    Entry(
        "E503", "PositionMismatch", "the registers are not where they should be",
        "A byte was lost on the wire, or the controller lost its power in motion.",
        LATCHED + " The position is suspect.",
        "Look at the arm, call `reset()`, then `home()`.",
    ),
    Entry(
        "E504", "ALARM_VOUCHED", "the controller raised an alarm and kept its position",
        "A limit or the controller's own check was met; its words are in the sentence.",
        LATCHED + " The controller vouches for the position.",
        "Look at the arm, then call `reset()`.",
    ),
    Entry(
        "E505", "ProgramHalfWritten", "a program is not whole in the arm's memory",
        "Writing the arm's own program was broken off, or it reads otherwise than it was written.",
        "Nothing moved. The sentence says which rows are in the arm, and which may be.",
        "Write the program again before it is run at the pendant.",
    ),
)  # fmt: skip

BYTES = (
    Entry(
        "E801", "ProtocolError", "a message that the dialect does not have",
        "Something was to be sent or was heard that the controller's language cannot say.",
        "Nothing was sent on its account.",
        "Report it: the driver should have caught it.",
    ),
    Entry(
        "E802", "LocalProtocolError", "this side asked for what the dialect cannot say",
        "A request does not exist in the controller's language, or not now.",
        NOTHING_SENT,
        "Choose another request; the controller's page in docs/ says what it can do.",
    ),
    Entry(
        "E803", "BadField", "a number that the dialect cannot carry",
        "A field of a message is out of the range of the controller's language.",
        NOTHING_SENT,
        "Use a number that the sentence allows.",
    ),
    Entry(
        "E804", "RemoteProtocolError", "unreadable bytes from the controller",
        "The line is disturbed, the baud rate is wrong, or another dialect is spoken.",
        "What could not be read changed nothing; an answer that it spoiled is missing.",
        "Check cable, baud rate and dialect; `armdrive doctor` listens and tells.",
    ),
    Entry(
        "E805", "GcodeError", "G-code that a board would refuse",
        "A simulated board was sent a line with a word or a number that it does not know.",
        "The line changed nothing.",
        "Correct the line; the number after `error:` is GRBL's own.",
    ),
)  # fmt: skip
