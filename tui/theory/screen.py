"""The theory screen: what the lecture notes say of the arm as it stands. It moves nothing."""

from __future__ import annotations

import math
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.geometry import Size

from armdrive.status import Status
from kinematics.textbook.stepping import axes_of
from kinematics.textbook.study import Study, Subject, study, subject_of_arm
from tui.keys.keyboard import bindings
from tui.painting import PlainText
from tui.screens import DeskScreen
from tui.theory.panel import TheoryPanel, axis_rows, joint_rows

LOOK_S = 0.2
"""Matrices of a moving arm are worked out no more often: its own thread comes first."""

READ_ONLY = "read only: nothing here moves it"
UNKNOWN_BUILD = "no theory is known of an arm of this build"


class TheoryScreen(DeskScreen):
    """Link table, matrices, Jacobian, singularities and solutions of the present posture."""

    place = "theory"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)

    def __init__(self) -> None:
        super().__init__()
        self.subject: Subject | None = subject_of_arm(
            self.desk.link.status.title, self.desk.arm.model.arm
        )
        self._key: tuple[tuple[float, ...] | None, Size] = (None, Size())
        self._shown_s = -math.inf

    def compose_body(self) -> ComposeResult:
        """Lay the middle out; it says so where nothing is known of the arm's build."""
        if self.subject is None:
            yield PlainText(id="no-theory")
        else:
            yield TheoryPanel(self.subject, _numbers, braille=self.desk.braille)

    def show_body(self, status: Status) -> None:
        """Show what follows from the posture, as soon as it or the size has changed."""
        if self.subject is None:
            self.text("no-theory").show(UNKNOWN_BUILD)
            return
        panel = self.query_one(TheoryPanel)
        values = None if status.joints is None else status.joints.angles_rad
        key, now_s = (values, panel.size), self.desk.clock()
        soon = key[1] == self._key[1] and now_s - self._shown_s < LOOK_S
        if key == self._key or soon:
            return
        self._key, self._shown_s = key, now_s
        panel.show(None if values is None else study(self.subject, values))

    def action_turn(self, by: int) -> None:
        """Turn pages."""
        for panel in self.query(TheoryPanel):
            panel.turn(by)

    def action_symbols(self) -> None:
        """Switch between numbers and symbols."""
        for panel in self.query(TheoryPanel):
            panel.switch_symbols()

    def action_axes(self) -> None:
        """Go on from the numbers to the thirteen steps, the other convention, and back."""
        for panel in self.query(TheoryPanel):
            panel.switch_axes()


def _numbers(of: Study, width: int) -> str:
    rows = joint_rows(of, width), axis_rows(of, axes_of(of.subject))
    return "\n".join((READ_ONLY, *rows))
