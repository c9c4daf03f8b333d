"""The set-up screen, from a port that nobody knows to an arm file."""

from dataclasses import replace

import pytest
from desk_session import AGAIN_S, Session

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.dialog import ok
from armdrive.errors import PortUnavailable
from armdrive.registry import simulate
from armdrive.registry.arm_files import load_arm
from armdrive.setup.directions import TRIAL_SPEED, sight
from armdrive.setup.ports import ClosedPort
from armdrive.setup.survey import Report
from armdrive.status import Current, State
from armdrive.storage import files as places
from armdrive.storage.files import StateFiles
from tui.app import Job
from tui.setup import Steps
from tui.setup import stages as setup_new
from tui.setup.motors import MotorsStage
from tui.setup.stages import FileToWrite, InterviewAsking, Ports

pytestmark = pytest.mark.usefixtures("own_home")


FILE = 'model = "teachmover"\n\n[connection]\ndialect = "teachmover"\nport = ""\n'


def written(text=FILE):
    path = places.arm_files() / "bench.toml"
    path.write_text(text, encoding="utf-8")
    return path


class Simulated:
    """A simulated arm, and what was asked of its motors; `signs` are how they really count."""

    def __init__(self, config, signs=None):
        true = config.model.transmission
        if signs is not None:
            true = true.with_signs(signs, (1,) * len(true.motors))
        really = replace(config, model=replace(config.model, transmission=true))
        self.arm = Arm(connect_simulated(config, twin=simulate(really)))
        self.asked = []
        self.before = lambda: None
        self._move = self.arm.move_motors
        self.arm.move_motors = self._moved

    def _moved(self, *steps, speed, stops=None):
        self.before()
        self.asked.append((steps, speed))
        return self._move(*steps, speed=speed, stops=stops)

    @property
    def turned(self):
        """How far each motor was turned altogether."""
        return [sum(each) for each in zip(*(steps for steps, _ in self.asked), strict=True)]

    def seen(self, before):
        """Return what is seen of the real arm since these joints and this opening."""
        world = self.arm.twin.world
        return sight(world.body.arm, before[0], world.joints, world.opening_mm - before[1])


class SetupSession(Session):
    """A desk at its set-up screen, with a simulated arm."""

    first = "setup"

    def __init__(self, config=None, signs=None, **more):
        self.simulated = Simulated(config or simulated_config("teachmover"), signs)
        super().__init__(self.simulated.arm, **more)

    async def __aexit__(self, *error):
        await super().__aexit__(*error)
        self.simulated.arm.close()

    @property
    def stage(self):
        return self.screen.stage

    @property
    def words(self):
        return "\n".join(self.text(f"setup-{part}") for part in ("head", "rows", "tail"))

    async def choose(self, step):
        while f"> {step}" not in self.words:
            await self.press("down")
        await self.press("enter")
        await self.settle()

    async def turn(self):
        await self.once("t")

    async def go_through_one(self, key="y"):
        """Turn a motor, bring it back, answer with a key."""
        await self.turn()
        await self.turn()
        await self.press(key)
        if self.stage.check.asks_hand:
            await self.press("y")

    async def go_through(self, seen):
        """Answer for each motor with a key; those that are not named moved as shown."""
        while (trial := self.stage.check.trial) is not None:
            await self.go_through_one(seen.get(trial.name, "y"))


def found_at(monkeypatch, found):
    """Have one port listed, and this found behind it; return what was opened."""
    opened = []

    def probe(port):
        opened.append(port)
        if isinstance(found, Exception):
            raise found
        return found

    monkeypatch.setattr(setup_new, "closed_ports", lambda: (ClosedPort("/dev/arm", (ok("free"),)),))
    monkeypatch.setattr(setup_new, "probe", probe)
    monkeypatch.setattr(setup_new, "look_at", ClosedPort)
    return opened


ROBKO = Report(
    "/dev/arm",
    findings=[ok("it speaks robko01: Robko 01 at 115200 baud")],
    more={"dialect": "robko01", "baud": 115200},
)


async def test_from_a_port_to_a_file_nothing_is_opened_or_written_by_one_press(monkeypatch):
    opened = found_at(monkeypatch, ROBKO)
    async with SetupSession() as session:
        assert "simulated" in session.words
        await session.choose("1 find")
        assert isinstance(session.stage, Ports)
        assert "free" in session.words
        await session.press("enter")
        session.clock.now_s += 2.0
        await session.settle()
        assert "enter AGAIN opens /dev/arm" in session.words
        assert opened == []
        await session.press("enter")
        session.clock.now_s += 0.5
        await session.settle()
        await session.settle()
        assert opened == ["/dev/arm"]
        assert "it speaks robko01" in session.words
        await session.press("enter")
        assert isinstance(session.stage, InterviewAsking)
        await session.keys("'lab3 enter")
        assert session.stage.describing.line == "robko01"  # the template of what was found
        for _ in range(200):
            if isinstance(session.stage, FileToWrite):
                break
            await session.press("enter")
        assert isinstance(session.stage, FileToWrite)
        assert 'port = "/dev/arm"' in session.words
        path = places.arm_files() / "lab3.toml"
        path.write_text(FILE)  # by another program
        await session.twice("enter")
        session.shows("meanwhile", messages="already exists, and is not overwritten")
        assert path.read_text() == FILE
        path.unlink()
        session.clock.now_s += 20.0
        await session.press("enter")
        await session.settle()
        assert not path.exists()
        await session.press("enter", after_s=AGAIN_S)
        session.clock.now_s += 0.5
        await session.settle()
        assert session.stage.written
        assert load_arm(path).connection.dialect == "robko01"
        assert session.simulated.asked == []


async def test_a_port_that_cannot_be_opened_is_said_and_can_be_described_all_the_same(monkeypatch):
    found_at(monkeypatch, PortUnavailable("/dev/arm is held by cura: end it"))
    async with SetupSession() as session:
        await session.choose("1 find")
        await session.twice("enter")
        assert "held by cura" in session.text("messages")
        await session.press("right")
        assert isinstance(session.stage, InterviewAsking)
        await session.press("left")
        assert isinstance(session.stage, Ports)
        await session.press("right")
        await session.keys("'xy backspace")
        assert session.stage.describing.typed == "x"


async def test_another_port_is_typed_whole_and_a_stop_is_never_typed(monkeypatch):
    port = "/dev/serial/by-id/usb-FTDI_FT232R_USB_UART_A50285BI-if00-port0"
    opened = found_at(monkeypatch, Report(port, findings=[ok("no device answers")]))
    async with SetupSession() as session:
        await session.choose("1 find")
        await session.press("down")
        await session.burst(f"'{port}H backspace")
        await session.twice("enter")
        assert opened == [port]
        assert "no device answers" in session.words
        assert "asks again" in session.words
        await session.press("space")
        assert isinstance(session.stage, Steps)
        assert session.simulated.arm.stops == 1


async def test_an_arm_with_a_file_says_so_and_another_one_needs_leaving():
    path = written()
    async with SetupSession(load_arm(path)) as session:
        for step in ("1 find", "2 describe"):
            await session.choose(step)
            assert isinstance(session.stage, Steps)
            assert "leave it (ctrl+q)" in session.text("messages")


@pytest.mark.parametrize("step", ["2 describe", "4 check"])
async def test_a_folder_that_cannot_be_written_is_found_before_the_first_question(
    monkeypatch, step
):
    path = written()
    monkeypatch.setattr(StateFiles, "may_change", lambda files, folder: False)
    config = load_arm(path) if step == "4 check" else None
    async with SetupSession(config) as session:
        await session.choose(step)
        assert isinstance(session.stage, Steps)
        assert session.text("messages").startswith(f"{path.parent} cannot be used (it is not writ")
        assert "make its folder writable" in session.text("messages")


async def test_a_space_in_an_answer_stops_and_keeps_the_answers_and_yet_a_title_has_words():
    path = written()
    async with SetupSession() as session:
        await session.choose("2 describe")
        await session.burst("'bench enter")
        session.shows("a name that is taken", messages="not overwritten")
        assert session.stage.describing.question.key == "name"
        await session.burst("'2 enter")
        template = session.words
        assert "Which template" in template
        await session.burst("'my space")
        assert session.simulated.arm.stops == 1
        assert "> 2 describe it" in session.words
        await session.keys("enter")
        assert "answer: my_" in session.words
        await session.keys("backspace backspace")
        assert session.words == template
        await session.keys("enter")
        assert "Type _ for a space" in session.words
        await session.burst("'My_arm")
        assert "enter: My arm" in session.words
        await session.keys("enter")
        assert session.stage.describing.name == "bench2", "a name is one word"
        assert "Which dialect" in session.words
    assert path.read_text(encoding="utf-8") == FILE


async def test_referencing_asks_as_the_desk_does_and_a_click_marks_a_step():
    async with SetupSession(size=(120, 40)) as session:
        await session.pilot.click("#setup-rows", offset=(6, 2))
        await session.settle()
        assert "> 3 reference it" in session.words
        await session.choose("3 reference")
        assert "referenced" in session.text("messages")
        assert "> 4 check its motors" in session.words, "the next step is marked"
        await session.choose("3 reference")
        assert "> 3 reference" in session.words, "it was referenced before"


# The set-up screen turns each motor a little, and corrects the arm file by what was seen.


async def test_the_motors_are_checked_and_the_file_is_corrected_after_its_difference_is_seen():
    path = written()
    async with SetupSession(load_arm(path)) as session:
        assert str(path) in session.words
        await session.choose("4 check")
        assert isinstance(session.stage, MotorsStage)
        await session.go_through({"elbow": "r", "base": "d", "shoulder": "n"})
        assert {speed for _, speed in session.simulated.asked} == {TRIAL_SPEED}
        assert session.simulated.turned == [0] * 6
        assert "counts the other way: elbow" in session.words
        await session.press("enter")
        assert isinstance(session.stage, FileToWrite)
        assert "+elbow = -1" in session.words
        assert "unclear: shoulder" in session.words
        assert path.read_text(encoding="utf-8") == FILE
        await session.twice("enter")
        assert "elbow = -1" in path.read_text(encoding="utf-8")
        assert path.read_text(encoding="utf-8").startswith(FILE)
        assert "when the arm is next connected" in session.words
        await session.press("left", "left", "left")
        await session.choose("4 check")
        assert "was changed" in session.text("messages")


async def look_and_answer(session):
    """Turn every motor, and say of each what the real arm did."""
    world = session.simulated.arm.twin.world
    while (trial := session.stage.check.trial) is not None:
        before = (world.joints, world.opening_mm)
        await session.turn()
        seen = session.simulated.seen(before)
        await session.turn()
        right = seen.word(trial.ways[0]) == trial.expected.word(trial.ways[0])
        await session.press("y" if right else "r")
        if session.stage.check.asks_hand:
            rolled = seen.word("roll") == trial.expected.word("roll")
            await session.press("y" if rolled else "r")


async def test_an_arm_whose_motors_count_otherwise_is_right_after_its_file_was_corrected():
    path, signs = written(), (1, -1, 1, 1, 1, -1)
    async with SetupSession(load_arm(path), signs) as session:
        await session.choose("4 check")
        await look_and_answer(session)
        await session.press("enter")
        await session.twice("enter")
    config = load_arm(path)
    model = simulated_config("teachmover").model
    truth = model.transmission.with_signs(signs, (1,) * len(signs))
    assert config.model.transmission == truth
    async with SetupSession(config) as session:
        await session.choose("4 check")
        await look_and_answer(session)
        assert "all moved as shown" in session.words
        await session.press("enter")
        assert "left as it is" in session.words


async def test_a_key_that_is_held_turns_once_and_nothing_else_turns_at_all():
    async with SetupSession(size=(120, 24)) as session:
        await session.press("t")
        assert "choose that step first" in session.text("messages")
        await session.choose("4 check")
        await session.press("y", "r", "d", "h", "a", "enter", "up", "down", "left")
        assert isinstance(session.stage, Steps)
        await session.choose("4 check")
        assert session.simulated.asked == []
        session.shows("not turned yet", footer="t TURN", not_footer="as shown")
        await session.turn()  # the first repeat of a held key comes after half a second
        session.shows("turned", footer="t TURN", not_footer="as shown")
        assert len(session.simulated.asked) == 1
        for _ in range(20):
            await session.press("t", after_s=0.04)
        session.clock.now_s += 0.5
        await session.settle()
        await session.settle()
        assert len(session.simulated.asked) == 1
        session.stage._turning = Job(busy=True)
        await session.press("t", after_s=1.0)  # held since before the motor stands
        session.stage._turning = Job()
        await session.press("t", after_s=0.05)
        session.clock.now_s += 0.5
        await session.settle()
        assert len(session.simulated.asked) == 1


async def test_a_stop_leaves_the_step_and_what_was_answered_is_kept():
    async with SetupSession() as session:
        await session.choose("4 check")
        await session.go_through_one()
        await session.turn()
        await session.press("space")
        assert isinstance(session.stage, Steps)
        assert session.simulated.arm.stops == 1
        await session.choose("4 check")
        assert "1 checked" in session.words
        assert "TURN IT BACK" in session.words
        while session.stage.check.away:  # the stop may reach the arm with the first press
            await session.turn()
        # a check without a file says why nothing is written
        await session.go_through({"base": "h"})
        await session.press("enter")
        session.shows("no file", messages="no file to write it into")


NOT_TURNED = [
    (State.DISABLED, "the motors are off"),
    (State.ERROR_STOP, "the arm is in error-stop"),
]


async def test_no_motor_is_turned_after_a_stop_or_in_a_state_in_which_it_should_not():
    async with SetupSession() as session:
        arm = session.simulated.arm
        await session.choose("4 check")
        for state, why in NOT_TURNED:
            told = replace(session.desk.link.status, state=state, current=Current.OFF)
            session.desk.link.status = told
            await session.desk.run_action("stage.turn", session.desk.screen)
            assert session.simulated.asked == []
            assert why in session.desk.message
        session.simulated.before = lambda: (arm.request_stop(), arm.sleep(0.2))
        before = arm.twin.world.motors
        await session.poll()
        await session.turn()
        assert arm.twin.world.motors == before
        assert not session.stage.check.away
        assert "stop" in session.text("messages")


async def test_motors_that_changed_places_are_named_by_choosing_them():
    path = written()
    async with SetupSession(load_arm(path)) as session:
        await session.choose("4 check")
        for meant, really in (("base", "elbow"), ("elbow", "base")):
            while session.stage.check.trial.name != meant:
                await session.go_through_one()
            await session.turn()
            await session.turn()
            await session.press("a")
            assert "Which motor" in session.words
            while session.stage.others[session.stage.marked] != really:
                await session.press("down")
            await session.press("enter")
        await session.go_through({})
        assert "moved another motor's part: base, elbow" in session.words
        await session.press("enter")
        assert "swap their plugs" in session.words
        await session.press("enter")
        assert isinstance(session.stage, Steps)
