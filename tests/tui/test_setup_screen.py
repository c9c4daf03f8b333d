"""The set-up screen, from a port nobody knows to an arm file that was checked on the arm."""

import threading
from dataclasses import replace

import pytest
from desk_fake import Clock
from desk_session import Session

from armdrive import places
from armdrive.armfile import load_arm_file
from armdrive.connecting import connect_simulated, simulated_config
from armdrive.doctor import carrying
from armdrive.errors import PortUnavailable, Stopped
from armdrive.interview.corrections import Saw
from armdrive.interview.signs import TRIAL_SPEED
from armdrive.setup.finding import Candidate, Found
from armdrive.status import State, Trust
from tui import setup_new
from tui.keys_setup import SETUP_KEYS
from tui.setup_files import Correction, NewFile, Written
from tui.setup_motors import Motors
from tui.setup_new import Asking, Ports

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
    """A simulated arm; `really` has its motors count as its file does not say."""

    def __init__(self, config, signs=None):
        if signs is not None:
            true = config.model.transmission.with_signs(signs, (1,) * 5)
            self.really = replace(config, model=replace(config.model, transmission=true))
        self.arm = connect_simulated(config)
        self.asked = []
        self.move = self.arm.move_motors
        self.arm.move_motors = self._moved

    def _moved(self, *steps, speed, stops):
        self.asked.append((steps, speed))
        return self.move(*steps, speed=speed, stops=stops)


class SetupSession(Session):
    """A desk at its set-up screen, with a simulated arm."""

    def __init__(self, config=None, **more):
        self.simulated = Simulated(config or simulated_config("teachmover"))
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

    async def go_through(self, seen):
        """Answer for each motor with a key; those that are not named moved as shown."""
        while (trial := self.stage.check.trial) is not None:
            await self.turn()
            await self.press(*seen.get(trial.name, "y"))
            if self.stage.check.asks_hand:
                await self.press("y")
            await self.turn()


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
    monkeypatch.setattr(setup_new, "looked_at", lambda port: Candidate(port))
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
        assert [sum(each) for each in zip(*(s for s, _ in session.simulated.asked))] == [0] * 6
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
