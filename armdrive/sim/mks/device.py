"""A simulated arm on MKS SERVO42D/57D drives: how they are set up, saved, and turn the arm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, ClassVar

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest, StateFileError
from armdrive.sim.bus.drives import DrivesBox
from armdrive.sim.mks.motion import due_s, give_up, happen
from armdrive.sim.mks.node import Flash, MksNode
from armdrive.sim.mks.requests import obey, report, state
from armdrive.sim.world.saved import MEND, Json, Saved
from firmware_protocol.errors import BadField
from firmware_protocol.frames import Frame, pack
from firmware_protocol.mks import (
    Asked,
    Bitrate,
    Code,
    HomingState,
    Mode,
    SetBitrate,
    SetCurrent,
    SetHoming,
    SetId,
    SetMicrosteps,
    SetMode,
    SetStallProtection,
    Setting,
)

# --- The drives as plain data --------------------------------------------------------------------


def known_json(nodes: Sequence[MksNode]) -> dict[str, Json]:
    """Return what each drive is set up to be, and whether it holds its shaft."""
    return {
        "drives": [
            {
                "powered": node.powered,
                "enabled": node.enabled,
                "stalled": node.stalled,
                "homed": node.homing is HomingState.DONE,
                "settings": dict(node.flash.to_json()),
            }
            for node in nodes
        ]
    }


def seen_json(node: MksNode, error: int, now_s: float) -> dict[str, Json]:
    """Return what a drive would tell of itself, and how far its shaft is from its set-point."""
    return {
        "id": node.device.node,
        "firmware": ".".join(map(str, node.firmware)),
        "powered": node.powered,
        "mode": node.mode.name.lower(),
        "enabled": node.enabled,
        "stalled": node.stalled,
        "state": state(node, now_s).name.lower(),
        "rpm": round(node.point.rpm(now_s), 2),
        "error_counts": error,
        "stored": node.stored is not None,
        "watchdog_s": 0.0 if math.isinf(node.timeout_s) else node.timeout_s,
        "watchdog_stops": node.watchdog_stops,
    }


def recall_known(nodes: Sequence[MksNode], saved: Saved, *, powered: bool) -> None:
    """Know again what `known_json` wrote. Raises `StateFileError`."""
    drives = saved.items("drives")
    if len(drives) != len(nodes):
        raise StateFileError(
            f"{len(drives)} drives are saved of an arm that has {len(nodes)}; {MEND}"
        )
    for node, item in zip(nodes, drives, strict=True):
        _recall(node, Saved(item, f"drive {node.index + 1}"), powered=powered)


def _recall(node: MksNode, saved: Saved, *, powered: bool) -> None:
    node.powered = saved.flag("powered") and powered
    node.stalled = saved.flag("stalled")
    node.homing = HomingState.DONE if saved.flag("homed") else None
    node.flash = Flash.from_json(saved.table("settings"))
    node.remake()
    node.recall_enabled(saved.flag("enabled"))
    saved.end()


class SimMks(DrivesBox[MksNode]):
    """The drives, the arm, and the person beside them. Input bit n is the IN_1 of drive n."""

    title: ClassVar[str] = "arm on MKS drives"

    @property
    def busy(self) -> bool:
        """Whether a motion is under way or an answer on its way."""
        return self._outbox.next_s < math.inf or any(
            node.under_way is not None for node in self.nodes
        )

    def set_drive_id(self, drive: int, node: int) -> int:
        """Give a drive an id, another one's perhaps; return the old. Raises `BadRequest`."""
        one = self._node(drive)
        try:
            setting = SetId(node)
        except BadField as error:
            raise BadRequest(str(error)) from None
        before = one.flash.of(SetId).node
        one.flash.put(setting)
        one.remake()
        return before

    def set_drive_mode(self, drive: int, mode: int) -> int:
        """Give a drive a mode, as at its own keys; return the old. Raises `BadRequest`."""
        one, modes = self._node(drive), [*Mode]
        if mode not in modes:
            raise BadRequest(f"modes are {int(modes[0])} to {int(modes[-1])}, not {mode}")
        before = one.mode
        give_up(one, self.now_s)
        one.point.hold(one.point.at(self.now_s))
        one.flash.put(SetMode(Mode(mode)))
        self._collect()
        return before

    def withhold_done(self, drive: int, withheld: bool) -> None:
        """Have a drive not say that a motion is done, or say it again."""
        node = self._node(drive)
        node.says_done = node.quirks.says_done and not withheld

    # The box.

    def _listens(self, node: MksNode, frame: Frame) -> bool:
        meant = node.listens_to(frame.can_id)
        return node.plugged and (meant or node.quirks.watchdog_hears_all)

    def _bring(self, node: MksNode, frame: Frame) -> None:
        if node.awake and node.device.bitrate.bits_s == self._bits_s:
            node.heard_s, node.expired = self.now_s, False
            if node.listens_to(frame.can_id):
                node.device.receive_data(pack(frame))
            while (event := node.device.next_event()) is not None:
                if isinstance(event, Asked):
                    if event.request.code is not Code.ABSOLUTE_AXIS:  # a stream minds no shaft
                        self._shafts.look(self.now_s)
                    obey(node, event, self.now_s)

    def _next_of(self, node: MksNode) -> float:
        return due_s(node)

    def _live_through(self, node: MksNode) -> None:
        happen(node, self.now_s)
        if node.awake:
            report(node, self.now_s)

    def _seen(self, node: MksNode, error: int) -> dict[str, Json]:
        return seen_json(node, error, self.now_s)

    def known(self) -> dict[str, Json]:
        """Return what the drives know."""
        return known_json(self.nodes)

    def recall_known(self, saved: Saved) -> None:
        """Know what `known` wrote; raises `StateFileError`."""
        recall_known(self.nodes, saved, powered=self.powered)


# --- The settings of the drives, from the arm file -----------------------------------------------
#
# The arm file's own section is read without the driver's class. The driver's figures stay its own,
# so that a difference shows.

HOMING_RPM = 60
USUAL_MA, USUAL_MICROSTEPS = 1600, 16


def drive_settings(
    config: ArmConfig,
    count: int,
    bitrate: Bitrate,
    *,
    factory: bool,
    limits: bool,
    stall_protection: bool,
) -> list[list[Setting]]:
    """Return what somebody has set on each drive who knows this arm; of new ones, the speed."""
    device: Any = config.device
    ids = tuple(getattr(device, "ids", ()) or range(1, count + 1))[:count]
    if len(ids) < count:
        raise BadRequest(f"ids of {len(ids)} drives cannot turn the {count} motors of this arm")
    if factory:
        return [[SetBitrate(bitrate)] for _ in ids]
    current_ma = getattr(device, "current_ma", 0) or USUAL_MA
    microsteps = getattr(device, "microsteps", 0) or USUAL_MICROSTEPS
    try:
        return [
            [
                SetBitrate(bitrate),
                SetId(node),
                SetMode(Mode.BUS_FOC),
                SetCurrent(current_ma),
                SetMicrosteps(microsteps),
                SetStallProtection(stall_protection),
                SetHoming(
                    active_high=False,
                    counter_clockwise=True,
                    speed_rpm=HOMING_RPM,
                    limits=limits,
                    method=0,
                ),
            ]
            for node in ids
        ]
    except BadField as error:
        raise BadRequest(str(error)) from None
