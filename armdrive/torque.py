"""Whether an arm is held or sags: after `disable`, `estop`, a loss of power, a closed port."""

from __future__ import annotations

from dataclasses import dataclass

HELD, SAGS = "is held", "sags"
"""Every sentence of an arm begins with one of these."""


@dataclass(frozen=True, slots=True)
class Torque:
    """What becomes of the holding torque of one dialect's motors, a sentence for each event.

    `closed_port` is also what happens when this program ends or dies, or the cable is pulled, once
    the last burst has ended.
    """

    disable: str
    estop: str
    power_loss: str
    closed_port: str
