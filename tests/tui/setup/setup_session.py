"""A desk at its set-up screen, with a simulated arm whose motors may count otherwise."""

from dataclasses import replace

from desk_session import Session

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.dialog import ok
from armdrive.registry import simulate
from armdrive.setup.directions import sight
from armdrive.setup.ports import ClosedPort
from armdrive.setup.survey import Report
from armdrive.storage import files as places
from tui.setup import stages as setup_new

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

    monkeypatch.setattr(setup_new, "closed_ports", lambda: (ClosedPort("/dev/arm", (ok("free"),)),))
    monkeypatch.setattr(setup_new, "probe", probe)
    monkeypatch.setattr(setup_new, "look_at", ClosedPort)
    return opened


ROBKO = Report(
    "/dev/arm",
    findings=[ok("it speaks robko01: Robko 01 at 115200 baud")],
    more={"dialect": "robko01", "baud": 115200},
)
