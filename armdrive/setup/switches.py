"""Whether the limit switches work: each is pressed by hand, and the board has to raise an alarm.

Nothing moves, and no motor is switched on or off. A board may accept that hard limits are on and do
nothing: then a switch that closes in motion stops nothing. The position is suspect after an alarm.
"""

from __future__ import annotations

from collections.abc import Sequence

from armdrive.arm import Arm
from armdrive.dialog.conversation import AskPerson, Question, choice
from armdrive.setup.dialog_runner import DialogPerson
from armdrive.setup.limits import SawSwitch, WiredSwitch, clear, look
from armdrive.sim.device import HasSwitches, SwitchState

PRESSED, NONE, RELEASED = "pressed", "none", "released"


def check_switches(
    arm: Arm, switches: Sequence[WiredSwitch], person: DialogPerson | None
) -> dict[str, SawSwitch]:
    """Have each switch pressed and released, and return what the board made of it, by motor.

    Without a person the simulated arm presses its own.
    """
    seen = {}
    for switch in switches:
        if _pressed(arm, switch, person):
            seen[switch.motor] = look(arm, switch, tuple(switches))
            _released(arm, switch, person)
            clear(arm)  # letting go of a switch is a change as well, and raises an alarm
        else:
            seen[switch.motor] = SawSwitch.NONE
    return seen


def _pressed(arm: Arm, switch: WiredSwitch, person: DialogPerson | None) -> bool:
    """Have a switch pressed; False where the motor has none."""
    if person is None:
        return _set(arm, switch, SwitchState.CLOSED)
    question = Question(
        switch.motor,
        f"Press the limit switch of {switch.motor} ({switch.axis}) by hand, and hold it. Type "
        f"{PRESSED}, or {NONE} if it has none:",
        "The arm stands all the while. An alarm of the board is what we are after.",
        choice((PRESSED, NONE)),
        None,
    )
    return bool(person.answer(AskPerson(question)) == PRESSED)


def _released(arm: Arm, switch: WiredSwitch, person: DialogPerson | None) -> None:
    if person is None:
        _set(arm, switch, SwitchState.FREE)
        return
    words = f"Let go of it. Type {RELEASED}:"
    why = "Then comes the next one."
    person.answer(AskPerson(Question(switch.motor, words, why, choice((RELEASED,)), None)))


def _set(arm: Arm, switch: WiredSwitch, state: SwitchState) -> bool:
    """Have the simulated operator press a switch; False where the simulated arm has none."""
    board = None if arm.twin is None else arm.twin.board
    if not isinstance(board, HasSwitches):
        return False
    board.set_switch(switch.index, state)
    return True
