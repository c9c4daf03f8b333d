"""The set-up screen, from a port nobody knows to an arm file that was checked on the arm."""

from dataclasses import replace

import pytest
from desk_session import Session

from armdrive import places
from armdrive.armfile import load_arm_file
from armdrive.connecting import connect_simulated, simulated_config
from armdrive.errors import PortUnavailable
from armdrive.interview.sight import sight
from armdrive.interview.signs import TRIAL_SPEED
from armdrive.setup.finding import Candidate, Found
from armdrive.sim.twin import make_twin
from armdrive.status import State
from tui import setup_new
from tui.keyboard import DEFAULT_KEYS
from tui.keys_setup import SETUP_KEYS
from tui.setup_files import Correction, NewFile, Written
from tui.setup_motors import Motors
from tui.setup_new import Asking, Ports
from tui.setup_steps import Steps

FILE = 'model = "teachmover"\n\n[connection]\ndialect = "teachmover"\nport = ""\n'


@pytest.fixture(autouse=True)
def _home(tmp_path, monkeypatch):
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path))
    monkeypatch.delenv("ARMDRIVE_FORCE_SIM", raising=False)
    places.arm_files().mkdir(parents=True, exist_ok=True)


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
        self.arm = connect_simulated(config, twin=make_twin(really))
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

    def __init__(self, config=None, signs=None, **more):
        self.simulated = Simulated(config or simulated_config("teachmover"), signs)
        super().__init__(self.simulated.arm, **more)

    async def __aenter__(self):
        await super().__aenter__()
        await self.press("f5")
        await self.settle()
        return self

    async def __aexit__(self, *error):
        await super().__aexit__(*error)
        self.simulated.arm.close()

    @property
    def stage(self):
        return self.desk.place.stage

    @property
    def words(self):
        return self.text("setup-text")

    async def typed(self, text):
        names = {"/": "slash", "-": "minus", ".": "full_stop", ",": "comma", ":": "colon"}
        await self.press(*(names.get(each, each) for each in text))

    async def enter_twice(self):
        await self.press("enter")
        await self.press("enter", after_s=0.3)
        self.clock.now_s += 0.5
        await self.settle()
        await self.settle()

    async def choose(self, step):
        while f"> {step}" not in self.words:
            await self.press("down")
        await self.press("enter")
        await self.settle()

    async def turn(self):
        await self.press("t", after_s=1.0)
        await self.settle()

    async def go_through_one(self, key="y"):
        """Turn a motor, answer with a key, bring it back."""
        await self.turn()
        await self.press(key)
        if self.stage.check.asks_hand:
            await self.press("y")
        await self.turn()

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

    monkeypatch.setattr(setup_new, "candidates", lambda: (Candidate("/dev/arm", ("free",)),))
    monkeypatch.setattr(setup_new, "probe", probe)
    monkeypatch.setattr(setup_new, "looked_at", Candidate)
    return opened


ROBKO = Found("/dev/arm", ("it speaks robko01: Robko 01 at 115200 baud",), "robko01", 115200)


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
        assert "ONCE MORE" in session.words
        assert opened == []
        await session.press("enter")
        session.clock.now_s += 0.5
        await session.settle()
        await session.settle()
        assert opened == ["/dev/arm"]
        assert "it speaks robko01" in session.words
        await session.press("enter")
        assert isinstance(session.stage, Asking)
        await session.typed("lab3")
        await session.press("enter")
        assert session.stage.describing.line == "robko01"  # the template of what was found
        for _ in range(200):
            if isinstance(session.stage, NewFile):
                break
            await session.press("enter")
        assert isinstance(session.stage, NewFile)
        assert 'port = "/dev/arm"' in session.words
        path = places.arm_files() / "lab3.toml"
        await session.press("enter")
        await session.settle()
        assert not path.exists()
        await session.press("enter", after_s=0.3)
        session.clock.now_s += 0.5
        await session.settle()
        assert isinstance(session.stage, Written)
        assert load_arm_file(path).connection.dialect == "robko01"
        assert session.simulated.asked == []


async def test_the_motors_are_checked_and_the_file_is_corrected_after_its_difference_is_seen():
    path = written()
    async with SetupSession(load_arm_file(path)) as session:
        assert str(path) in session.words
        await session.choose("4 check")
        assert isinstance(session.stage, Motors)
        await session.go_through({"elbow": "r", "base": "d", "shoulder": "n"})
        assert {speed for _, speed in session.simulated.asked} == {TRIAL_SPEED}
        assert session.simulated.turned == [0] * 6
        assert "counts the other way: elbow" in session.words
        await session.press("enter")
        assert isinstance(session.stage, Correction)
        assert "+elbow = -1" in session.words
        assert "not told: shoulder" in session.words
        assert path.read_text(encoding="utf-8") == FILE
        await session.enter_twice()
        assert "elbow = -1" in path.read_text(encoding="utf-8")
        assert path.read_text(encoding="utf-8").startswith(FILE)
        assert "when it is next connected" in session.words
        await session.press("enter")
        await session.choose("4 check")
        assert "was changed" in session.text("remarks")


async def look_and_answer(session):
    """Turn every motor, and say of each what the real arm did."""
    world = session.simulated.arm.twin.world
    while (trial := session.stage.check.trial) is not None:
        before = (world.joints, world.opening_mm)
        await session.turn()
        seen = session.simulated.seen(before)
        right = seen.word(trial.ways[0]) == trial.expected.word(trial.ways[0])
        await session.press("y" if right else "r")
        if session.stage.check.asks_hand:
            rolled = seen.word("roll") == trial.expected.word("roll")
            await session.press("y" if rolled else "r")
        await session.turn()


async def test_an_arm_whose_motors_count_otherwise_is_right_after_its_file_was_corrected():
    path, signs = written(), (1, -1, 1, 1, 1, -1)
    async with SetupSession(load_arm_file(path), signs) as session:
        await session.choose("4 check")
        await look_and_answer(session)
        await session.press("enter")
        await session.enter_twice()
    config = load_arm_file(path)
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
    async with SetupSession() as session:
        await session.press("t")
        assert "choose that step first" in session.text("remarks")
        await session.choose("4 check")
        await session.press("y", "r", "d", "h", "a", "enter", "up", "down", "left")
        assert isinstance(session.stage, Steps)
        await session.choose("4 check")
        assert session.simulated.asked == []
        await session.press("t", after_s=1.0)
        for _ in range(20):
            await session.press("t", after_s=0.04)
        await session.settle()
        assert len(session.simulated.asked) == 1


async def test_a_stop_leaves_the_step_and_what_was_answered_is_kept():
    async with SetupSession() as session:
        await session.choose("4 check")
        await session.turn()
        await session.press("y")
        await session.press("space")
        assert isinstance(session.stage, Steps)
        assert session.simulated.arm.stops == 1
        await session.choose("4 check")
        assert "bring it back" in session.words
        await session.turn()
        assert "1 answered" in session.words
        assert session.simulated.turned == [0] * 6


async def test_a_stop_that_comes_before_the_motor_keeps_it_standing():
    async with SetupSession() as session:
        session.simulated.before = session.simulated.arm.request_stop
        await session.choose("4 check")
        before = session.simulated.arm.twin.world.opening_mm
        await session.turn()
        assert session.simulated.arm.twin.world.opening_mm == before
        assert not session.stage.check.away
        assert "stop" in session.text("remarks")


@pytest.mark.parametrize("state", [State.DISABLED, State.ERROR_STOP])
async def test_no_motor_is_turned_in_a_state_in_which_it_should_not(state):
    async with SetupSession() as session:
        arm = session.simulated.arm
        if state is State.ERROR_STOP:
            arm.estop()
        await session.choose("4 check")
        if state is State.DISABLED:
            session.desk.status = replace(session.desk.status, state=state)
            session.desk.place.action_turn()
        else:
            await session.turn()
        assert session.simulated.asked == []
        assert state.value in session.desk.message


async def test_motors_that_changed_places_are_named_by_choosing_them():
    path = written()
    async with SetupSession(load_arm_file(path)) as session:
        await session.choose("4 check")
        for meant, really in (("base", "elbow"), ("elbow", "base")):
            while session.stage.check.trial.name != meant:
                await session.go_through_one()
            await session.turn()
            await session.press("a")
            assert "Which motor" in session.words
            while session.stage.others[session.stage.marked] != really:
                await session.press("down")
            await session.press("enter")
            await session.turn()
        await session.go_through({})
        assert "moved another motor's part: base, elbow" in session.words
        await session.press("enter")
        assert "swap their plugs" in session.words
        await session.press("enter")
        assert isinstance(session.stage, Steps)


async def test_a_port_that_cannot_be_opened_is_said_and_can_be_described_all_the_same(monkeypatch):
    found_at(monkeypatch, PortUnavailable("/dev/arm is held by cura: end it"))
    async with SetupSession() as session:
        await session.choose("1 find")
        await session.enter_twice()
        assert "held by cura" in session.text("remarks")
        await session.press("right")
        assert isinstance(session.stage, Asking)
        await session.press("left")
        assert isinstance(session.stage, Ports)
        await session.press("right")
        await session.typed("xy")
        await session.press("backspace")
        assert session.stage.describing.typed == "x"


async def test_another_port_is_typed_and_a_stop_is_never_typed(monkeypatch):
    opened = found_at(monkeypatch, Found("/dev/ttyX", ("nobody answers",)))
    async with SetupSession() as session:
        await session.choose("1 find")
        await session.press("down")
        await session.typed("/dev/ttyXH")
        await session.press("backspace")
        await session.enter_twice()
        assert opened == ["/dev/ttyX"]
        assert "nobody answers" in session.words
        assert "asks again" in session.words
        await session.press("space")
        assert isinstance(session.stage, Steps)
        assert session.simulated.arm.stops == 1


async def test_an_arm_with_a_file_says_so_and_another_one_needs_leaving():
    path = written()
    async with SetupSession(load_arm_file(path)) as session:
        for step in ("1 find", "2 describe"):
            await session.choose(step)
            assert isinstance(session.stage, Steps)
            assert "leave it (ctrl+q)" in session.text("remarks")


async def test_a_real_arm_without_a_file_is_described_by_its_own_wire():
    async with SetupSession() as session:
        session.desk.status = replace(session.desk.status, simulated=False, link="/dev/arm")
        text = session.stage.text()
        assert "an arm without a file, on /dev/arm" in text
        session.stage.marked = 1
        session.stage.enter()
        assert isinstance(session.stage, Asking)
        session.stage.type("x")
        session.stage.enter()
        assert session.stage.describing.question.key == "template"
        session.stage.enter()
        session.stage.enter()
        # neither the dialect, nor the port, nor the baud rate is asked for
        assert session.stage.describing.question.key == "lengths.keep"


async def test_a_name_that_is_taken_is_refused_and_its_file_left_alone():
    path = written()
    async with SetupSession() as session:
        await session.choose("2 describe")
        await session.typed("bench")
        await session.press("enter")
        assert "not overwritten" in session.text("remarks")
        assert session.stage.describing.question.key == "name"
    assert path.read_text(encoding="utf-8") == FILE


async def test_referencing_asks_as_the_desk_does():
    async with SetupSession() as session:
        await session.choose("3 reference")
        assert "referenced" in session.text("remarks")


async def test_a_check_without_a_file_says_why_nothing_is_written():
    async with SetupSession() as session:
        await session.choose("4 check")
        await session.go_through({"base": "h"})
        await session.press("enter")
        assert "no file to write it into" in session.text("remarks")


def test_every_key_of_the_screen_is_pressed_somewhere_here():
    pressed = {"enter", "down", "up", "right", "left", "backspace", *"tyrnadh"}
    assert {row.keys[0] for row in SETUP_KEYS} == pressed
    assert all(DEFAULT_KEYS.label(row.id) for row in SETUP_KEYS)


SIZES = [(80, 24), (120, 40), (200, 60)]


SHOWN = {
    "steps": (),
    "ports": ("enter",),
    "question": ("down", "enter", "x", "enter"),
    "motor": ("up", "enter", "t"),
}


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("what", SHOWN)
def test_the_setup_screen(snap_compare, size, what, monkeypatch):
    found_at(monkeypatch, ROBKO)
    session = SetupSession()

    async def ready(pilot):
        for key in ("f5", *SHOWN[what]):
            await pilot.press(key)
            await pilot.app.workers.wait_for_complete()
            await pilot.pause()
        pilot.app.poll()
        await pilot.pause()

    assert snap_compare(session.desk, terminal_size=size, run_before=ready)
    session.simulated.arm.close()
