"""How one simulated GRBL board is built and wired, as data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from armdrive.sim.grbl_firmware import Firmware
from armdrive.sim.grbl_outputs import Wiring


@dataclass(frozen=True, slots=True)
class Build:
    """One board on one arm.

    `order` gives the axis of each motor by its place in `axes`; `fingers` is which output moves
    them, over `opening_mm` at `finger_mm_s`. `coast` is the share of the ramp that the arm runs on
    when its motors stop dead. `resets_on_open`: a saved board is found freshly reset.
    """

    firmware: Firmware
    axes: str
    order: Sequence[int]
    fingers: Wiring = field(default_factory=Wiring)
    opening_mm: tuple[float, float] = (0.0, 76.0)
    finger_mm_s: float = 100.0
    coast: float = 1.0
    resets_on_open: bool = False
