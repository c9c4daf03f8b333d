"""The simulated Tutor board, and how it is made for an arm."""

from __future__ import annotations

from typing import ClassVar

from armdrive.config.arm import ArmConfig
from armdrive.sim.device import Board, NoSettings
from armdrive.sim.mechanics.motors import CoordinatedDrive
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world import World
from firmware_protocol.tutor import Device, Failed, Move, Ok, Positions, Where
from kinematics.spaces import Motors


class TutorBoard(Board):
    """One command at a time. What comes during a motion waits for its end (a guess)."""

    title: ClassVar[str] = "Tutor board"
    register_range: ClassVar[tuple[int, int]] = (-(1 << 31), (1 << 31) - 1)
    drive: CoordinatedDrive

    def __init__(self, world: World, baud: int) -> None:
        super().__init__(world, CoordinatedDrive(world), baud)
        self._device = Device()
        world.energised = True

    @property
    def busy(self) -> bool:
        """Whether a motion is unanswered."""
        return self.drive.moving

    @property
    def registers(self) -> Motors:
        """The positions, which know only what was commanded."""
        return self.drive.counts

    def receive(self, data: bytes) -> None:
        """Take bytes that have arrived."""
        self._device.receive_data(data)
        self._serve()

    def _serve(self) -> None:
        while not self.busy and (command := self._device.next_event()) is not None:
            match command:
                case Move(rate_hz, steps):
                    self.drive.start(steps, rate_hz, self.now_s)
                case Where():
                    self.outgoing += self._device.send(Positions(tuple(self.registers)))
                case _:
                    self.outgoing += self._device.send(Failed())

    def motion_ended(self) -> None:
        """Answer the command that moved the arm."""
        self.outgoing += self._device.send(Ok())
        self._serve()

    def boot(self) -> None:
        """Hold the arm: the motors always have current."""
        self.drive.energise()

    def forget(self) -> None:
        """Lose half a command."""
        self._device = Device()


def _make(config: ArmConfig, world: World, settings: NoSettings) -> TutorBoard:  # noqa: ARG001
    return TutorBoard(world, config.connection.baud)


KIND = SimDeviceKind(TutorBoard, _make)
