"""See that the limit switches work: you press each by hand, and the board has to raise an alarm.

Nothing moves, and no motor is switched on or off. A board may accept that hard limits are on and do
nothing: then a switch that closes in motion stops nothing. The day on which every switch was seen
to raise an alarm is written into the arm file. The position is suspect after an alarm: home then.
"""

from __future__ import annotations

import argparse
from datetime import UTC, datetime

from armdrive.arm import Arm
from armdrive.cli.arm_files import read
from armdrive.cli.presenter import emit, say
from armdrive.cli.questions import agree, ask_value
from armdrive.cli.set_up.config_signs import connected
from armdrive.dialog.conversation import Question, choice
from armdrive.registry.arm_files import load_arm
from armdrive.setup.filing import FileProposal
from armdrive.setup.limits import (
    SawSwitch,
    WiredSwitch,
    all_work,
    clear,
    limit_remarks,
    look,
    make_ready,
    record,
    switches_of,
)
from armdrive.sim.device import HasSwitches, SwitchState

PERSON = "press the switches of a real arm"
PRESSED, NONE, RELEASED = "pressed", "none", "released"

UNHEEDED = (
    "A switch that closes in motion would stop nothing. The board's firmware takes no notice of "
    "hard limits, as the default build of grbl-Mega-5X for RAMPS boards: take another build "
    "(docs/grbl.md), or write hard_limits = false, so that nobody counts on them."
)


def run(options: argparse.Namespace) -> int:
    """Look at each switch, and write down the day on which all work."""
    path = read(options.name).path
    config = load_arm(path)
    switches = switches_of(config)
    alone = options.yes or options.json
    with connected(config, simulated=options.sim, alone=alone, wanted=PERSON) as arm:
        make_ready(arm)
        seen = check(arm, switches, alone=alone)
        simulated = arm.simulated
    works = all_work(seen)
    if options.json:
        emit({"switches": {name: saw.name.lower() for name, saw in seen.items()}, "works": works})
        return 0 if works else 1
    for name, saw in seen.items():
        say(f"{name}: {saw.value}")
    if not works:
        say(
            UNHEEDED
            if SawSwitch.PIN_ALONE in seen.values()
            else "Look at the switches and their wires."
        )
        for remark in limit_remarks(config):
            say(remark)
        return 1
    if simulated:
        say("every switch works; nothing is written of a simulated arm")
        return 0
    _write_down(record(path, config, datetime.now(UTC).astimezone().date()))
    return 0


def _write_down(proposal: FileProposal) -> None:
    for line in proposal.difference:
        say(f"  {line}")
    if agree(f"Write this to {proposal.path}?", "no leaves the file as it was.", "yes"):
        proposal.write()
        say(f"written: {proposal.path}")


def check(
    arm: Arm, switches: tuple[WiredSwitch, ...], *, alone: bool = False
) -> dict[str, SawSwitch]:
    """Have each switch pressed and released, and return what the board made of it, by motor."""
    seen = {}
    for switch in switches:
        if _pressed(arm, switch, alone=alone):
            seen[switch.motor] = look(arm, switch, switches)
            _released(arm, switch, alone=alone)
            clear(arm)  # letting go of a switch is a change as well, and raises an alarm
        else:
            seen[switch.motor] = SawSwitch.NONE
    return seen


def _pressed(arm: Arm, switch: WiredSwitch, *, alone: bool) -> bool:
    """Have a switch pressed; False where the motor has none."""
    if alone:
        return _set(arm, switch, SwitchState.CLOSED)
    word: str = ask_value(
        Question(
            switch.motor,
            f"Press the limit switch of {switch.motor} ({switch.axis}) by hand, and hold it. Type "
            f"{PRESSED}, or {NONE} if it has none:",
            "The arm stands all the while. An alarm of the board is what we are after.",
            choice((PRESSED, NONE)),
            None,
        )
    )
    return word == PRESSED


def _released(arm: Arm, switch: WiredSwitch, *, alone: bool) -> None:
    if alone:
        _set(arm, switch, SwitchState.FREE)
        return
    words = f"Let go of it. Type {RELEASED}:"
    ask_value(Question(switch.motor, words, "Then comes the next one.", choice((RELEASED,)), None))


def _set(arm: Arm, switch: WiredSwitch, state: SwitchState) -> bool:
    """Have the simulated operator press a switch; False where the simulated arm has none."""
    device = None if arm.twin is None else arm.twin.device
    if not isinstance(device, HasSwitches):
        return False
    device.set_switch(switch.index, state)
    return True
