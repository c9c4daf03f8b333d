"""New drives on a simulated bus, a simulated person with scripted answers, and a record of it."""

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

from served import ServedDevice

from armdrive.config.arm import ArmConfig, ConfigSource
from armdrive.config.sections import Connection
from armdrive.dialects.bus.tools import IDS, DriveDialog, Listened, Survey, frame_scripts, listen
from armdrive.dialects.mks.settings import MksSettings
from armdrive.dialects.mks.survey import ask_round
from armdrive.dialog import About, Question
from armdrive.registry import simulate
from armdrive.setup.commissioning import (
    CommissioningOutcome,
    CommissioningPlan,
    commission,
    plan_of,
)
from armdrive.setup.dialog_runner import DialogClock, carry_out, drive_dialog
from armdrive.setup.prober import is_command
from armdrive.setup.simulated_person import SimulatedPerson
from armdrive.sim.mks import MksBoard
from armdrive.sim.serving import make_server
from armdrive.transports.opening import open_link
from firmware_protocol.errors import ProtocolError
from firmware_protocol.frames import Frame, Unpacker, pack
from firmware_protocol.mks import Code, Request, decode_request
from kinematics import ArmModel, preset

MODEL = preset("minimover5-mks")
NAMES = tuple(motor.name for motor in MODEL.transmission.motors)
MOST_QUESTIONS = 300
TURNING = frozenset(
    {Code.RELATIVE_AXIS, Code.ABSOLUTE_AXIS, Code.SPEED_MODE, Code.RELATIVE_PULSES}
    | {Code.ABSOLUTE_PULSES, Code.HOME, Code.CALIBRATE}
)
READING = frozenset(code for code in Code if code < Code.CLEAR_STALL) | {
    Code.STALL,
    Code.VERSION,
    Code.STATE,
}


def arm(model: ArmModel = MODEL, **mks: Any) -> ArmConfig:
    """Return the configuration of an arm on six MKS drives."""
    connection = Connection("mks", "", 500_000)
    source = ConfigSource({"model": "minimover5-mks"})
    device = MksSettings(**mks)
    return ArmConfig("bench", model.title, model, connection, device=device, source=source)


class Person(SimulatedPerson):
    """A person who sees the arm; `says` has other answers, by a part or kind of the question."""

    def __init__(self, twin: Any, plan: CommissioningPlan) -> None:
        super().__init__(twin, self._told)
        self.unplug_all(len(plan.drives))
        self.heard: list[str] = []
        self.asked: list[Question] = []
        self.says: dict[str | About, str | Callable[[], str]] = {}

    def _told(self, text: str) -> None:
        self.heard.append(text)

    @property
    def text(self) -> str:
        """All that the person was told."""
        return "\n".join(self.heard)

    def answer(self, asked: Question) -> Any:
        """Answer as the test says, else as a person who looks and agrees."""
        self.asked.append(asked)
        assert len(self.asked) < MOST_QUESTIONS, f"asked for ever: {asked.words}"
        for key, word in self.says.items():
            fits = asked.about is key if isinstance(key, About) else key in asked.words
            if fits:
                if asked.about is About.CONNECT:
                    super().answer(asked)
                return asked.read(word if isinstance(word, str) else word())
        return super().answer(asked)


class Bench:
    """A bus with new drives, and the dialog that sets them up."""

    def __init__(self, config: ArmConfig | None = None, **settings: Any) -> None:
        self.config = config or arm()
        self.plan = plan_of(self.config)
        self.twin = simulate(arm(), **({"factory": True} | settings))
        assert isinstance(self.twin.board, MksBoard)
        self.device = self.twin.device
        self.board: Any = self.twin.board
        self.clock = DialogClock()
        self.person = Person(self.twin, self.plan)
        self.said: list[tuple[int, Request]] = []
        self._spy()

    def walk(self, *, again: bool = False) -> CommissioningOutcome:
        """Run the whole dialog."""
        return commission(self.dialog, self.plan, again=again)

    def one(self, name: str = "shoulder", *, again: bool = False) -> int | None:
        """Run the dialog about one motor; return its current, None if it is not ready."""
        drive = next(each for each in self.plan.drives if each.name == name)
        return self.plan.tools.set_up(self.dialog, self.config, drive, again)

    @property
    def dialog(self) -> DriveDialog:
        """A new dialog with the person."""
        return drive_dialog(self.twin.link, self.plan.scripts(), self.clock, self.person)

    def at_waits(self, happens: Callable[[], object]) -> None:
        """Have something happen before each wait of the dialog."""
        sleep = self.clock.sleep

        def waits(link: Any, until_s: float) -> None:
            happens()
            sleep(link, until_s)

        self.clock.sleep = waits  # type: ignore[method-assign]

    def at_first_wait(
        self, happens: Callable[[], object], when: Callable[[], bool] = lambda: True
    ) -> None:
        """Have something happen before the first wait at which something else is so."""
        done: list[bool] = []

        def once() -> None:
            if not done and when():
                done.append(True)
                happens()

        self.at_waits(once)

    def script(self, script: Callable[..., Any], *args: Any) -> Any:
        """Run a script on the wire."""
        return self.dialog.on_wire(script, *args)

    def survey(self, ids: Sequence[int] = IDS) -> Survey:
        """Query these ids, and return the drives that reply."""
        scripts = self.plan.bus.scripts(ids)
        found: Survey = carry_out(
            scripts, partial(ask_round, scripts.io), self.twin.link, self.clock
        )
        return found

    def listen(self, seconds: float) -> Listened:
        """Listen to the bus without sending."""
        frames = frame_scripts()
        look = partial(listen, frames.io, is_command, seconds)
        return carry_out(frames, look, self.twin.link, self.clock)

    def codes(self) -> set[Code]:
        """Return the codes of all requests to drives."""
        return {request.code for _, request in self.said}

    def ids(self) -> tuple[int, ...]:
        """Return the ids of the drives, in the order of the motors."""
        return tuple(node.device.node for node in self.board.nodes)

    def flashes(self) -> list[dict[str, Any]]:
        """Return the settings in the drives' flash memories."""
        return [node.flash.to_json() for node in self.board.nodes]

    def _spy(self) -> None:
        line, unpacker = self.twin.link.line, Unpacker()
        send = line.send

        def sent(data: bytes, now_s: float) -> None:
            self.said += [(each.can_id, _request(each)) for each in unpacker.feed(data)]
            send(data, now_s)

        line.send = sent  # type: ignore[method-assign]


def _request(frame: Frame) -> Request:
    try:
        return decode_request(frame)
    except ProtocolError as error:
        raise AssertionError(f"{frame} is no request: {error}") from None


@contextmanager
def another_program(port: str, *frames: Frame) -> Iterator[None]:
    """Have another program say the same frames on a bus, over and over."""
    link, ended = open_link(port, 0), threading.Event()

    def speak() -> None:
        while not ended.wait(0.01):
            for frame in frames:
                link.write(pack(frame), 0.0)

    speaking = threading.Thread(target=speak, daemon=True)
    speaking.start()
    try:
        yield
    finally:
        ended.set()
        speaking.join()
        link.close()


class ServedBus(ServedDevice):
    """New or set-up drives in real time, behind one or two adapters on pseudo-terminals."""

    def __init__(self, folder: Any, **settings: Any) -> None:
        server = make_server(slcan=folder / "can0", listener=folder / "can1")
        self.port, self.beside = server.can_addresses
        super().__init__(server, simulate(arm(), **settings).device)
