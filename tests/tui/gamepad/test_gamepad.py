"""A gamepad: what moves the arm, and everything that ends it; with fake devices."""

import os
import queue
import sys
import threading
from dataclasses import replace
from types import SimpleNamespace

import pytest
from desk_session import Session
from waiting import until_seen

import tui.gamepad as pad_evdev
from armdrive.errors import BadRequest, KeyFileError
from armdrive.motion.dead_man import HOLD_LONGEST_S
from armdrive.moves import Jog, Space
from armdrive.status import State
from tui.gamepad import (
    Came,
    EvdevPad,
    Gone,
    PadEvent,
    PadReader,
    Uncounted,
    check_gamepads,
    is_gamepad,
    open_gamepad,
)
from tui.jog.jogging import MOUSE_HOLDS_S, MOUSE_RENEWS_S, STEER_S
from tui.keys import gamepad_map as pad_map
from tui.keys.gamepad_map import BUTTONS, DEFAULT_PAD, STICKS
from tui.keys.remap import load_keys

BUMPER = BUTTONS["left-bumper"]
LEFT_X, LEFT_Y = STICKS["left-x"], STICKS["left-y"]
END = object()


def pressed(code=BUMPER):
    return PadEvent(code, 1.0, button=True)


def let_go(code=BUMPER):
    return PadEvent(code, 0.0, button=True)


class FakePad:
    """A gamepad that tells what the test puts, and is closed."""

    name = "Fake Pad"

    def __init__(self, sticks=None):
        self.told = queue.Queue()
        self.closed = threading.Event()
        self._sticks = sticks or {LEFT_X: 0.0}

    def sticks(self):
        return self._sticks

    def events(self):
        while (event := self.told.get()) is not END:
            if isinstance(event, Exception):
                raise event
            yield event

    def close(self):
        self.closed.set()


class PadSession(Session):
    """A desk with a gamepad whose events the test hands to it, in the desk's own thread."""

    def __init__(self, arm=None, **more):
        super().__init__(arm, find_pad=lambda: None, **more)
        self.desk.pad._reader.start = lambda: None

    async def __aenter__(self):
        await super().__aenter__()
        self.tell(Came("Fake Pad", {LEFT_X: 0.02, LEFT_Y: -0.03}))
        return self

    def tell(self, *told):
        for each in told:
            self.desk.pad.take_event(each)

    async def holding(self):
        """Arm, hold the button, and push the left stick to the left."""
        await self.arm_keys()
        self.tell(pressed(), PadEvent(LEFT_X, -1.0))
        assert self.arm.asked("hold")

    def lose(self):
        self.arm.set(state=State.DISCONNECTED)
        self.desk.poll()

    @property
    def moving(self):
        """Whether the last thing that was asked of the arm was to go on."""
        done = [call for call in self.arm.calls if call[0] in ("hold", "release", "stop")]
        return bool(done) and done[-1][0] == "hold"


async def test_a_stick_jogs_only_while_armed_and_while_the_button_is_held():
    async with PadSession() as session:
        assert "Fake Pad: once armed, hold its left-bumper" in session.desk.message
        session.tell(pressed(), PadEvent(LEFT_X, -1.0))
        assert session.arm.calls == []
        assert "until the keys are armed" in session.desk.message
        session.tell(let_go(), PadEvent(LEFT_X, 0.0))
        await session.arm_keys()
        session.tell(PadEvent(LEFT_X, -1.0), PadEvent(LEFT_X, 0.0))
        session.tell(pressed(BUTTONS["south"]), pressed(704), pressed(), PadEvent(2, 1.0), let_go())
        assert not session.arm.asked("hold"), "buttons and sticks without a row do nothing"
        session.tell(pressed(), PadEvent(LEFT_X, -1.0))
        assert session.arm.asked("hold") == [("hold", Jog.joint(base=1.0), 0.25, HOLD_LONGEST_S)]
        session.tell(let_go())
        assert not session.moving


HALF = DEFAULT_PAD.dead_zone + (1.0 - DEFAULT_PAD.dead_zone) / 2
PUSHED = [
    # keys before, sticks and how far they are pushed, the jog
    ("", {LEFT_X: -0.1}, None),  # within the dead zone
    ("", {LEFT_X: HALF}, Jog.joint(base=-0.5)),
    ("", {LEFT_X: HALF, LEFT_Y: -1.0}, Jog.joint(base=-0.5, shoulder=1.0)),
    ("", {STICKS["dpad-x"]: 1.0}, Jog.joint(gripper=1.0)),  # the last row of any arm
    ("m F", {LEFT_Y: -1.0}, Jog(Space.CARTESIAN, (("x", 1.0),), "tool")),
]


async def test_how_far_a_stick_is_pushed_is_how_fast_and_two_axes_go_together():
    async with PadSession() as session:
        for keys, sticks, jog in PUSHED:
            await session.keys(keys)
            await session.arm_keys()
            session.arm.calls.clear()
            session.tell(pressed())
            for code, value in sticks.items():
                session.clock.now_s += STEER_S
                session.tell(PadEvent(code, value))
            jogs = [call[1] for call in session.arm.asked("hold")]
            rounded = [
                replace(each, axes=tuple((axis, round(by, 9)) for axis, by in each.axes))
                for each in jogs
            ]
            assert rounded[-1:] == ([jog] if jog else [])
            session.tell(let_go(), *(PadEvent(code, 0.0) for code in sticks))


async def test_a_held_stick_is_renewed_in_short_holds_and_rest_ends_the_jog_at_once():
    async with PadSession() as session:
        await session.holding()
        for _ in range(5):
            session.tell(PadEvent(LEFT_X, -1.0))
        assert len(session.arm.asked("hold")) == 1, "not too often"
        session.clock.now_s += MOUSE_RENEWS_S
        session.tick()
        assert len(session.arm.asked("hold")) == 2
        assert session.arm.asked("hold")[-1][3] <= HOLD_LONGEST_S
        session.tell(PadEvent(LEFT_X, 0.0))
        assert not session.moving
        session.clock.now_s += 60.0 - 11.0
        session.tell(PadEvent(LEFT_X, 1.0))
        assert session.moving


async def test_a_pad_that_is_heard_of_no_more_holds_nothing_after_its_time():
    async with PadSession() as session:
        await session.holding()
        begun_s = session.clock.now_s
        while session.desk.pad.held:
            session.clock.now_s += 0.01
            session.tick()
        assert session.clock.now_s - begun_s <= MOUSE_HOLDS_S + 0.011
        assert "the gamepad sent nothing" in session.desk.message
        assert not session.moving
        session.tell(PadEvent(LEFT_X, -0.9))
        assert not session.moving, "the button has to be pressed anew"


ENDS = {
    "unplugged": lambda s: s.tell(Gone("Fake Pad: unplugged")),
    "another pad": lambda s: s.tell(Came("Other", {LEFT_X: -1.0})),
    "link lost": lambda s: s.lose(),
    "disarmed": lambda s: s.desk.disarm("x"),
    "suspended": lambda s: s.desk.disarm("suspended"),
    "its stop button": lambda s: s.tell(pressed(BUTTONS["east"])),
    "other settings": lambda s: s.tell(pressed(BUTTONS["north"])),
    "the focus is lost": lambda s: s.desk.on_app_blur(),
}


async def test_whatever_ends_a_jog_ends_that_of_a_pad_and_only_its_button_begins_it_again():
    async with PadSession() as session:
        for name, end in ENDS.items():
            session.tell(PadEvent(LEFT_X, 0.0), let_go())
            session.arm.calls.clear()
            await session.holding()
            end(session)
            assert not session.moving, name
            session.arm.set(state=State.STANDBY)
            session.desk.poll()
            session.clock.now_s += 10.0
            session.screen.hand.arm_keys()
            session.tell(PadEvent(LEFT_X, -0.8))
            session.tick()
            assert not session.moving, name
            assert not session.desk.pad.held, name


async def test_another_screen_a_dialog_a_stop_and_a_key_end_it():
    async with PadSession() as session:
        for key in ("f3", "question_mark", "space", "q"):
            session.tell(PadEvent(LEFT_X, 0.0), let_go())
            session.arm.calls.clear()
            await session.holding()
            await session.press(key)
            assert not session.desk.pad.held, key
            held = len(session.arm.asked("hold"))
            session.clock.now_s += MOUSE_RENEWS_S
            session.tell(PadEvent(LEFT_X, -0.9))
            assert len(session.arm.asked("hold")) == held, key
            await session.keys("space f2")


async def test_a_stick_that_is_pushed_already_moves_nothing_when_the_button_is_pressed():
    async with PadSession() as session:
        await session.arm_keys()
        session.tell(PadEvent(LEFT_X, -1.0), pressed())
        assert not session.arm.asked("hold")
        assert "let go of the sticks first" in session.desk.message
        session.tell(PadEvent(LEFT_X, 0.0), PadEvent(LEFT_X, -1.0))
        assert not session.arm.asked("hold")


async def test_its_stop_button_stops_on_any_screen_and_its_others_count_at_the_jog_screen_alone():
    async with PadSession() as session:
        await session.press("f3")
        session.tell(pressed(BUTTONS["east"]), pressed(BUTTONS["north"]))
        assert session.arm.asked("stop") == [("stop",)]
        assert session.desk.message == "mode is for the jog screen alone"
        assert session.screen.form.cartesian, "the mode button is of the jog screen"
        await session.press("f2")
        session.tell(pressed(BUTTONS["select"]), pressed(BUTTONS["north"]))
        assert session.desk.settings.jog.cartesian
        assert session.desk.settings.jog.speed == 0.1


async def test_without_a_link_its_buttons_do_what_their_keys_do_and_its_sticks_say_why_not():
    async with PadSession() as session:
        session.arm.set(state=State.DISCONNECTED, error="the cable was pulled")
        await session.poll()
        session.arm.calls.clear()
        session.tell(pressed(BUTTONS["north"]), pressed(BUTTONS["select"]))
        assert (session.desk.settings.jog.cartesian, session.desk.settings.jog.speed) == (True, 0.1)
        assert session.desk.message == ""
        session.tell(pressed(), PadEvent(LEFT_X, -1.0))
        assert "there is no link to the arm, and no key moves it" in session.desk.message
        assert session.arm.calls == []


# -- the file of keys -------------------------------------------------------------------------


def test_a_file_says_what_sticks_and_buttons_mean(tmp_path):
    path = tmp_path / "keys.toml"
    path.write_text(
        '[gamepad]\nhold = "right-bumper"\nmode = ""\nright-x = "axis-1-plus"\n'
        'left-x = ["gripper-plus", "axis-2-plus"]\ndead-zone = 0.3\n'
    )
    pad = load_keys(str(path)).pad
    assert pad.action(BUTTONS["right-bumper"]) == "hold"
    assert pad.action(BUMPER) == ""
    assert "mode" not in pad.buttons
    assert pad.rows(STICKS["right-x"]) == ("axis-1-plus", "axis-1-plus")
    assert pad.rows(LEFT_X) == ("gripper-plus", "axis-2-plus")
    assert pad.dead_zone == 0.3


WRONG = [
    ("hold = 'lft-bumper'", "left-bumper"),
    ("hold = ''", "hold is one of"),
    ("stop = ''", "stop is one of"),
    ("hold = 'east'", "east would be both"),
    ("left-xx = 'axis-1-plus'", "did you mean 'left-x'?"),
    ("left-x = 'axis-9-plus'", "like axis-1-plus"),
    ("left-x = ['axis-1-plus', 'axis-1-plus', 'axis-1-plus']", "a row, or two"),
    ("dead-zone = 0.0", "a share from"),
    ("dead-zone = true", "a share from"),
    ("dead-zone = nan", "a share from"),
]


@pytest.mark.parametrize(("line", "said"), WRONG, ids=[line for line, _ in WRONG])
def test_what_is_wrong_with_it_is_named(tmp_path, line, said):
    path = tmp_path / "keys.toml"
    path.write_text(f"[gamepad]\n{line}\n")
    with pytest.raises(KeyFileError) as caught:
        load_keys(str(path))
    assert said in str(caught.value)
    assert str(path) in str(caught.value)


def test_a_gamepad_that_is_no_table_is_refused(tmp_path):
    path = tmp_path / "keys.toml"
    path.write_text('gamepad = "mine"\n')
    with pytest.raises(KeyFileError, match="gamepad is a table"):
        load_keys(str(path))


def test_every_stick_of_the_table_is_one_and_moves_something_in_both_modes():
    for name, rows in DEFAULT_PAD.sticks.items():
        assert name in STICKS
        assert all(row in pad_map.JOG_ROWS for row in rows)
    assert len(set(DEFAULT_PAD.buttons.values())) == len(DEFAULT_PAD.buttons)


# -- the thread -------------------------------------------------------------------------------


def told_by(pads, until):
    """Run a reader over these pads until it has told so many things, and return them."""
    said, waiting, source = [], threading.Event(), iter(pads)

    def tell(told):
        said.append(told)
        if len(said) >= until:
            reader.close()
            waiting.set()

    reader = PadReader(lambda: next(source, None), tell)
    reader._closed.wait = lambda _s: None
    thread = threading.Thread(target=reader._run, daemon=True)
    thread.start()
    assert waiting.wait(10.0)
    thread.join(10.0)
    assert not thread.is_alive()
    return said


@pytest.mark.parametrize(
    ("end", "reason"),
    [
        (END, "unplugged"),
        (OSError(19, "No such device"), "No such device"),
        (Uncounted(), "some of its events were lost"),
    ],
)
def test_the_end_of_a_pad_is_told_whatever_ends_it_and_the_pad_is_closed(end, reason):
    pad = FakePad()
    for event in (pressed(), None, PadEvent(LEFT_X, 0.5), end):
        pad.told.put(event)
    said = told_by([pad], 4)
    assert said[0] == Came("Fake Pad", {LEFT_X: 0.0})
    assert said[1:3] == [pressed(), PadEvent(LEFT_X, 0.5)]
    assert said[3] == Gone(f"Fake Pad: {reason}")
    assert pad.closed.wait(10.0)


def test_one_that_comes_back_is_read_again_and_none_is_said_once():
    first, second = FakePad(), FakePad()
    first.told.put(END)
    second.told.put(END)
    said = told_by([None, None, first, None, second], 6)
    kinds = [type(each) for each in said]
    assert kinds == [Gone, Came, Gone, Gone, Came, Gone]


async def test_a_real_thread_moves_the_arm_of_a_desk_and_its_end_lets_go():
    pad = FakePad()
    source = iter([pad])
    session = Session(find_pad=lambda: next(source, None))
    async with session:
        await session.desk.workers.wait_for_complete()
        await session.arm_keys()
        asked, released = threading.Event(), threading.Event()
        session.arm.hold = lambda *_, **__: asked.set()
        session.arm.release = released.set
        pad.told.put(pressed())
        pad.told.put(PadEvent(LEFT_X, 1.0))
        await until(session, asked)
        pad.told.put(OSError(19, "No such device"))
        await until(session, released)
        await until(session, pad.closed)
    assert session.desk.pad._reader._closed.is_set()


async def until(session, event):
    await until_seen(event.is_set, session.pilot.pause)


# -- evdev ------------------------------------------------------------------------------------


class Device:
    """Has what is used of an `evdev.InputDevice`; its events lie in a pipe."""

    def __init__(self, name="Pad", events=(), axes=(0, 1, 17), keys=(304, 310)):
        self.name = name
        self._events = events
        self._axes, self._keys = axes, keys
        self.fd, self._other = os.pipe()
        os.write(self._other, b".")
        self.open = True

    def capabilities(self, *, absinfo):
        info = SimpleNamespace(min=0, max=255, value=255)
        axes = [(code, info) if absinfo else code for code in self._axes]
        return {1: list(self._keys), 3: axes}

    def absinfo(self, code):
        return SimpleNamespace(value=255)

    def read(self):
        os.read(self.fd, 1)
        for event in self._events:
            yield SimpleNamespace(type=event[0], code=event[1], value=event[2])
        raise OSError(19, "No such device")

    def close(self):
        if self.open:
            self.open = False
            os.close(self.fd)
            os.close(self._other)


@pytest.fixture
def devices():
    """Devices by path, closed at the end."""
    made = {}
    yield made
    for device in made.values():
        device.close()


def system(devices):
    return SimpleNamespace(list_devices=lambda: list(devices), InputDevice=devices.__getitem__)


def test_what_linux_tells_is_shares_and_buttons(devices):
    events = [(1, 310, 1), (1, 310, 2), (3, 0, 0), (3, 0, 255), (3, 2, 9), (4, 4, 4), (1, 310, 0)]
    devices["a"] = Device(events=events)
    pad = open_gamepad("", system(devices))
    assert pad.sticks() == {0: 1.0, 1: 1.0, 17: 1.0}
    seen = pad.events()
    wanted = [pressed(), PadEvent(0, -1.0), PadEvent(0, 1.0), let_go()]
    assert [next(seen) for _ in wanted] == wanted
    with pytest.raises(OSError, match="No such device"):
        next(seen)


def test_lost_events_are_no_events(devices):
    devices["a"] = Device(events=[(0, 3, 0)])
    with pytest.raises(Uncounted):
        next(EvdevPad(devices["a"]).events())


def test_nothing_to_read_yields_nothing_now_and_then(devices, monkeypatch):
    devices["a"] = Device()
    os.read(devices["a"].fd, 1)
    monkeypatch.setattr(pad_evdev, "WAKE_S", 0.0)
    assert next(EvdevPad(devices["a"]).events()) is None


def test_the_one_gamepad_is_taken_and_none_of_several(devices):
    devices["keyboard"] = Device("Keyboard", axes=(), keys=(30, 31))
    assert not is_gamepad(devices["keyboard"])
    assert open_gamepad("", system(devices)) is None
    devices["left"], devices["right"] = Device("Left Pad"), Device("Right Pad")
    with pytest.raises(BadRequest, match="Left Pad, Right Pad"):
        open_gamepad("", system(devices))
    assert not devices["left"].open
    devices["left"], devices["right"] = Device("Left Pad"), Device("Right Pad")
    devices["keyboard"] = Device("Keyboard", axes=(), keys=())
    assert open_gamepad("right", system(devices)).name == "Right Pad"


def test_a_device_that_goes_while_it_is_opened_is_passed_over(devices):
    devices["a"] = Device()

    def opened(path):
        if path == "gone":
            raise OSError(19, "No such device")
        return devices[path]

    fake = SimpleNamespace(list_devices=lambda: ["gone", "a"], InputDevice=opened)
    assert open_gamepad("", fake).name == "Pad"


def test_who_has_no_evdev_is_told_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "evdev", None)
    monkeypatch.setattr(pad_evdev.sys, "platform", "linux")
    with pytest.raises(BadRequest, match=r"pip install 'armdrive\[gamepad\]'"):
        check_gamepads()
    monkeypatch.setattr(pad_evdev.sys, "platform", "win32")
    with pytest.raises(BadRequest, match="Linux only"):
        check_gamepads()
