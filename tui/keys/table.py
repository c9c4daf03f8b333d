"""The keys and the screens of the desk, a table each: for bindings, footer, help, docs, tests.

What the keys are on the keyboard at hand, and how they are shown, is keyboard.py's.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import zip_longest

from armdrive.trace.entries import Topic
from kinematics.spaces import JOINT_NAMES
from kinematics.text import shown_name


class Needs(IntEnum):
    """What a key needs of the arm to do anything; each needs what the ones before it do, too.

    Where an arm is not so, the line of keys does not offer the key, and a press of it is refused.
    """

    NOTHING = 0
    LINK = 1
    MOTORS = 2
    """A state in which something can move the arm: no error-stop, and the motors are on."""
    POSITION = 3
    """A position that can be trusted."""


@dataclass(frozen=True, slots=True)
class DeskKey:
    """One thing to do, and the keys that do it, named as the framework names them.

    `action` is a method `action_...` of the screen or the app; "part.method" is a method of one of
    its parts. `back` are keys that do the opposite: `action` with the other sign, or `back_action`.
    `places` names the screens (or dialogs) on which they do it; without one it is all screens.
    `everywhere` keys work in every dialog too, before anything else. Rows without a description are
    never offered in the line of keys. `also` are other words by which people look for it, and
    `needs` says which arm it can do anything to.
    """

    id: str
    keys: tuple[str, ...]
    action: str
    description: str
    tooltip: str
    places: str = ""
    everywhere: bool = False
    also: str = ""
    needs: Needs = Needs.NOTHING
    back: tuple[str, ...] = ()
    back_action: str = ""

    @property
    def all_keys(self) -> tuple[str, ...]:
        """Every key of the row, those that do the opposite first."""
        return (*self.back, *self.keys)

    @property
    def bound(self) -> tuple[tuple[str, tuple[str, ...], str], ...]:
        """The ids, keys and actions of the row's bindings: one, or two that do the opposite."""
        forth = (self.id, self.keys, self.action)
        opposite = self.back_action or self.action.replace("(1)", "(-1)")
        return (forth, (f"{self.id}-back", self.back, opposite)) if self.back else (forth,)

    def counts_at(self, place: str) -> bool:
        """Return whether the row is one of a screen's or dialog's own."""
        return place in self.places.split()

    @property
    def jogs(self) -> bool:
        """Whether the keys jog."""
        return self.action.startswith("jog(")


# Every screen of the desk, and its dialogs.

# The row of the keys that stop the arm.
STOP = "stop"

# The actions of every screen.
DESK_KEYS = (
    DeskKey(STOP, ("space", "escape", "ctrl+c"), "stop_arm", "STOP",
            "Stop the arm, disarm the keys and close any dialog. Works everywhere; space acts "
            "0.1 s sooner than Esc.", everywhere=True),
    DeskKey("help", ("question_mark", "f1"), "help", "help", "Show all keys."),
    DeskKey("quit", ("ctrl+q",), "leave", "quit",
            "Stop the arm and leave the desk.", everywhere=True),
    DeskKey("reference", ("H",), "control.reference", "reference",
            "Reference the arm: confirm that it stands in the posture shown. A simulated arm "
            "goes there by itself; an arm with switches homes after a question.",
            also="home homing origin zero", needs=Needs.MOTORS),
    DeskKey("confirm", ("C",), "control.confirm", "confirm",
            "Confirm that the arm still stands as the last program left it, in the posture "
            "shown.", needs=Needs.LINK),
    DeskKey("motors", ("P",), "control.switch_motors", "motors",
            "Switch the motors on; or off, after a question, because the arm then sags.",
            needs=Needs.LINK),
    DeskKey("reconnect", ("L",), "control.reconnect", "reconnect",
            "Try once to reconnect a lost link. Nothing moves, and an interrupted motion does "
            "not continue."),
    DeskKey("palette", ("ctrl+p",), "palette", "commands",
            "Find an action by a few letters; enter does it."),
    DeskKey("look", ("T",), "next_look", "look",
            "Change the colours: dark, light, high contrast, or your terminal's own."),
    DeskKey("more", ("ctrl+d",), "scroll(1)", "",
            "Scroll down or up, to what the panels have no room for.", back=("ctrl+u",)),
    DeskKey("reset", ("R",), "control.reset", "reset",
            "Leave error-stop. Nothing moves.", also="clear error unlock", needs=Needs.LINK),
    DeskKey("estop", ("X",), "control.estop", "e-stop",
            "Stop, and latch error-stop: nothing moves until a reset.", also="estop emergency"),
)  # fmt: skip

# Enter answers no question: a person who armed with it may still be pressing it. Where a text is
# typed, its letters come first.
DIALOG_KEYS = (
    DeskKey("close", ("enter", "question_mark", "f1", "n"), "close", "close",
            "Close the dialog.", "dialog"),
    DeskKey("yes", ("y",), "answer(True)", "yes", "Yes: do it.", "question"),
    DeskKey("no", ("n",), "answer(False)", "no", "No: do nothing.", "question"),
)  # fmt: skip

# The row, and the action, that pauses the arm and resumes it.
PAUSE = "pause"

# The rows of several screens.
SHARED_KEYS = (
    DeskKey(PAUSE, ("p",), PAUSE, "pause",
            "Pause a motion or a program after its current burst, or resume it. A held key "
            "does not resume.", "move points program"),
    DeskKey("go", ("enter",), "press_go", "go (twice)",
            "Press twice: the arm moves as shown. A held key does not count.",
            "move points", needs=Needs.POSITION),
    DeskKey("next", ("down", "tab"), "choose(1)", "next", "Choose the next or previous line.",
            "move points program setup log", back=("up", "shift+tab")),
    DeskKey("page", ("pagedown",), "turn_page(1)", "", "Go forward or back by a page.",
            "program log model", back=("pageup",)),
    DeskKey("mode", ("m",), "switch_mode", "mode",
            "Switch between joints and the tip.", "jog move model"),
    DeskKey("step", ("right_square_bracket",), "change_step(1)", "step",
            "Make the step larger or smaller: degrees for joints, mm for the tip.",
            "jog move model", back=("left_square_bracket",)),
    DeskKey("frame", ("F",), "next_frame", "frame",
            "Choose the frame of the tip: the base's, the tool's, or one of the arm file. A goal "
            "in the tool's frame is a change from where the tool is.", "jog move"),
    DeskKey("line", ("l",), "switch_line", "line",
            "Switch between a straight line of the tip and a joint motion.", "move points"),
    DeskKey("go-speed", ("greater_than_sign",), "change_speed(1)", "speed",
            "Move faster or more slowly.", "move points", back=("less_than_sign",)),
    DeskKey("erase", ("backspace",), "app.erase", "",
            "Delete the last character.", "move setup dialog"),
    DeskKey("clear", ("delete",), "clear", "clear",
            "Delete the whole text, or empty all fields of a goal: no change.", "move dialog"),
)  # fmt: skip


# The screens that plan motion: move and points.

# Digits, the point and the minus are typed into the field, and are no rows of the table.
MOVE_KEYS = (
    DeskKey("move-more", ("right",), "change_value(1)", "value",
            "Increase or decrease the field by one step.", "move", back=("left",)),
    DeskKey("move-nearest", ("n",), "take_nearest", "nearest",
            "After a refusal: take the nearest possible goal.", "move"),
    DeskKey("move-posture", ("b",), "take_next_posture", "posture",
            "Take the next posture that reaches this goal, as joint angles.", "move"),
)  # fmt: skip

# Names are typed once they are asked for; their letters are no rows of the table.
POINT_KEYS = (
    DeskKey("points-teach", ("t",), "teach", "teach",
            "Save the place where the arm stands. Type a name, then press enter.", "points",
            needs=Needs.POSITION),
    DeskKey("points-again", ("U",), "teach_again", "again",
            "Press twice: save the point again, where the arm stands now.", "points",
            needs=Needs.POSITION),
    DeskKey("points-rename", ("r",), "rename", "rename",
            "Rename the point. A program that names it has to be changed by hand.", "points"),
    DeskKey("points-delete", ("delete",), "delete", "delete",
            "Press twice: delete the point from the file.", "points"),
    DeskKey("points-append", ("a",), "append", "append",
            "Append a move to the point to a program file, with the motion and speed shown.",
            "points"),
    DeskKey("points-fingers", ("g",), "append_fingers", "fingers",
            "Append a line for the fingers to the program. Type open, close, grasp, here (as they "
            "are now) or mm, then press enter.", "points"),
    DeskKey("points-wait", ("W",), "append_wait", "wait",
            "Append a wait to the program. Type seconds, then press enter.", "points"),
    DeskKey("points-erase", ("backspace",), "take_back", "",
            "Take back what was appended last; while you type a name, its last letter.", "points"),
)  # fmt: skip

# A stop ends a program at once; leaving the screen ends it after the motion under way.
PROGRAM_KEYS = (
    DeskKey("program-go", ("enter",), "press_go", "go (twice)",
            "Press twice: run the program as rehearsed; it is rehearsed first if necessary. A "
            "held key does not count.", "program", also="run start play", needs=Needs.MOTORS),
    DeskKey("program-rehearse", ("r",), "rehearse", "rehearse",
            "Rehearse the program on a simulated copy of the arm: how long it takes, what it "
            "assumes, and which line would fail. Nothing moves.", "program", also="check simulate"),
    DeskKey("program-stepping", ("s",), "run.switch_stepping", "stepping",
            "Make the program wait for you before each motion; press again to end this.",
            "program"),
    DeskKey("program-forward", ("right",), "run.forward", "step",
            "Let a waiting program continue. A held key does not count.", "program"),
)  # fmt: skip

# The head of the log names the keys of the topics, so that they come last in the footer.
LOG_KEYS = (
    DeskKey("log-open", ("enter",), "open_line", "open",
            "Show the whole line; for an error, its cause and remedy too.", "log"),
    DeskKey("log-find", ("slash",), "find", "find",
            "Show only lines with a text. Commas separate words that must all occur.", "log"),
    DeskKey("log-all", ("a",), "show_all", "all",
            "Show everything again and follow the newest line.", "log"),
    DeskKey("log-hold", ("p",), "switch_hold", "hold",
            "Hold the lines still, or follow the newest again. The arm is not paused.", "log"),
    DeskKey("log-save", ("s",), "save", "save",
            "Save the flight recorder to a file, and show its path.", "log"),
    DeskKey("log-last", ("end",), "follow", "newest",
            "Follow the newest line again, or go to the oldest one.", "log",
            back=("home",), back_action="go_first"),
    *(
        DeskKey(f"log-{topic.value}", (str(number),), f"switch_topic('{topic.value}')",
                topic.value, f"Show or hide the {topic.value}.", "log")
        for number, topic in enumerate(Topic, 1)
    ),
)  # fmt: skip

# The set-up screen. Only `t` moves anything. While text is typed, printable keys are typed and do
# nothing else; space is never typed.
SETUP_KEYS = (
    DeskKey("setup-enter", ("enter",), "stage.enter", "go on",
            "Do what is marked. Opening a port or writing a file needs a second press.", "setup"),
    DeskKey("setup-on", ("right",), "stage.skip", "skip",
            "Describe the arm on a port without opening it.", "setup"),
    DeskKey("setup-back", ("left",), "stage.back", "back",
            "Go back to the previous question or list. Nothing is written.", "setup"),
    DeskKey("setup-turn", ("t",), "stage.turn", "TURN",
            "While checking motors: turn the motor a little; press again to bring it back.",
            "setup", needs=Needs.MOTORS),
    DeskKey("setup-yes", ("y",), "stage.saw('AS_SHOWN')", "as shown",
            "It moved as shown.", "setup"),
    DeskKey("setup-reversed", ("r",), "stage.saw('OTHER_WAY')", "reversed",
            "It moved the other way.", "setup"),
    DeskKey("setup-nothing", ("n",), "stage.saw('NOT_AT_ALL')", "nothing",
            "Nothing moved.", "setup"),
    DeskKey("setup-another", ("a",), "stage.another", "another",
            "Another motor's part moved; choose which one next.", "setup"),
    DeskKey("setup-double", ("d",), "stage.saw('TWICE')", "double", "It moved about twice as far.",
            "setup"),
    DeskKey("setup-half", ("h",), "stage.saw('HALF')", "half",
            "It moved about half as far.", "setup"),
)  # fmt: skip

# A model that no arm stands behind: a model may leap.
MODEL_KEYS = (
    DeskKey("model-solution", ("G",), "next_solution", "solution",
            "Show the model's next solution for the same place of the hand.", "model"),
    DeskKey("model-zero", ("Z",), "zero", "zero",
            "Set every joint of the model to zero, or to its limit nearest to zero.", "model"),
)  # fmt: skip

# The view: these move the camera, never the arm. None of them is an arrow with shift: a terminal
# that cannot tell those from plain arrows would jog.
VIEW_KEYS = (
    DeskKey("view-next", ("v",), "view('next')", "view",
            "Look at the arm from the next side: iso, side, top, front."),
    DeskKey("view-turn", ("right_parenthesis",), "view('right')", "",
            "Turn the view. Dragging with the mouse turns it too.",
            back=("left_parenthesis",), back_action="view('left')"),
    DeskKey("view-tilt", ("i",), "view('up')", "", "Look at the arm from higher or lower.",
            back=("k",), back_action="view('down')"),
    DeskKey("view-zoom", ("z",), "view('nearer')", "",
            "Zoom in on the tip, or out. The mouse wheel zooms too.",
            back=("x",), back_action="view('farther')"),
    DeskKey("view-fit", ("o",), "view('fit')", "", "Show the arm's whole reach."),
    DeskKey("view-clear", ("c",), "view('clear')", "", "Clear the drawn path of the tip."),
)  # fmt: skip

# Watching an arm that another program drives: besides the stop, all that a watcher may do to it.
WATCH_KEYS = (
    DeskKey("watch-pause", ("p",), "ask('pause')", "pause",
            "Pause the arm after its current burst.", "watch"),
    DeskKey("watch-resume", ("r",), "resume", "resume",
            "Resume a paused arm: it moves again.", "watch"),
    DeskKey("watch-speed", ("plus", "equals_sign"), "change_speed(1)", "speed",
            "Speed the arm up, at most to the speed that its program asks for, or slow it down.",
            "watch", back=("minus",)),
)  # fmt: skip


# The screens of the desk: function keys, palette and help are made from this table.


@dataclass(frozen=True, slots=True)
class KeyEntry:
    """One screen: its key, what it is called, and what it is for in a few words.

    `screen` is the place of its `DeskScreen`, which is imported when it is first shown: setting up
    probes ports, points and programs have a parser.
    """

    id: str
    key: str
    title: str
    summary: str
    screen: str


# The first one is shown first.
SCREENS = (
    KeyEntry("jog", "f2", "jog", "Move the arm by hand, joint by joint or the tip along a line.",
             "tui.jog.screen:JogScreen"),
    KeyEntry("move", "f3", "move", "Type a goal, see what the motion would be, then move.",
             "tui.move:MoveScreen"),
    KeyEntry("points", "f4", "points", "Name places, go back to them, write a program of them.",
             "tui.points:PointsScreen"),
    KeyEntry("setup", "f5", "set-up", "Find an arm, describe it in a file, and check its motors.",
             "tui.setup:SetupScreen"),
    KeyEntry("log", "f7", "log", "What passes between the arm and this program, in words.",
             "tui.log:LogScreen"),
    KeyEntry("program", "f8", "program", "Choose a program, rehearse it, run it, step through it.",
             "tui.program:ProgramScreen"),
)  # fmt: skip


def summary_of(screen: str) -> str:
    """Say which screen this is and what it is for; nothing of one that stands in no table."""
    found = (f"{entry.title}: {entry.summary}" for entry in SCREENS if entry.id == screen)
    return next(found, "")


def titled(screen: str) -> str:
    """Return what a screen is called; its id where it stands in no table (dialogs)."""
    return next((entry.title for entry in SCREENS if entry.id == screen), screen)


# The actions of the jog screen; the jog keys follow below.
JOG_KEYS = (
    DeskKey("arm", ("enter",), "arm_keys", "arm",
            "Arm the jog keys. They disarm after 60 s without a key.", "jog", needs=Needs.MOTORS),
    DeskKey("speed", ("plus", "equals_sign"), "change_speed(1)", "speed",
            "Jog faster or more slowly.", "jog", back=("minus",)),
    DeskKey("grasp", ("G",), "fingers.grasp", "grasp",
            "While armed: close the fingers until the grip switch closes.",
            "jog", also="grip gripper hold", needs=Needs.MOTORS),
    *(
        DeskKey(f"grip-{word}", (key,), f"fingers.preset({share})", "",
                f"While armed: {does}.", "jog", also="grip gripper fingers", needs=Needs.MOTORS)
        for key, word, share, does in (
            ("1", "open", 1.0, "open the fingers"),
            ("2", "half", 0.5, "bring the fingers half open"),
            ("3", "closed", 0.0, "close the fingers"),
        )
    ),
    DeskKey("park", ("K",), "park", "park",
            "Show the park posture, and go there after a question.", "jog", also="parking rest",
            needs=Needs.POSITION),
    DeskKey("details", ("D",), "details", "details",
            "Show or hide details: motors, inputs, and what goes over the wire.",
            "jog", also="wire bytes motors inputs"),
)  # fmt: skip

SCREEN_KEYS = tuple(
    DeskKey(
        f"screen-{entry.id}",
        (entry.key,),
        f"show_screen('{entry.id}')",
        entry.title,
        entry.summary,
    )
    for entry in SCREENS
)


@dataclass(frozen=True, slots=True)
class JogPair:
    """Two keys that move one axis, up and down: a joint in joint mode, else a task axis.

    The keys go by what they are in the table, on any keyboard layout.
    """

    plus: str
    minus: str
    joint: str
    cartesian: str

    @property
    def is_arrow(self) -> bool:
        """Whether the keys are arrows, which repeat what a row of letters moves."""
        return len(self.plus) > 1

    def axis(self, *, cartesian: bool) -> str:
        """Return the axis that the pair moves in this mode."""
        return self.cartesian if cartesian else self.joint


# The keys of the screen's rows, from the base to the gripper.
LETTERS = (("q", "a"), ("w", "s"), ("e", "d"), ("r", "f"), ("t", "g"), ("y", "h"), ("u", "j"))

# The arrows repeat two rows: the first two joints, and the axes that they look like.
ARROWS = (("left", "right", "base", "y"), ("up", "down", "shoulder", "z"))

TASK_AXES = ("x", "y", "z", "pitch", "roll")
GRIPPER = "gripper"
# Axes that are jogged by mm; all others turn, by degrees.
MM_AXES = ("x", "y", "z", GRIPPER)


def jog_pairs(joints: Sequence[str], *, has_yaw: bool = False) -> tuple[JogPair, ...]:
    """Return the pairs of an arm with these joints: a row for each, the gripper's last."""
    axes = (*TASK_AXES, *(("yaw",) if has_yaw else ()))
    return pairs_of((*joints, GRIPPER), (*axes, GRIPPER))


def pairs_of(joints: Sequence[str], axes: Sequence[str]) -> tuple[JogPair, ...]:
    """Return the pairs that move joints or axes: a row of letters for each of both, then arrows.

    Where there are more of the ones than of the others, the names of the rest are empty.
    """
    rows = zip(LETTERS, zip_longest(joints, axes, fillvalue=""), strict=False)
    letters = [JogPair(*keys, joint, axis) for keys, (joint, axis) in rows]
    arrows = (
        JogPair(plus, minus, joint, axis if axis in axes else "")
        for (plus, minus, _, axis), joint in zip(ARROWS, (*joints, "", ""), strict=False)
    )
    return (*letters, *(pair for pair in arrows if pair.joint or pair.cartesian))


# The pairs of an arm of the Mini-mover's build.
JOG_PAIRS = jog_pairs(JOINT_NAMES)

AXIS_KEYS = tuple(
    DeskKey(f"axis-{number}", (plus,), f"jog('{plus}')", "",
            f"Jog row {number} down or up: a joint, or in Cartesian mode a coordinate of the tip.",
            "jog model", needs=Needs.MOTORS, back=(minus,), back_action=f"jog('{minus}')")
    for number, (plus, minus) in enumerate(LETTERS, 1)
) + tuple(
    DeskKey(f"arrow-{plus}", (plus,), f"jog('{plus}')", "",
            f"Jog the {joint}; in Cartesian mode {axis}.",
            "jog model", needs=Needs.MOTORS, back=(minus,), back_action=f"jog('{minus}')")
    for plus, minus, joint, axis in ARROWS
)  # fmt: skip

# Every key of the desk. Layouts and the line of keys go by the ids.
TABLE = (
    *DESK_KEYS,
    *SCREEN_KEYS,
    *SHARED_KEYS,
    *JOG_KEYS,
    *MOVE_KEYS,
    *POINT_KEYS,
    *PROGRAM_KEYS,
    *SETUP_KEYS,
    *LOG_KEYS,
    *MODEL_KEYS,
    *VIEW_KEYS,
    *WATCH_KEYS,
    *DIALOG_KEYS,
    *AXIS_KEYS,
)


def spoken(text: str, axes: Sequence[str]) -> str:
    """Return a sentence with these axes as people write them; `wrist_pitch_deg` is left alone."""
    for axis in (each for each in axes if "_" in each):
        text = re.sub(rf"\b{re.escape(axis)}\b", shown_name(axis), text)
    return text
