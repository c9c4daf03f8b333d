"""One simulated MKS drive: the table of its requests, its readings and its power.

The codec decodes the requests that a firmware knows (`firmware_protocol.mks`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, TypeAlias, get_args

from armdrive.errors import BadRequest
from armdrive.sim.bus.node import NodeMotor, NodePort
from armdrive.sim.mks.motion import AGAINST_A_STOP, Flash, MksNodeMotion
from armdrive.sim.mks.quirks import MksQuirks
from armdrive.sim.world.saved import Json
from firmware_protocol import mks
from firmware_protocol.errors import BadField
from firmware_protocol.frames import Frame
from firmware_protocol.mks import COUNTS_PER_TURN, COUNTS_S_PER_RPM, Asked, Code, Outcome

# A SERVO42D on CAN.
BOARD = 2
# How long a restart takes.
BOOT_S = 0.15


@dataclass(frozen=True, slots=True)
class SavedMksDrive:
    """What is saved of a drive; `settings` are hexadecimal, by the names of their codes."""

    powered: bool
    enabled: bool
    stalled: bool
    homed: bool
    settings: Mapping[str, str]


class MksNode:
    """A drive on one motor; `device` is its end of the bus."""

    device: mks.Device

    def __init__(
        self,
        motor: NodeMotor,
        firmware: mks.Version,
        flash: Flash,
        quirks: MksQuirks,
        bits_s: int,
    ) -> None:
        self.motor = motor
        self.port = NodePort()
        self.firmware, self.flash, self.quirks = firmware, flash, quirks
        self.remake()
        self.motion = MksNodeMotion(
            motor,
            flash,
            quirks,
            minds_arrival=mks.Ability.ARRIVAL in self.device.abilities,
            says=self.tell,
            lets_go=self._let_go,
        )
        self.enabled = quirks.enabled_on
        self.calibrated = True
        self.stalled = False
        self.power_on_zero = motor.zero
        self._bits_s = bits_s
        self._deaf_until_s = -math.inf  # it writes a setting into its flash
        self.begin(0.0)

    # Frames and time.

    def listens(self, can_id: int) -> bool:
        """Return whether it takes frames with an id from the bus."""
        return self.port.plugged and can_id in (mks.BROADCAST, self.device.node)

    def receive(self, frame: Frame, now_s: float) -> None:
        """Carry out a frame's request, if it is awake and uses the bit rate of the bus."""
        deaf = not self.port.awake or now_s < self._deaf_until_s
        if deaf or self.flash.of(mks.SetBitrate).bitrate.bits_s != self._bits_s:
            return
        self.motion.feed_watchdog(now_s)
        asked = self.device.hear(frame)
        if asked is not None:
            if asked.request.code is not Code.ABSOLUTE_AXIS:  # streamed targets need no reading
                self.motor.look(now_s)
            self._obey(asked, now_s)

    def due_s(self) -> float:
        """Return when it next acts by itself, apart from controlling its shaft."""
        if not self.port.powered:
            return math.inf
        if self.port.booting:
            return self.port.boots_s
        return self.motion.due_s()

    def live(self, now_s: float) -> None:
        """Do what is due by now."""
        if self.port.booting and self.port.boots_s <= now_s:
            self.begin(now_s)
        if self.port.awake:
            self.motion.live(now_s)

    @property
    def raw_counts(self) -> int:
        """The position regardless of any zero that was set since it was powered."""
        return self.motor.shaft - self.power_on_zero

    @property
    def busy(self) -> bool:
        """Whether it carries out a motion."""
        return self.motion.under_way is not None

    def tell(self, asked: Asked, outcome: Outcome) -> None:
        """Report the outcome of a request; the end of a motion only if the quirks allow that."""
        withheld = self.port.withheld or not self.quirks.says_done
        quiet = withheld and outcome is Outcome.DONE and asked is self.motion.under_way
        self.port.say(None if quiet else self.device.tell(asked, outcome))

    # Power.

    def forget(self, now_s: float) -> None:
        """Release the shaft, and forget what is lost without power."""
        self.motor.release(now_s)
        self._restart_firmware(now_s)
        self.remake()

    def begin(self, now_s: float) -> None:
        """Start the firmware: it has kept the settings, but not the position."""
        self._restart_firmware(now_s)
        self.remake()
        turned = self.motor.shaft % COUNTS_PER_TURN if self.quirks.keeps_angle else 0
        self.motor.zero = self.power_on_zero = self.motor.shaft - turned
        self.set_enabled(self.quirks.enabled_on, now_s)

    def restart(self, now_s: float) -> None:
        """Restart: for a while the shaft is free and no question is answered."""
        self.forget(now_s)
        self.port.boots_s = now_s + BOOT_S

    def set_enabled(self, on: bool, now_s: float) -> None:
        """Switch the motor's current; a motor that is on already continues its motion."""
        self.enabled = on
        if not on:
            self.motion.drop()
            self.motor.release(now_s)
        elif not self.motor.holding:
            self.motor.hold(now_s)

    def put(self, setting: mks.Setting, now_s: float) -> None:
        """Store a setting, and be deaf meanwhile."""
        self.flash.put(setting)
        self._deaf_until_s = now_s + self.quirks.flash_ms / 1000

    # What a person changes and sees.

    def set_id(self, node: int, now_s: float) -> int:  # noqa: ARG002
        """Change the id, as its keys do; return the old one. Raises `BadRequest`."""
        try:
            setting = mks.SetId(node)
        except BadField as error:
            raise BadRequest(str(error)) from None
        before = self.flash.of(mks.SetId).node
        self.flash.put(setting)
        self.remake()
        return before

    def set_mode(self, mode: int, now_s: float) -> int:
        """Change the mode, as its keys do; return the old one. Raises `BadRequest`."""
        modes = [*mks.Mode]
        if mode not in modes:
            raise BadRequest(f"modes are {int(modes[0])} to {int(modes[-1])}, not {mode}")
        before = self.flash.mode
        self.motion.halt(now_s)
        self.flash.put(mks.SetMode(mks.Mode(mode)))
        return before

    def seen(self, error: int, now_s: float) -> dict[str, Json]:
        """Return the data it would report, given its shaft's distance from the set-point."""
        timeout_s = self.flash.timeout_s
        return {
            "id": self.device.node,
            "firmware": ".".join(map(str, self.firmware)),
            "powered": self.port.powered,
            "mode": self.flash.mode.name.lower(),
            "enabled": self.enabled,
            "stalled": self.stalled,
            "state": self.motion.state(now_s).name.lower(),
            "rpm": round(self.motor.point.rate(now_s) / COUNTS_S_PER_RPM, 2),
            "error_counts": error,
            "watchdog_s": 0.0 if math.isinf(timeout_s) else timeout_s,
            "watchdog_stops": self.motion.watchdog_stops,
        }

    def known(self) -> SavedMksDrive:
        """Return its settings, and whether it holds its shaft."""
        homed = self.motion.homing is mks.HomingState.DONE
        settings = self.flash.to_json()
        return SavedMksDrive(self.port.powered, self.enabled, self.stalled, homed, settings)

    def recall(self, saved: SavedMksDrive) -> None:
        """Restore what `known` returned, once its power is known. Raises `StateFileError`."""
        self.stalled = saved.stalled
        self.motion.homing = mks.HomingState.DONE if saved.homed else None
        self.flash.recall(saved.settings)
        self.remake()
        self.enabled = saved.enabled
        self.motor.recall(self.enabled and self.port.awake)

    def _obey(self, asked: Asked, now_s: float) -> None:
        row = COMMANDS.get(type(asked.request))
        if row is None:
            return
        if row.able(self, asked, now_s):
            row.does(self, asked, now_s)
            if row.says is not None:
                self.tell(asked, row.says)
        elif self.quirks.says_refused:
            self.tell(asked, Outcome.FAILED)

    def remake(self) -> None:
        """Create its codec, by its settings."""
        self.device = mks.Device(
            self.flash.of(mks.SetId).node,
            self.firmware,
            replies=self.flash.of(mks.SetReplies).mode,
        )

    def _restart_firmware(self, now_s: float) -> None:
        self.stalled = False
        self.motion.forget(now_s)
        self.port.boots_s = -math.inf

    def _let_go(self, now_s: float) -> None:
        self.stalled = True
        self.set_enabled(False, now_s)


# --- Requests ------------------------------------------------------------------------------------

# What a drive does with a request (an `Asked`).
Act: TypeAlias = Callable[[MksNode, Any, float], None]


@dataclass(frozen=True, slots=True)
class Command:
    """What a drive does with a request, what it then reports, and when it is able to.

    Without `says`, `does` sends the answer, or none is sent. A request that the drive is not able
    to carry out now is refused.
    """

    does: Act
    says: Outcome | None = Outcome.DONE
    able: Callable[[MksNode, Any, float], bool] = lambda *_: True


def _free(node: MksNode) -> bool:
    """Return whether it takes motions: enabled, not stalled, in mode 5, not homing."""
    able = node.enabled and not node.stalled and node.flash.mode is mks.Mode.BUS_FOC
    return able and not node.motion.searching


def _moves(node: MksNode, _: Asked, now_s: float) -> bool:
    """Return whether it takes a motion: it stands, or the motion may replace the present one."""
    replaces = node.motion.armed or mks.Ability.RETARGET in node.device.abilities
    return _free(node) and (replaces or not node.motion.moving(now_s))


def _move(node: MksNode, asked: Asked, now_s: float) -> None:
    """Begin a motion; report the replaced one as failed, before or after.

    An armed drive reports the motion as stored and forgets it, because a common start is ignored.
    """
    motion, before = node.motion, node.motion.under_way
    if motion.armed:
        node.tell(asked, Outcome.STORED)
        return
    absolute = before is not None and isinstance(before.request, mks.MoveAbsoluteAxis)
    says = node.quirks.superseded if absolute and motion.moving(now_s) else "never"
    if before is not None and says == "first":
        node.tell(before, Outcome.FAILED)
    if motion.ignores_next:
        motion.ignores_next = False
    else:
        motion.begin(asked, now_s)
    node.tell(asked, Outcome.STARTED)
    if before is not None and says == "last":
        node.tell(before, Outcome.FAILED)


def _searches(node: MksNode, asked: Asked, now_s: float) -> bool:
    """Return whether it begins to home or calibrate: it stands, and has that homing method."""
    method = node.flash.homing.method if isinstance(asked.request, mks.Home) else 0
    return _free(node) and not node.motion.moving(now_s) and method <= AGAINST_A_STOP


def _stop(node: MksNode, asked: Asked, now_s: float) -> None:
    node.motion.give_up(now_s)
    node.motion.begin(asked, now_s)


def _enable(node: MksNode, asked: Any, now_s: float) -> None:
    if not asked.request.on:
        node.motion.give_up(now_s)
    node.set_enabled(asked.request.on, now_s)


def _clear(node: MksNode, _: Asked, now_s: float) -> None:
    if node.stalled:
        node.stalled = False
        node.set_enabled(True, now_s)


def _set(node: MksNode, asked: Any, now_s: float) -> None:
    setting = asked.request
    if isinstance(setting, mks.SetMode) and setting.mode is not mks.Mode.BUS_FOC:
        node.motion.halt(now_s)
    node.put(setting, now_s)
    node.tell(asked, Outcome.DONE)
    node.remake()


def _tell_setting(node: MksNode, asked: Any, _: float) -> None:
    code = asked.request.setting
    reading = mks.SettingRead(code, node.flash.get(code).payload)
    node.port.say(node.device.answer(asked, reading))


def _tell(node: MksNode, asked: Asked, now_s: float) -> None:
    node.port.say(node.device.answer(asked, READINGS[asked.request.code](node, now_s)))


_MOVE = Command(_move, None, _moves)
_SEARCH = Command(
    lambda node, asked, now_s: node.motion.begin(asked, now_s), Outcome.STARTED, _searches
)
# fmt: off
# Requests without a row, the other kinds of motion (F4, F6, FD, FE, 4B), are ignored.
COMMANDS: Mapping[type, Command] = MappingProxyType({
    mks.MoveAbsoluteAxis: _MOVE,
    mks.Home: _SEARCH, mks.Calibrate: _SEARCH,
    mks.Stop: Command(_stop, Outcome.STARTED),
    mks.EmergencyStop: Command(lambda node, _, now_s: node.motion.halt(now_s)),
    mks.ArmSynchronous: Command(lambda node, asked, _: node.motion.arm(asked.request.on)),
    mks.Enable: Command(_enable, able=lambda node, asked, _: (
        node.flash.mode.on_bus and not (asked.request.on and node.stalled))),
    mks.ClearStall: Command(_clear),
    mks.SetZero: Command(lambda node, *_: node.motor.count_from(0),
                         able=lambda node, _, now_s: not node.motion.moving(now_s)),
    mks.ReadSetting: Command(_tell_setting, None),
    **dict.fromkeys(get_args(mks.Read), Command(_tell, None)),
    **dict.fromkeys(get_args(mks.Setting), Command(_set, None)),
})
# fmt: on

# --- Readings ------------------------------------------------------------------------------------


def _angle_error(node: MksNode, now_s: float) -> mks.AngleErrorRead:
    error = node.motor.point.at(now_s) - node.motor.shaft
    return mks.AngleErrorRead(round(error * mks.ANGLE_ERROR_PER_TURN / COUNTS_PER_TURN))


def _homing(node: MksNode, _: float) -> mks.HomingRead:
    """Return the homing state; a drive that was never homed reports "failed"."""
    if mks.Ability.HOMING_BY_COMMAND_READ not in node.device.abilities:
        return mks.HomingRead(mks.HomingState.FAILED)
    found = mks.HomingState.FAILED if node.motion.homing is None else node.motion.homing
    return mks.HomingRead(mks.HomingState.FAILED, found)


def _version(node: MksNode, _: float) -> mks.VersionRead:
    return mks.VersionRead(node.calibrated, BOARD, node.firmware, node.quirks.e_series)


# fmt: off
READINGS: Mapping[Code, Callable[[MksNode, float], mks.Reading]] = MappingProxyType({
    Code.ENCODER: lambda node, _: mks.EncoderRead(
        node.raw_counts if node.quirks.keeps_count else node.motor.counts),
    Code.RAW_ENCODER: lambda node, _: mks.RawEncoderRead(node.raw_counts),
    Code.ANGLE_ERROR: _angle_error,
    Code.ENABLED: lambda node, _: mks.EnabledRead(node.enabled),
    Code.STALL: lambda node, _: mks.StallRead(node.stalled),
    Code.STATE: lambda node, now_s: mks.StateRead(node.motion.state(now_s)),
    Code.HOMING_STATE: _homing,
    Code.VERSION: _version,
})
# fmt: on
