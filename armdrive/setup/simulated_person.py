"""The person at a simulated arm, who handles and watches it as a user does a real one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from armdrive.dialog import About, ArmMotion, Question
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.mechanics.motors import SwitchState
from armdrive.sim.simulated_arm import SimulatedArm


class SimulatedPerson:
    """Plugs drives in, presses switches, sees what moves, and answers.

    With `ask` the user answers, after reading what there was to see.
    """

    def __init__(
        self,
        twin: SimulatedArm,
        tell: Callable[[str], None],
        ask: Callable[[Question], Any] | None = None,
    ) -> None:
        self.tell = tell
        self._ask = ask
        self._twin = twin
        self._motion = self._motion_since(None)

    def unplug_all(self, drives: int) -> None:
        """Pull the CAN cable of every drive."""
        for motor in range(drives):
            self._plug(motor, on=False)

    def look(self, *, moved: bool) -> None:
        """Look at the arm before it moves, and again when it has moved."""
        self._motion = self._motion_since(self._motion if moved else None)

    def answer(self, question: Question) -> Any:
        """Do what a question asks for, then answer it or have the user answer it."""
        seen = "" if question.by_eye is None else question.by_eye(self._motion)
        word = self._done(question) or seen
        if self._ask is None:
            word = word or question.default or "yes"
            self.tell(f"{question.words} {word}")
            return question.read(word)
        if seen:
            self.tell(f"  (seen on the simulated arm: {seen})")
        return self._ask(replace(question, default=word or question.default))

    def _done(self, question: Question) -> str:
        """Do what the question asks for; return the answer if there is only one."""
        match question.about:
            case About.CONNECT:
                self._plug_alone(question.motor)
            case About.PRESS:
                self._press(question.motor, SwitchState.CLOSED)
                return "pressed"
            case About.RELEASE:
                self._press(question.motor, SwitchState.FREE)
                return "released"
        return ""

    def _plug_alone(self, motor: int) -> None:
        """Plug a drive in, and pull the cable of those that have its id."""
        board: Any = self._twin.board
        drives = board.details().get("drives", ())
        for other, drive in enumerate(drives):
            if drive["id"] == drives[motor]["id"]:
                self._plug(other, on=other == motor)

    def _plug(self, motor: int, *, on: bool) -> None:
        board: Any = self._twin.board
        if isinstance(board, DrivesBoard):
            board.node(motor).port.plugged = on

    def _press(self, motor: int, state: SwitchState) -> None:
        """Press or release a limit switch."""
        board: Any = self._twin.board
        board.set_switch(motor, state)

    def _motion_since(self, start: ArmMotion | None) -> ArmMotion:
        world = self._twin.world
        now, opening_mm = world.joints, world.opening_mm
        if start is None:
            return ArmMotion(world.body.arm, now, now, opening_mm, opening_mm)
        return replace(start, after=now, opened_to_mm=opening_mm)
