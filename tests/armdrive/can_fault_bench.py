"""Arms on CAN drives with faults: what is sent, how the arm stands, and how it is brought back.

Two tables of faults use this module: faults found when connecting, and faults in motion.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import pytest

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import ArmError, DeviceFault
from armdrive.registry import simulate
from armdrive.runtime.clock import SimulatedClock
from armdrive.sim.simulated_arm import SimulatedArm
from armdrive.status import Current, State, Trust
from firmware_protocol.canopen import CONTROLWORD, MODE, TARGET_POSITION, Service, service_of
from firmware_protocol.frames import Frame, Unpacker
from firmware_protocol.mks import Enable, Home, Motion, decode_request
from kinematics import Joints

START = Joints.of(0.0, 40.0, -80.0, -40.0, 0.0)
NEAR = 8
"""How many counts a holding drive may be off its target."""
SETTLED_S = 1.0
"""Longer than a drive takes to boot, or an arm to sag."""
FOUND_S = 0.6
"""The driver notices a missing drive within this time, and stops the others."""
ENDED = (State.ERROR_STOP, State.DISCONNECTED)
GOAL = {"base_deg": 40, "shoulder_deg": 60, "elbow_deg": -50}
LOOK_S = 0.01
BOOTED_S = 0.5
_ENABLES = 0x03
"""The bits of a controlword that switch a motor on."""
_COMMANDS = frozenset(place.index for place in (CONTROLWORD, MODE, TARGET_POSITION))


def commands_motion_mks(frame: Frame) -> bool:
    """Return whether a frame switches a motor on or moves it."""
    request = decode_request(frame)
    return isinstance(request, Motion | Home) or request == Enable(on=True)


def commands_motion_cia402(frame: Frame) -> bool:
    """Return whether a frame switches a motor on or moves it, by PDO or by writing an object."""
    service = (service_of(frame.can_id) or (None,))[0]
    if service is Service.RPDO1:
        return frame.data[0] & _ENABLES == _ENABLES
    writes = service is Service.SDO_REQUEST and frame.data[0] >> 5 == 1
    return writes and int.from_bytes(frame.data[1:3], "little") in _COMMANDS


COMMANDS_MOTION = {"mks": commands_motion_mks, "cia402": commands_motion_cia402}


@dataclass
class Bus:
    """A simulated arm in the air with its clock, and a record of what the host sends."""

    dialect: str
    options: dict = field(default_factory=dict)
    settings: dict = field(default_factory=dict)

    def __post_init__(self) -> None:
        config = simulated_config(self.dialect)
        self.config = replace(config, device=replace(config.device, **self.settings))
        self.clock = SimulatedClock()
        self.sent: list[Frame] = []
        self.tried = False
        self.find(simulate(self.config, **self.options))
        self.twin.device.bring_to(START, 20.0)

    def find(self, twin: SimulatedArm) -> None:
        """Use the drives of another simulated arm."""
        self.twin, unpacker, send = twin, Unpacker(), twin.link.line.send

        def record(data: bytes, now_s: float) -> None:
            self.sent += unpacker.feed(data)
            send(data, now_s)

        twin.link.line.send = record

    @property
    def motors(self):
        """Where the physical motors stand."""
        return self.twin.world.motors

    @property
    def motion_frames(self) -> list[Frame]:
        """The frames that were sent to switch a motor on or to move it."""
        return [frame for frame in self.sent if COMMANDS_MOTION[self.dialect](frame)]

    def fault(self, *words: str) -> None:
        """Inject faults while no program is connected, and let the arm come to rest."""
        for each in words:
            self.twin.faults.add(*each.split())
        self.settle()

    def settle(self) -> None:
        """Let time pass for drives without a program."""
        self.clock.now_s += SETTLED_S
        self.twin.link.line.advance(self.clock.now_s)

    def connect(self) -> Arm:
        """Connect; after a failure, connect again as the same program would."""
        if self.tried:  # an adapter that has left the bus comes back
            self.twin.link.reopen()
        self.tried = True
        return Arm(connect_simulated(self.config, twin=self.twin, pace=self.clock))

    def ready(self) -> Arm:
        """Connect, enable, and reference the arm where it stands."""
        arm = self.connect()
        arm.enable()
        arm.reference.declare(START, opening_mm=20.0)
        return arm


def check_works_again(arm: Arm, stood=None) -> None:
    """Bring a repaired arm back as a person does, and check that it moves on request only."""
    world = arm.twin.world
    if arm.status.state is State.DISCONNECTED:
        arm.reconnect()
    if arm.status.state is State.ERROR_STOP:
        arm.reset()
    try:
        arm.enable()
    except DeviceFault as error:  # a drive in fault has to be reset first
        if "`reset()` clears that" not in str(error):
            raise
        arm.reset()
        arm.enable()
    assert arm.status.state is State.STANDBY
    assert arm.status.current is Current.HELD
    assert stood is None or (world.motors - stood).largest <= NEAR
    arm.reference.declare(world.joints, opening_mm=world.opening_mm)
    before = world.motors
    arm.move_j(base_deg=2)
    assert world.motors != before
    assert (world.motors - arm.status.acknowledged).largest <= NEAR


def fail_in_motion(
    arm: Arm,
    fault: str | Callable[[], object],
    goal=GOAL,
    after_s: float = 0.6,
    watched_s: float = 4.0,
) -> tuple[str, float]:
    """Inject a fault in a motion; return the error's words, and how long the arm moved on."""
    began_s = arm.parts.pace.now_s() + after_s
    begin = (lambda: arm.twin.faults.add(*fault.split())) if isinstance(fault, str) else fault
    arm.twin.device.at(began_s, begin)
    handle = arm.move_j(wait=False, **goal)
    arm.sleep(after_s)
    stood, moved_s = arm.twin.world.motors, 0.0
    while arm.parts.pace.now_s() < began_s + watched_s:
        arm.sleep(LOOK_S)
        arm.twin.link.line.advance(arm.parts.pace.now_s())  # the drives go on without a cable
        if (now := arm.twin.world.motors) != stood:
            stood, moved_s = now, arm.parts.pace.now_s() - began_s
    with pytest.raises(ArmError) as failed:
        handle.wait()
    return str(failed.value), moved_s


def check_reported_and_stopped(arm: Arm, words: str, code: str, fault, **times: float) -> None:
    """Inject a fault in a motion; check the error, and that the arm stands in time."""
    bound_s = arm.status.silent_time_s
    said, moved_s = fail_in_motion(arm, fault, **times)
    assert re.search(words, said), said
    assert "garbled" not in said
    assert "refused a valid motion" not in arm.status.trust_reason
    assert moved_s <= bound_s + FOUND_S
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.state in ENDED
    assert arm.status.error_code == code
    assert re.search(words, arm.status.error), arm.status.error


def check_recovery(arm: Arm, stood=None) -> None:
    """End the faults, and check that the same program can bring the arm back."""
    arm.twin.faults.end()
    arm.sleep(BOOTED_S)
    check_works_again(arm, stood)
