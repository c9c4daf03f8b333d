"""A small master on a simulated bus of CiA 402 drives: it asks, and lets simulated time pass."""

from functools import partial
from typing import Any

from bus_sim import LONG_S, BusSim, bus_arm

from armdrive.config.arm import ArmConfig
from armdrive.sim.cia402.objects import dictionary
from firmware_protocol import canopen
from firmware_protocol.frames import Frame, Unpacker, pack

TURN = 10_000
MASTER = 127
arm_config = partial(bus_arm, "cia402")
PERIOD_S = 0.01
OBJECTS = dictionary()
ORDER = canopen.Mapping.of_objects(
    OBJECTS, canopen.CONTROLWORD, canopen.MODE, canopen.TARGET_POSITION
)
STATE = canopen.Mapping.of_objects(
    OBJECTS, canopen.STATUSWORD, canopen.MODE_SHOWN, canopen.POSITION
)
QUICK_STOP = canopen.Controlword.of(canopen.Command.QUICK_STOP).value
ENABLE = canopen.Controlword.of(canopen.Command.ENABLE_OPERATION).value
PP, HOMING, CSP = (
    canopen.OperationMode.PROFILE_POSITION,
    canopen.OperationMode.HOMING,
    canopen.OperationMode.CYCLIC_POSITION,
)


def setups(node: int) -> tuple[canopen.Write, ...]:
    """Return the writes that set up the two PDOs that carry all of a motion."""
    return (
        *canopen.first_pdo(canopen.Direction.RECEIVED, node, ORDER),
        *canopen.first_pdo(canopen.Direction.TRANSMITTED, node, STATE),
    )


class Bench(BusSim[Frame]):
    """The twin of an arm, and a master at the other end of its bus."""

    def __init__(
        self, *, config: ArmConfig | None = None, saved: object = None, **settings: Any
    ) -> None:
        super().__init__(config or arm_config(), saved, **settings)
        self._clients = {node: canopen.SdoClient(node) for node in range(1, 127)}
        self._unpacker = Unpacker()

    # Time and frames.

    def send(self, frame: Frame) -> None:
        """Put a frame on the bus."""
        self.link.write(pack(frame), self.now_s)

    def tell(self, frame: Frame, seconds: float = LONG_S) -> list[Frame]:
        """Put a frame on the bus and return what is heard soon after."""
        self.send(frame)
        return self.run(seconds)

    def _read(self) -> None:
        for frame in self._unpacker.feed(self.link.read(self.now_s)):
            self.heard.append((self.now_s, frame))

    # SDO.

    def read(self, node: int, place: canopen.Place) -> Any:
        """Ask for an object; returns its value, or the code of the abort."""
        ended = self._sdo(node, self._clients[node].upload(place))
        if isinstance(ended, canopen.Uploaded):
            return OBJECTS.find(place).type.unpack(ended.data, exact=False)
        return ended.code if isinstance(ended, canopen.Aborted) else ended

    def write(self, node: int, place: canopen.Place, value: int) -> Any:
        """Write an object; returns None, or the code of the abort."""
        data = OBJECTS.find(place).type.pack(value)
        ended = self._sdo(node, self._clients[node].download(place, data))
        return ended.code if isinstance(ended, canopen.Aborted) else None

    def _sdo(self, node: int, request: Frame | None) -> Any:
        client = self._clients[node]
        while request is not None:
            answers = [each for each in self.tell(request, 0.003) if each.can_id == 0x580 + node]
            if not answers:
                client.abandon()
                return None
            request = client.receive_frame(answers[-1])
        return client.next_event()

    # Drives.

    def set_up(self, *nodes: int) -> None:
        """Have drives talk by SYNC, and be operational."""
        for node in nodes:
            for number in (2, 3):
                self.write(node, canopen.Place(0x1800 + number - 1, 1), 1 << 31 | 0x181)
            for write in setups(node):
                assert self.write(node, write.place, write.value) is None
            assert self.write(node, canopen.Place(0x60C2, 1), 10) is None
            self.send(canopen.Nmt(canopen.NmtCommand.START, node).frame)
        self.run()

    def order(self, node: int, word: int, mode: int, target: int) -> None:
        """Hand an order over, to be acted on at the next SYNC."""
        self.send(Frame(0x200 + node, ORDER.pack((word, mode, target))))

    def sync(self, seconds: float = PERIOD_S) -> dict[int, tuple[canopen.Statusword, int, int]]:
        """Let the drives act; return what each said of itself: statusword, mode, position."""
        told = {}
        for frame in self.tell(canopen.Sync().frame, seconds):
            if 0x181 <= frame.can_id <= 0x1FF:
                value, mode, position = STATE.unpack(frame.data)
                told[frame.can_id - 0x180] = (canopen.Statusword(value), mode, position)
        return told

    def state(self, node: int) -> canopen.Statusword:
        """Ask a drive what it is."""
        return canopen.Statusword(self.read(node, canopen.STATUSWORD))

    def enable(self, *nodes: int, mode: int = CSP) -> None:
        """Bring drives to operation enabled, where they stand."""
        for node in nodes:
            assert self.write(node, canopen.MODE, mode) is None
            self.write(node, canopen.TARGET_POSITION, self.read(node, canopen.POSITION))
            for command in (
                canopen.Command.SHUT_DOWN,
                canopen.Command.SWITCH_ON,
                canopen.Command.ENABLE_OPERATION,
            ):
                assert self.write(node, canopen.CONTROLWORD, command.word) is None

    def beat(self) -> None:
        """Say that the master is alive."""
        self.send(canopen.Heartbeat(MASTER, canopen.NodeState.OPERATIONAL).frame)

    def watch(self, node: int, ms: int) -> None:
        """Have a drive mind the master's silence."""
        assert (
            self.write(node, canopen.CONSUMER_HEARTBEAT, canopen.HeartbeatWatch(MASTER, ms).value)
            is None
        )

    def count(self, node: int) -> int:
        """Ask a drive where it is."""
        return int(self.read(node, canopen.POSITION))
