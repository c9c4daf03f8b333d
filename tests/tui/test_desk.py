"""The desk with a fake arm: every binding, arming and disarming, stopping."""

import asyncio
import signal
from dataclasses import replace
from itertools import product

import pytest
from amounts import every_row
from desk_fake import MODEL, FakeArm, StubbornArm, UnplaceableArm, busy_arm, unknown_position
from desk_planner import CONFIG, PlannerArm, at_rest
from desk_session import Session
from textual import events
from textual.widget import Widget
from waiting import until_seen

from armdrive.cli.runner import command_parser
from armdrive.errors import Refused
from armdrive.moves import Jog, Space
from armdrive.status import Current, State, Trust
from armdrive.storage.point_file import points_of
from kinematics import Joints, system
from kinematics.chains.arm import ChainArm
from tui.jog.jogging import IDLE_DISARMS_S
from tui.keys.table import JOG_PAIRS, SCREENS, spoken
from tui.terminal import ENDING_SIGNALS, KeyUp, ReleaseParser

TITLES = [
    # what an arm says of itself, and the title of its desk
    ({}, "SIMULATED: sim (TeachMover)"),
    ({"link": "simulated arm at 9600 baud"}, "SIMULATED: sim (TeachMover)"),
    ({"simulated": False, "link": "COM3"}, "REAL ARM: sim (TeachMover) on COM3"),
    # an arm that is named by its port is named only once
    ({"arm": "COM3", "link": "COM3 at 9600 baud"}, "REAL ARM: TeachMover on COM3 at 9600 baud"),
    (
        {"arm": "can:slcan:COM4?bitrate=500000", "link": "can:slcan:COM4 at 500 kbit/s"},
        "REAL ARM: TeachMover on can:slcan:COM4 at 500 kbit/s",
    ),
]


SETTINGS = [
    ("m right_square_bracket right_square_bracket minus", "speed 10%   step 2° [10 mm]"),
    ("m left_square_bracket plus equals_sign", "speed 50%   step [1°] 10 mm"),
]


async def test_the_desk_begins_disarmed_and_says_which_arm_this_is_what_is_near_and_what_is_next():
    """Whatever has a colour has a word or a sign, too."""
    arm = FakeArm(trust=Trust.SUSPECT, gripping=True)
    async with Session(arm) as session:
        session.shows("at first", state="keys DISARMED: enter arms", footer="enter arm")
        session.shows("at first", not_footer="G grasp", trust="suspect", gripper="CLOSED")
        assert session.lit_tab == " F2 Jog "
        await session.keys("q")
        assert arm.asked("nudge") == []
        arm.set(trust=Trust.REFERENCED)
        await session.keys("question_mark question_mark")  # lays the screen out for other panels
        rows = session.painted
        for words in (
            "1 open  2 half  3 closed  G grasp",
            "m: keys move the tip",
            "arrows: base, shoulder",
            "from its limit",
            "table: ",
            "14 mm, 0.21 s",
        ):
            assert words in "\n".join(rows)
        assert " ".join(rows[-1].split()) == (
            "space STOP enter arm m mode [ ] step - + speed K park ? help ^q quit"
        )
        view = session.screen.query_one("#space")
        # a thread works out how far the arm reaches, which is drawn when it is known
        await until_seen(lambda: "reach at pitch" in view.rows[-1], session.pilot.pause)
        before = view.rows
        arm.set(joints=arm.status.joints.replace(shoulder=1.5))
        await session.poll()
        assert view.rows != before
        for more, title in TITLES:
            arm.set(**more)
            await session.poll()
            assert session.text("title") == title
        await session.arm_keys()
        session.shows("armed", state="ARMED", footer="G grasp", not_footer="enter arm")
        assert session.text("footer").startswith("space STOP")
        arm.calls.clear()
    assert arm.asked("stop"), "however the desk ends"


async def test_mode_increment_and_speed_follow_their_keys_or_a_click_on_them():
    async with Session(PlannerArm(), size=(120, 24)) as session:
        for (line, settings), title in zip(SETTINGS, ("Tip, Cartesian", "Tip"), strict=True):
            await session.keys(line)
            assert session.title("tip") == title
            session.shows(line, stopping=settings)
        footer = session.text("footer")
        for key, step_deg in (("]", 2.0), ("[", 1.0)):
            await session.pilot.click("#footer", offset=(footer.index(key) + 1, 0))
            await session.poll()
            assert session.desk.settings.jog.step_deg == step_deg
        await session.pilot.click("#tabs", offset=(session.text("tabs").index("Move") + 1, 0))
        await session.settle()
        assert session.screen.place == "move"
        assert session.lit_tab == " F3 Move "


def everywhere_arm(**more):
    """An arm with what all screens need."""
    arm = busy_arm()
    arm.config = CONFIG
    arm.set(**more)
    arm.points = points_of(CONFIG.name, CONFIG.model.arm, lambda: None)
    return arm


async def test_every_screen_says_whether_the_arm_is_real_and_offers_nothing_in_vain(monkeypatch):
    """A poll of an arm that stands updates no widget; also on a narrow terminal its tab is lit."""
    arm, updated = everywhere_arm(link="/dev/serial/by-id/usb-FTDI_FT232R"), []
    async with Session(arm, size=(200, 24)) as session:
        for entry in SCREENS:
            await session.keys(entry.key)
            assert session.lit_tab == f" {entry.key.upper()} {entry.title.capitalize()} "
            await at_rest(session.pilot)
            with monkeypatch.context() as watched:
                watched.setattr(Widget, "refresh", lambda self, *_, **__: updated.append(self))
                session.desk.poll()
            assert updated == [], entry.id
            for simulated, kind in ((True, "SIMULATED"), (False, "REAL ARM")):
                arm.set(simulated=simulated)
                await session.poll()
                assert session.text("title").startswith(kind), entry.id
                assert kind in session.painted[1], entry.id
            known = arm.status
            for state in (State.HOMING, State.DISABLED, State.ERROR_STOP):
                arm.set(state=state, **unknown_position())
                await session.poll()
                where = (entry.id, state)
                session.shows(where, not_footer="go (twice)", not_trust="press H")
                session.shows(where, not_messages="references")
                assert "H reference" not in session.text("footer"), where
                if state is State.DISABLED:
                    session.shows(where, state="press P to switch the motors on")
            arm.status = known
        await session.resize(40, 24)
        for entry in SCREENS[::2]:
            await session.keys(entry.key)
            assert session.lit_tab == f" {entry.key.upper()} {entry.title.capitalize()} "


NEED_A_POSITION = {"f2": ("K", "K park"), "f4": ("t", "t teach")}
"""For each screen a key that does nothing before the position is known, and its offer."""


async def test_what_needs_a_position_is_neither_offered_nor_begun_before_there_is_one():
    arm = everywhere_arm(**unknown_position())
    async with Session(arm, size=(160, 24)) as session:
        for screen, (key, offer) in NEED_A_POSITION.items():
            await session.keys(f"{screen} {key}")
            session.shows(screen, messages="trusted: press H first", not_footer=offer)
            session.shows(screen, footer="H reference")
            assert len(session.desk.screen_stack) == 1
            assert getattr(session.desk.screen, "typing", None) is None
        arm.set(trust=Trust.REFERENCED, trust_reason="")
        for screen, (_, offer) in NEED_A_POSITION.items():
            await session.keys(screen)
            session.shows(screen, footer=offer)


SILENT = [
    # where a key has nothing to do, and what it says then
    ("q", "jog keys move nothing before they are armed"),
    ("C", "nothing to confirm"),
    ("f4 g", "a on a point begins a program"),
    ("backspace", "no line to take back"),
    ("delete", "no point to delete"),
    ("f5 left", "the first step"),
    ("backspace", "nothing here for this key"),
    ("v", "no arm is drawn here"),
]


async def test_a_key_that_has_nothing_to_do_says_why_and_asks_nothing_of_the_arm():
    async with Session(everywhere_arm()) as session:
        for line, said in SILENT:
            await session.keys(line)
            session.shows(line, messages=said)
        await session.press("f2")
        await session.arm_keys()
        await session.press("u")
        session.shows("a key without an axis", messages="this arm has no axis")
        assert session.arm.calls == []
        assert len(session.desk.screen_stack) == 1
        await session.tap("q", after_s=3.0)
        session.shows("armed", not_messages="move nothing")
        assert session.arm.asked("nudge")


def test_only_whole_names_are_spoken():
    joints = MODEL.arm.joint_names
    said = spoken("wrist_pitch 3, wrist_roll_deg=2, my_wrist_roll", joints)
    assert said == "wrist pitch 3, wrist_roll_deg=2, my_wrist_roll"


async def test_every_jog_key_is_one_increment_of_its_axis():
    keys = [(key, pair) for pair in JOG_PAIRS for key in (pair.plus, pair.minus)]
    async with Session() as session:
        for cartesian, space in ((False, Space.JOINT), (True, Space.CARTESIAN)):
            await session.arm_keys()
            session.arm.calls.clear()
            for key, _ in keys:
                await session.tap(key, after_s=3.0)
            expected = [
                ("nudge", Jog(space, ((pair.axis(cartesian=cartesian), size),)), 0.25)
                for key, pair in keys
                for size in (2.0 if key == pair.plus else -2.0,)
            ]
            assert session.arm.asked("nudge") == expected
            await session.press("m")


async def test_stop_keys_stop_disarm_and_close_whatever_is_open():
    async with Session(FakeArm(simulated=False)) as session:
        for dialog, key in product(("", "question_mark", "H"), ("space", "escape", "ctrl+c")):
            await session.arm_keys()
            if dialog:
                await session.press(dialog)
                assert len(session.desk.screen_stack) == 2
            session.arm.calls.clear()
            await session.press(key)
            assert session.arm.calls[0] == ("stop",)
            assert not session.screen.armed
            assert len(session.desk.screen_stack) == 1


async def test_the_stop_button_stops_on_every_screen_and_over_every_dialog():
    """Each of them is also drawn in plain letters where the terminal has no others."""
    async with Session(everywhere_arm(simulated=False), braille=False) as session:
        for entry in SCREENS:
            # the dialogs stand where they stand whatever is behind them
            dialogs = ("question_mark", "ctrl+p") if entry is SCREENS[0] else ()
            if entry is SCREENS[-1]:
                await session.resize(120, 40)
            for dialog in ("", *dialogs):
                await session.keys(f"{entry.key} {dialog}")
                assert session.desk.place == entry.id
                assert len(session.desk.screen_stack) == 1 + bool(dialog)
                drawn = "".join(session.painted)
                assert drawn.isascii(), {each for each in drawn if not each.isascii()}
                stop = session.screen.query_one("#stop").region
                x, y = stop.x + 1, stop.y + 1
                session.arm.calls.clear()
                pressed = (None, x, y, 0, 0, 1, False, False, False)
                await session.send(events.MouseDown(*pressed, screen_x=x, screen_y=y))
                assert session.arm.calls[0] == ("stop",)
                assert len(session.desk.screen_stack) == 1


async def test_holding_a_key_jogs_and_letting_go_stops():
    async with Session() as session:
        await session.hold("w")
        for _ in range(20):
            await session.press("w", after_s=0.04)
        holds = session.arm.asked("hold")
        assert len(session.arm.asked("nudge")) == 1
        assert len(holds) == 21
        assert {call[1] for call in holds} == {Jog.joint(shoulder=1.0)}
        assert all(call[3] <= 0.25 for call in holds)
        assert holds[-1][3] == pytest.approx(0.12)
        session.clock.now_s += 0.13
        session.tick()
        assert session.arm.calls[-1] == ("release",)
        assert session.screen.armed


HOLD_ENDS = [
    # what happens, whether the keys stay armed, what is said
    ("key up", lambda session: session.send(KeyUp("w")), True, ""),
    ("another mode", lambda session: session.press("m"), True, ""),
    ("focus lost", lambda session: session.send(events.AppBlur()), False, "focus"),
    ("paste", lambda session: session.send(events.Paste("qqqqqqqq")), False, "pasted"),
]


async def test_what_ends_a_hold_at_once():
    async with Session() as session:
        for what, end, armed, said in HOLD_ENDS:
            session.arm.calls.clear()
            await session.press("m", "m")  # a hold in joint mode, and nothing held before it
            await session.hold("w")
            session.arm.calls.clear()
            await session.send(KeyUp("q"))
            assert session.arm.asked("release") == [], "another key was let go"
            await end(session)
            assert session.arm.calls[-1] == ("release",), what
            assert session.screen.armed == armed, what
            assert session.arm.asked("nudge") == [], what
            session.shows(what, messages=said)
            session.desk.disarm("the next one")


@every_row(
    "sent, read",
    [
        ("\x1b[113;1:3u", [(KeyUp, "q")]),
        ("\x1b[113;1:2;113u", [(events.Key, "q")]),
        ("\x1b[113;1:1;113u", [(events.Key, "q")]),
        ("\x1b[113;;113u", [(events.Key, "q")]),
        ("\x1b[1;1:2A", [(events.Key, "up")]),
        ("\x1b[1;1:3A", [(KeyUp, "up")]),
        ("\x1b[A", [(events.Key, "up")]),
        ("q", [(events.Key, "q")]),
        ("\x1b[104;2;72u", [(events.Key, "H")]),
        ("\x1b[99;5:3u", [(KeyUp, "ctrl+c")]),
    ],
)
def test_presses_repeats_and_releases_are_told_apart(sent, read):
    assert [(type(event), event.key) for event in ReleaseParser().feed(sent)] == read


async def test_a_real_timer_ends_a_hold_by_itself():
    """Nobody calls tick here but the desk's own alarm."""
    arm, released = FakeArm(), asyncio.Event()
    arm.jogging.release = released.set
    async with Session(arm) as session:
        await session.arm_keys()
        await session.tap("w")
        await session.press("w", after_s=0.4)
        session.clock.now_s += 0.03
        await until_seen(lambda: arm.asked("hold"), session.pilot.pause)
        session.clock.now_s += 1.0
        await until_seen(released.is_set, session.pilot.pause)
    assert len(arm.asked("hold")) == 1


async def test_keys_that_pour_in_or_stay_away_disarm():
    async with Session() as session:
        await session.press("q", "enter", after_s=0.01)
        assert not session.screen.armed
        session.shows("a burst", messages="let go of all keys")
        await session.hold("w")
        session.clock.now_s += 0.4
        session.tick()
        session.arm.calls.clear()
        await session.press(*["w"] * 12, after_s=0.002)
        assert not session.screen.armed
        assert session.arm.asked("nudge") == session.arm.asked("hold") == []
        session.shows("backlog", messages="faster than a keyboard")
        await session.arm_keys()
        await session.press("q")
        session.clock.now_s += IDLE_DISARMS_S - 0.1
        await session.poll()
        assert session.screen.armed
        session.clock.now_s += 0.2
        await session.poll()
        assert not session.screen.armed
        session.shows("nobody there", messages="no key for 60 s")


PAUSED_IN = (
    (State.STANDBY, "held", "PAUSED"),
    (State.MOVING, "held", "PAUSED"),
    (State.ERROR_STOP, "held", "ERROR"),
    (State.DISABLED, "off", "MOTORS OFF"),
    (State.DISABLED, "unknown", "DISABLED"),  # an earlier program may have left them on
    (State.DISCONNECTED, "unknown", "LINK LOST"),
)


async def test_the_banner_says_what_forbids_motion_and_says_it_once():
    async with Session() as session:
        session.arm.set(speed_override=0.25)
        await session.poll()
        slowed = session.text("banner")
        assert "SLOWED from outside to 25%" in slowed
        _, name, *words = slowed.split("`")[1].split()
        assert command_parser(name, "drive.control_requests:slow").parse_args(words).speed == 1.0
        session.arm.set(paused=True)
        await session.poll()
        assert "PAUSED  p on the move screen resumes it, space ends" in session.text("banner")
        for state, current, badge in PAUSED_IN:
            session.arm.set(state=state, current=Current(current))
            await session.poll()
            assert session.text("state").startswith(f" {badge} "), "a pause hides no such state"
        session.arm.set(paused=False, speed_override=1.0, state=State.STANDBY)
        await session.poll()
        assert session.text("banner") == ""
        await session.press("X")
        await session.poll()
        said = "ERROR  emergency stop. Look at the arm, then press R. That moves nothing."
        assert said in session.text("banner")
        session.arm.set(error="the elbow slipped: look at it")
        session.desk.message = "the elbow slipped: look at it"
        await session.poll()
        session.shows("once", banner="the elbow slipped", not_messages="the elbow slipped")
        await session.keys("R")
        assert session.text("banner") == ""
        assert [call[0] for call in session.arm.calls if call[0] in ("nudge", "hold")] == []


async def test_a_key_that_acts_clears_the_last_message_and_a_first_press_but_no_repeated_jog_key():
    async with Session() as session:
        for key in ("m", "right_square_bracket", "v", "question_mark", "question_mark", "f3", "f2"):
            session.desk.say("the last message")
            session.desk.confirmation.press("moves it", session.arm.home)
            await session.press(key)
            assert session.desk.message != "the last message", key
            assert session.desk.confirmation.effect == "", key
        await session.hold("q")
        session.desk.disarm("they may be old")
        session.desk.confirmation.press("moves it", session.arm.home)
        await session.press(*["q"] * 5)
        assert session.desk.message == "keys disarmed: they may be old"
        assert session.desk.confirmation.effect == ""
        await session.press("q", after_s=3.0)
        assert session.desk.message == "jog keys move nothing before they are armed"


class SixJointArm(FakeArm):
    """An arm of six joints without a gripper's motor, with switches of its own."""

    homes_by_switches = True
    homing_words = "THE ARM WILL MOVE: its controller seeks its switches."

    def __init__(self, **more):
        super().__init__(**more)
        chain = system("puma").chain()
        links = tuple(replace(link, low=-2.0, high=2.0) for link in chain.links)
        self.model = replace(MODEL, arm=ChainArm(replace(chain, links=links)))
        joints = Joints((0.1,) * 6, self.model.arm.joint_names)
        self.set(joints=joints, pose=self.model.arm.fk(joints), gripper_mm=None)


QUESTIONS = [
    # the key, an arm of which it asks something, what a yes asks of the arm
    ("H", FakeArm(simulated=False, **unknown_position()), "reference"),
    ("H", SixJointArm(), "home"),  # it moves to its own switches
    ("C", FakeArm(trust=Trust.RESTORED, trust_reason="recorded"), "restored"),
    ("P", FakeArm(), "disable"),
]


@pytest.mark.parametrize(("key", "arm", "asked"), QUESTIONS)
async def test_what_moves_the_arm_or_lets_it_sag_is_done_only_after_a_yes(key, arm, asked):
    async with Session(arm) as session:
        if key == "C":
            session.shows("restored", trust="C confirms")
        for answer in ("n", "space", "y"):
            await session.keys(f"{key} enter")
            assert len(session.desk.screen_stack) == 2, "enter is neither yes nor no"
            await session.keys(answer)
            assert session.arm.asked(asked) == [(asked,)] * (answer == "y"), answer
            assert len(session.desk.screen_stack) == 1
            if (asked, answer) == ("reference", "n"):
                session.shows("no", messages="jog the arm there (enter arms the keys), then H")
        if key == "P":
            session.clock.now_s += 1.0
            await session.keys("P")
            assert session.arm.asked("enable") == [("enable",)], "on at once"


async def test_refusals_and_flaws_of_calls_are_sentences_and_leave_the_desk_alive():
    async with Session(Flawed(simulated=False)) as session:
        await session.follow(
            [("R", {"messages": "still moving: wait"}), ("H y", {"messages": "the arm moves"})]
        )
        await session.arm_keys()
        await session.tap("q")
        session.shows("q", messages="no such axis")
        session.arm.set(state=State.DISABLED)
        await session.poll()
        await session.keys("P")
        session.shows("P", messages="please report it: TypeError: a word too many")
        await session.press("space")
        assert session.arm.asked("stop")
    async with Session(UnplaceableArm(simulated=False)) as session:
        await session.follow([("H", {"messages": "no reference posture is known"})])
        assert len(session.desk.screen_stack) == 1


async def test_an_arm_whose_position_is_unknown_says_so_and_its_operator_references_it():
    async with Session(FakeArm(**unknown_position())) as session:
        session.arm.set(notice="jogging needs a known position: reference it first (`home()`)")
        await session.poll()
        assert "a known position: reference it first (H)" in session.text("messages")
        assert "position unknown: press H" in session.text("trust")
        assert "position unknown" in "".join(session.screen.query_one("#space").rows)
        await session.arm_keys()
        await session.keys("H")
        assert len(session.desk.screen_stack) == 1, "a simulated arm is brought there"
        assert session.arm.asked("home")
        assert not session.screen.armed


@pytest.mark.parametrize("number", ENDING_SIGNALS)
async def test_a_signal_stops_and_closes_the_arm_and_ends_the_desk(number):
    arm = FakeArm()

    def close():
        arm.calls.append(("close",))
        raise Refused("the arm did not confirm the stop")

    arm.close = close
    async with Session(arm, handle_signals=True) as session:
        await session.arm_keys()
        session.arm.calls.clear()
        signal.raise_signal(number)
        await until_seen(
            lambda: session.desk.return_code is not None and session.arm.asked("close"),
            session.pilot.pause,
        )
    assert session.arm.calls[:2] == [("stop",), ("close",)]
    assert session.desk.return_code == 128 + number


async def test_an_arm_of_six_joints_has_a_row_and_keys_for_each():
    async with Session(SixJointArm()) as session:
        await session.arm_keys()
        await session.tap("y", "m", "h", after_s=3.0)
        names = session.arm.model.arm.joint_names
        assert [call[1] for call in session.arm.asked("nudge")] == [
            Jog.joint(**{names[5]: 2.0}),
            Jog(Space.CARTESIAN, (("yaw", -2.0),)),
        ]
        assert all(name.replace("_", " ") in session.text("joints") for name in names)
        assert "yaw" in session.text("tip")


class Flawed(StubbornArm):
    """Refuses, and has a flaw."""

    def enable(self):
        raise TypeError("a word too many")
