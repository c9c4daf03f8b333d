"""A controller in simulated time without the engine; subclasses add the device on its wire."""

import math
from collections.abc import Callable
from heapq import heappop, heappush
from itertools import count

from armdrive.dialects.controller import Controller
from armdrive.sim.device import SimDevice
from armdrive.sim.simulated_arm import link_to
from armdrive.sim.wire import MemoryLink
from armdrive.tasks import Alert, Event, Progress, ProtocolWarning, SwitchOn
from firmware_protocol.frames import Frame, Unpacker, pack
from kinematics import Motors


class DriverBench:
    """A controller that carries out requests while time passes."""

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        self.now_s = 0.0
        self.heard: list[Event] = []
        self.sent: list[tuple[float, Frame]] = []
        self.dead = False
        """Whether the host is dead or suspended."""
        self.at_s: dict[float, Callable[[], object]] = {}
        """What the test does at moments, by the time in s."""

    def do(self, request, longest_s: float = 20.0):
        """Carry out a request, and return its reply."""
        self.begin(request)
        return self.finish(longest_s)

    def begin(self, request) -> None:
        """Begin a request."""
        self.controller.begin(request, self.now_s)
        self._send()

    def finish(self, longest_s: float = 20.0):
        """Let time pass until the request has a reply, and return it."""
        end_s = self.now_s + longest_s
        while self.now_s < end_s:
            if (reply := self.reply()) is not None:
                return reply
            self._step(end_s)
        raise AssertionError("no reply")

    def run(self, time_s: float) -> None:
        """Let time pass."""
        end_s = self.now_s + time_s
        while self.now_s < end_s:
            self._step(end_s)

    def ready(self):
        """Switch the drives on."""
        reply = self.do(SwitchOn())
        assert str(reply) == "done", reply
        return self

    def alerts(self) -> list[Alert]:
        """Return the alerts that were fetched so far."""
        return [event for event in self.heard if isinstance(event, Alert)]

    def reply(self):
        """Return the reply to the request, None if there is none yet; record all other events."""
        while (event := self.controller.next_event()) is not None:
            self.heard.append(event)
            if not isinstance(event, Alert | ProtocolWarning | Progress):
                return event
        return None

    def _due_s(self, *times: float) -> float:
        """Return the earliest of these times and of those at which something is due."""
        due_s = min((*times, *self.at_s))
        return due_s if self.dead else min(due_s, self.controller.next_s())

    def _pass_to(self, now_s: float) -> None:
        """Let time pass, and do what is due then."""
        self.now_s = max(self.now_s, now_s)
        for at_s in [at_s for at_s in self.at_s if at_s <= self.now_s]:
            self.at_s.pop(at_s)()

    def _step(self, end_s: float) -> None:
        raise NotImplementedError

    def _send(self) -> None:
        raise NotImplementedError


class SerialBench(DriverBench):
    """A controller on the wire of a simulated board."""

    def __init__(self, controller: Controller, device: SimDevice) -> None:
        super().__init__(controller)
        self.device, self.link = device, link_to(device)

    def _step(self, end_s: float) -> None:
        self._pass_to(self._due_s(end_s, self.link.next_s()))
        self.controller.receive(self.link.read(self.now_s), self.now_s)
        self._send()

    def _send(self) -> None:
        if data := self.controller.advance(self.now_s):
            self.link.write(data, self.now_s)


BOTH, ORDERS, ANSWERS = (True, False), (True,), (False,)
"""The senders whose frames are delayed: the host, the drives, or both."""


class FramesUnderWay:
    """Frames that were sent, by the time at which they arrive; of one time, the earliest first."""

    def __init__(self) -> None:
        self._frames: list[tuple[float, int, bytes]] = []
        self._numbers = count()

    @property
    def next_s(self) -> float:
        """When the next one arrives; infinity if none is under way."""
        return self._frames[0][0] if self._frames else math.inf

    def send(self, data: bytes, arrives_s: float) -> None:
        """Send one."""
        heappush(self._frames, (arrives_s, next(self._numbers), data))

    def arrived(self, now_s: float) -> bytes:
        """Take those that have arrived."""
        data = b""
        while self._frames and self._frames[0][0] <= now_s:
            data += heappop(self._frames)[2]
        return data


class BusBench(DriverBench):
    """A controller and the simulated drives of an arm on one bus that can lose or delay frames.

    `loses` and `waits_s` get a frame, and whether the host has sent it.
    """

    def __init__(self, controller: Controller, device: SimDevice, link: MemoryLink) -> None:
        super().__init__(controller)
        self.device, self.link = device, link
        self.loses: Callable[[Frame, bool], bool] = lambda frame, host: False
        """Whether a frame is lost."""
        self.waits_s: Callable[[Frame, bool], float] = lambda frame, host: 0.0
        """How long a frame is delayed."""
        self._to, self._back = FramesUnderWay(), FramesUnderWay()
        self._of_host, self._of_drives = Unpacker(), Unpacker()

    @property
    def positions(self) -> Motors:
        """The counts of the drives."""
        return self.device.registers

    def say(self, *frames: bytes) -> None:
        """Make the driver receive frames that no drive has sent."""
        for data in frames:
            self._back.send(data, self.now_s)

    def delay_frames(self, for_s: float, sides: tuple[bool, ...] = BOTH, node: int = 0) -> None:
        """Hold back the frames of the bus or of one drive for a time; then deliver all at once."""
        end_s, waits_s = self.now_s + for_s, self.waits_s

        def held_s(frame: Frame, host: bool) -> float:
            held = host in sides and node in (0, frame.can_id)
            return max(waits_s(frame, host), (end_s - self.now_s) * held)

        self.waits_s = held_s

    def suspend(self, for_s: float) -> Motors:
        """Suspend the program; return where the shafts are when it resumes.

        At its next step it receives all frames of that time at once.
        """
        self.dead = True
        self.run(for_s)
        self.dead = False
        return self.positions

    def check_stands(self, for_s: float = 2.0) -> None:
        """Check that no shaft turns for a while."""
        stood = self.positions
        self.run(for_s)
        assert self.positions == stood

    def alerts(self) -> list[Alert]:
        """Return the alerts so far."""
        self.reply()
        return super().alerts()

    def _step(self, end_s: float) -> None:
        back_s = math.inf if self.dead else self._back.next_s
        self._pass_to(self.link.run(self._due_s(end_s, self._to.next_s, back_s)))
        if passing := self._to.arrived(self.now_s):
            self.link.write(passing, self.now_s)
        for frame in self._of_drives.feed(self.link.read(self.now_s)):
            if not self.loses(frame, False):
                self._back.send(pack(frame), self.now_s + self.waits_s(frame, False))
        if self.dead:
            return
        if heard := self._back.arrived(self.now_s):
            self.controller.receive(heard, self.now_s)
        self._send()

    def _send(self) -> None:
        if self.dead:
            return
        for frame in self._of_host.feed(self.controller.advance(self.now_s)):
            self.sent.append((self.now_s, frame))
            if not self.loses(frame, True):
                self._to.send(pack(frame), self.now_s + self.waits_s(frame, True))
        if passing := self._to.arrived(self.now_s):
            self.link.write(passing, self.now_s)
