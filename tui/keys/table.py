"""The keys and the screens of the desk, a table each: for bindings, footer, help, docs, tests.

What the keys are on the keyboard at hand, and how they are shown, is keyboard.py's.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from armdrive.trace.entries import Topic
from kinematics.spaces import JOINT_NAMES


@dataclass(frozen=True, slots=True)
class DeskKey:
    """One thing to do, and the keys that do it, named as the framework names them.

    `action` is a method `action_...` of the screen or the app; "part.method" is a method of one of
    its parts.
    `place` is the screen (or kind of dialog) on which they do it; without one it is all screens.
    `everywhere` keys work in every dialog too, before anything else. Rows without a description are
    never offered in the line of keys. `also` are other words by which people look for it.
    """

    id: str
    keys: tuple[str, ...]
    action: str
    description: str
    tooltip: str
    place: str = ""
    everywhere: bool = False
    also: str = ""


# Every screen of the desk, and its dialogs.

STOP = "stop"
"""The row that no file of keys can take the space bar from."""

DESK_KEYS = (
    DeskKey(STOP, ("space", "escape", "ctrl+c"), "stop_arm", "STOP",
            "Stop, disarm, close any dialog; works everywhere. Space is 0.1 s quicker than "
            "Esc.", everywhere=True),
    DeskKey("help", ("question_mark", "f1"), "dialogs.help", "help",
            "Show all keys."),
    DeskKey("quit", ("ctrl+q",), "leave", "quit",
            "Stop the arm and leave the desk.", everywhere=True),
    DeskKey("reference", ("H",), "control.reference", "reference",
            "Show the reference posture, and say that the arm stands in it. A simulated arm "
            "is led; one with switches homes by itself, after a question.",
            also="home homing origin zero"),
    DeskKey("confirm", ("C",), "control.confirm", "confirm",
            "Show the posture that the last program left, and say that the arm stands in it."),
    DeskKey("motors", ("P",), "control.switch_motors", "motors",
            "Switch the motor current on; or off, after a question, since the arm sags then."),
    DeskKey("reconnect", ("L",), "control.reconnect", "link",
            "Look for a lost link once, now. Moves nothing; what was under way is not taken "
            "up again."),
    DeskKey("palette", ("ctrl+p",), "dialogs.palette", "commands",
            "Find by a few letters what can be done here; enter does it."),
    DeskKey("look", ("T",), "looks.put_on_next", "look",
            "Other colours: dark, light, of high contrast, or your terminal's own."),
    DeskKey("reset", ("R",), "control.reset", "reset",
            "Leave error-stop. Moves nothing.", also="clear error unlock"),
    DeskKey("estop", ("X",), "control.estop", "e-stop",
            "Stop and latch error-stop: nothing moves until a reset.", also="estop emergency"),
)  # fmt: skip
"""What can be done on every screen."""

DIALOG_KEYS = (
    DeskKey("help-close", ("question_mark", "f1", "enter", "n"), "close", "close",
            "Close it.", "help"),
    DeskKey("understood", ("enter",), "close", "understood",
            "Go to the desk.", "first"),
    DeskKey("yes", ("y",), "answer(True)", "yes",
            "It is so: do it.", "question"),
    DeskKey("no", ("n",), "answer(False)", "no",
            "It is not so: do nothing.", "question"),
)  # fmt: skip
"""Enter answers no question: a person who armed with it may still be pressing it."""


# The screens that plan motion: move and points.

MOVE_KEYS = (
    DeskKey("move-go", ("enter",), "planned.press", "go (twice)",
            "Press twice: the arm moves as it is shown. A key that is held does not count.",
            "move"),
    DeskKey("move-next", ("down", "tab"), "form.move_to_field(1)", "next",
            "Go to the next field.", "move"),
    DeskKey("move-previous", ("up", "shift+tab"), "form.move_to_field(-1)", "",
            "Go to the field before.", "move"),
    DeskKey("move-more", ("right",), "form.change_value(1)", "more",
            "Make the field larger by a step.", "move"),
    DeskKey("move-less", ("left",), "form.change_value(-1)", "less",
            "Make it smaller by a step.", "move"),
    DeskKey("move-erase", ("backspace",), "typing.erase", "",
            "Take the last character of the field away; an empty field stays as it is.", "move"),
    DeskKey("move-clear", ("delete",), "form.clear", "clear",
            "Empty all fields: the arm would stay where it is.", "move"),
    DeskKey("move-nearest", ("n",), "take_nearest", "nearest",
            "After a refusal: ask for the nearest goal that is possible.", "move"),
    DeskKey("move-posture", ("b",), "take_next_posture", "posture",
            "Ask for the next posture that holds the hand at this goal, by its joints.", "move"),
    DeskKey("move-mode", ("m",), "form.switch_mode", "mode",
            "Switch between joint angles and poses.", "move"),
    DeskKey("move-line", ("l",), "form.switch_line", "line",
            "Switch between a straight line of the tip and a joint motion.", "move"),
    DeskKey("move-frame", ("F",), "form.next_frame", "frame",
            "Which frame the pose is one of; of the tool, it is a change from where it is.",
            "move"),
    DeskKey("move-slower", ("less_than_sign",), "form.change_speed(-1)", "slower",
            "Move more slowly.", "move"),
    DeskKey("move-faster", ("greater_than_sign",), "form.change_speed(1)", "faster",
            "Move faster.", "move"),
    DeskKey("move-finer", ("left_square_bracket",), "form.change_step(-1)", "finer",
            "Make the arrows' step smaller.", "move"),
    DeskKey("move-coarser", ("right_square_bracket",), "form.change_step(1)", "coarser",
            "Make the arrows' step larger.", "move"),
)  # fmt: skip
"""Digits, the point and the minus are typed into the field, and are no rows of the table."""

POINT_KEYS = (
    DeskKey("points-go", ("enter",), "press_go", "go (twice)",
            "Press twice: the arm goes to the point as it is shown, or carries out the rest of the "
            "sequence. A key that is held does not count.", "points"),
    DeskKey("points-next", ("down",), "choose(1)", "next",
            "Go to the next point or sequence.", "points"),
    DeskKey("points-previous", ("up",), "choose(-1)", "",
            "Go to the point or sequence before.", "points"),
    DeskKey("points-teach", ("t",), "points.teach", "teach",
            "Name the place where the arm stands. Type the name, then enter.", "points"),
    DeskKey("points-again", ("U",), "points.teach_again", "again",
            "Press twice: the point is moved to where the arm stands.", "points"),
    DeskKey("points-rename", ("r",), "points.rename", "rename",
            "Give the point another name, in sequences too.", "points"),
    DeskKey("points-delete", ("delete",), "points.delete", "delete",
            "Press twice: the point or sequence is taken out of the file.", "points"),
    DeskKey("points-edit", ("e",), "points.move_there", "edit",
            "Change the point's joints as a goal on the move screen; there, go, and teach it "
            "again here.", "points"),
    DeskKey("points-line", ("l",), "motion.switch_line", "line",
            "Switch between a straight line of the tip and a joint motion; also of a marked step.",
            "points"),
    DeskKey("points-slower", ("less_than_sign",), "motion.change_speed(-1)", "slower",
            "Move more slowly; also in a marked step.", "points"),
    DeskKey("points-faster", ("greater_than_sign",), "motion.change_speed(1)", "faster",
            "Move faster; also in a marked step.", "points"),
    DeskKey("points-append", ("a",), "points.append", "append",
            "Put the point at the end of a sequence, reached in the way and at the speed shown.",
            "points"),
    DeskKey("points-shorten", ("backspace",), "steps.shorten", "",
            "Take the last step of the sequence away; of a name, the last letter.", "points"),
    DeskKey("points-step-next", ("pagedown",), "steps.mark(1)", "mark",
            "Of a sequence: mark its next step, to be taken out or moved.", "points"),
    DeskKey("points-step-previous", ("pageup",), "steps.mark(-1)", "",
            "Of a sequence: mark the step before.", "points"),
    DeskKey("points-step-drop", ("D",), "steps.drop", "",
            "Press twice: the marked step is taken out of the sequence.", "points"),
    DeskKey("points-step-sooner", ("K",), "steps.shift(-1)", "",
            "The marked step is carried out one place sooner.", "points"),
    DeskKey("points-step-later", ("J",), "steps.shift(1)", "",
            "The marked step is carried out one place later.", "points"),
    DeskKey("points-step-change", ("E",), "steps.change", "",
            "Change the marked step: type another point, opening or time.", "points"),
    DeskKey("points-grip", ("g",), "steps.add_grip", "fingers",
            "Of a sequence: add a gripper step after the marked step, or at the end. "
            "Type open, close, grasp, here, point (the point's opening) or mm, then enter.",
            "points"),
    DeskKey("points-wait", ("W",), "steps.add_wait", "wait",
            "Of a sequence: add a wait after the marked step, or at the end. Type seconds, "
            "then enter.",
            "points"),
    DeskKey("points-stepping", ("s",), "sequence.switch_stepping", "stepping",
            "Let right and left carry out single steps of the sequence, until it is pressed again.",
            "points"),
    DeskKey("points-forward", ("right",), "sequence.forward", "step",
            "While stepping: carry out the next step of the sequence.", "points"),
    DeskKey("points-backward", ("left",), "sequence.backward", "back",
            "While stepping: go back to the point before. Fingers and waits are not taken back.",
            "points"),
    DeskKey("points-rewind", ("home",), "sequence.rewind", "rewind",
            "Start the sequence over. Moves nothing.", "points"),
    DeskKey("points-pause", ("p",), "pause", "pause",
            "Pause the arm after its next burst, or let it go on.", "points"),
)  # fmt: skip
"""Names are typed once they are asked for; their letters are no rows of the table."""

PROGRAM_KEYS = (
    DeskKey("program-go", ("enter",), "start.press", "go (twice)",
            "Press twice: the program runs as it was rehearsed; one that was not is rehearsed "
            "first. A key that is held does not count.", "program", also="run start play"),
    DeskKey("program-next", ("down",), "choose(1)", "next",
            "Choose the next program of the list.", "program"),
    DeskKey("program-previous", ("up",), "choose(-1)", "", "Choose the program before.", "program"),
    DeskKey("program-rehearse", ("r",), "start.rehearse", "rehearse",
            "Rehearse the program on the arm's simulated twin: how long it takes, what it assumes, "
            "and the line that would fail. Nothing moves.", "program", also="check simulate"),
    DeskKey("program-pause", ("p",), "run.switch_pause", "pause",
            "Pause the program after its next burst, or let it go on; also where it waits for "
            "you.", "program"),
    DeskKey("program-stepping", ("s",), "run.switch_stepping", "stepping",
            "Have the program wait for you before each motion, until it is pressed again.",
            "program"),
    DeskKey("program-forward", ("right",), "run.forward", "step",
            "Let a program go on that waits for you. A key that is held does not count.",
            "program"),
    DeskKey("program-down", ("pagedown",), "turn_page(1)", "",
            "Show the lines further down, while none of them runs.", "program"),
    DeskKey("program-up", ("pageup",), "turn_page(-1)", "", "Show the lines further up.",
            "program"),
)  # fmt: skip
"""A stop ends a program at once; leaving the screen ends it after the motion under way."""


# The log and its dialogs. None of these keys moves the arm.

LOG_KEYS = (
    DeskKey("log-open", ("enter",), "open_line", "open",
            "Show the whole line; of an error its cause and what to do.", "log"),
    DeskKey("log-find", ("slash",), "find", "find",
            "Show only the lines with a text; commas between words that must all be there.", "log"),
    DeskKey("log-all", ("a",), "log_view.show_all", "all",
            "Show everything again, the newest last.", "log"),
    DeskKey("log-pause", ("p",), "log_view.switch_hold", "hold",
            "Hold the lines still, or let them come again. The arm is not paused by it.", "log"),
    DeskKey("log-save", ("s",), "save", "save",
            "Write what the flight recorder holds to a file, and say where it is.", "log"),
    DeskKey("log-catalogue", ("e",), "catalogue", "all errors",
            "Look up what every error means and what to do.", "log"),
    DeskKey("log-up", ("up",), "log_view.go(-1)", "older", "Choose the line before.", "log"),
    DeskKey("log-down", ("down",), "log_view.go(1)", "", "Choose the next line.", "log"),
    DeskKey("log-page-up", ("pageup",), "log_view.turn_page(-1)", "", "Go back by a page.", "log"),
    DeskKey("log-page-down", ("pagedown",), "log_view.turn_page(1)", "", "Go on by a page.", "log"),
    DeskKey("log-first", ("home",), "log_view.go_first", "", "Go to the oldest line.", "log"),
    DeskKey("log-last", ("end",), "log_view.follow", "newest",
            "Follow the newest line again.", "log"),
    *(
        DeskKey(f"log-{topic.value}", (str(number),), f"log_view.switch_topic('{topic.value}')",
                topic.value, f"Show the {topic.value} or leave them out.", "log")
        for number, topic in enumerate(Topic, 1)
    ),
)  # fmt: skip
"""The head of the screen names the keys of the topics, so that they come last in the footer."""

LOG_DIALOG_KEYS = (
    DeskKey("line-close", ("enter", "n"), "close", "close", "Close it.", "line"),
    DeskKey("find-done", ("enter",), "close", "done", "Keep the text, and close.", "find"),
    DeskKey("find-erase", ("backspace",), "typing.erase", "",
            "Take the last character away.", "find"),
    DeskKey("find-clear", ("delete",), "typing.clear", "", "Take all characters away.", "find"),
    DeskKey("catalogue-close", ("enter",), "close", "close", "Close it.", "catalogue"),
    DeskKey("catalogue-erase", ("backspace",), "typing.erase", "",
            "Take the last character away.", "catalogue"),
    DeskKey("catalogue-clear", ("delete",), "typing.clear", "",
            "Take all characters away.", "catalogue"),
    DeskKey("catalogue-up", ("up",), "choose(-1)", "", "Choose the error before.", "catalogue"),
    DeskKey("catalogue-down", ("down",), "choose(1)", "", "Choose the next error.", "catalogue"),
)  # fmt: skip
"""What is typed into a search is no row of the table."""


# The set-up screen. Only `t` moves anything.

SETUP_KEYS = (
    DeskKey("setup-enter", ("enter",), "stage.enter", "go on",
            "Do what is marked. What opens a port or writes a file asks for a second press.",
            "setup"),
    DeskKey("setup-next", ("down", "tab"), "mark(1)", "next",
            "Mark the next line.", "setup"),
    DeskKey("setup-previous", ("up", "shift+tab"), "mark(-1)", "", "Mark the line before.",
            "setup"),
    DeskKey("setup-on", ("right",), "stage.skip", "skip",
            "Of a port: go on to describe the arm without opening it.", "setup"),
    DeskKey("setup-back", ("left",), "stage.back", "back",
            "Go back to the question or the list before. Nothing is written.", "setup"),
    DeskKey("setup-erase", ("backspace",), "typing.erase", "",
            "Take the last character away.", "setup"),
    DeskKey("setup-turn", ("t",), "stage.turn", "TURN",
            "While motors are checked: turn the motor a little; once more: bring it back.",
            "setup"),
    DeskKey("setup-yes", ("y",), "stage.saw('AS_SHOWN')", "as shown",
            "It moved as shown.", "setup"),
    DeskKey("setup-reversed", ("r",), "stage.saw('OTHER_WAY')", "reversed",
            "It moved the other way.",
            "setup"),
    DeskKey("setup-nothing", ("n",), "stage.saw('NOT_AT_ALL')", "nothing",
            "Nothing moved.", "setup"),
    DeskKey("setup-another", ("a",), "stage.another", "another",
            "Another motor's part moved: which one is chosen next.", "setup"),
    DeskKey("setup-double", ("d",), "stage.saw('TWICE')", "double", "It moved about twice as far.",
            "setup"),
    DeskKey("setup-half", ("h",), "stage.saw('HALF')", "half",
            "It moved about half as far.", "setup"),
)  # fmt: skip
"""While text is typed, printable keys are typed and do nothing else; space is never typed."""


# The theory of an arm, and a model that no arm stands behind.

THEORY_KEYS = (
    DeskKey("theory-next", ("pagedown", "N"), "panel.turn(1)", "next page",
            "Go on to the next matrices, singularities, solutions.", "theory"),
    DeskKey("theory-previous", ("pageup", "B"), "panel.turn(-1)", "back",
            "Go back to the page before.", "theory"),
    DeskKey("theory-symbols", ("S",), "panel.switch_symbols", "symbols",
            "Switch between numbers and the notes' own C1, S12.", "theory"),
    DeskKey("theory-axes", ("A",), "panel.switch_axes", "from axes",
            "Find frames and link table from the joint axes, a step a page; again: in the other "
            "convention, then back to the numbers.", "theory"),
)  # fmt: skip
"""They only turn pages: nothing on the theory screen moves an arm."""

MODEL_KEYS = (
    DeskKey("model-solution", ("G",), "solution", "solution",
            "Put the model into its next solution for the same place of the hand.", "model"),
    DeskKey("model-zero", ("Z",), "zero", "zero",
            "Put every joint of the model at zero, or at the limit nearest to it.", "model"),
)  # fmt: skip
"""Only where no arm is connected: a model may leap."""


# The view: these move the camera, never the arm. None of them is an arrow with shift: a terminal
# that cannot tell those from plain arrows would jog.

VIEW_KEYS = (
    DeskKey("view-next", ("v",), "view('next')", "view",
            "Look at the arm from the next side: iso, side, top, front."),
    DeskKey("view-left", ("left_parenthesis",), "view('left')", "",
            "Go round the arm to the left; the mouse does it by dragging."),
    DeskKey("view-right", ("right_parenthesis",), "view('right')", "",
            "Go round the arm to the right."),
    DeskKey("view-up", ("i",), "view('up')", "", "Look at the arm from higher up."),
    DeskKey("view-down", ("k",), "view('down')", "", "Look at the arm from lower down."),
    DeskKey("view-nearer", ("z",), "view('nearer')", "",
            "Come nearer to the tip; the mouse wheel does it too."),
    DeskKey("view-farther", ("x",), "view('farther')", "", "Go farther away."),
    DeskKey("view-fit", ("o",), "view('fit')", "", "Show all of the arm's reach again."),
    DeskKey("view-clear", ("c",), "view('clear')", "",
            "Forget the way that the tip has gone, as it is drawn."),
)  # fmt: skip
"""What can be done wherever an arm is drawn."""


# Watching an arm that another program drives.

WATCH_KEYS = (
    DeskKey("watch-pause", ("p",), "ask('pause')", "pause",
            "Pause the arm after what it was sent; it goes on when it is resumed.", "watch"),
    DeskKey("watch-resume", ("r",), "ask('resume')", "resume",
            "Let a paused arm go on: it moves again.", "watch"),
    DeskKey("watch-slower", ("minus",), "change_speed(-1)", "slower",
            "Slow the arm down.", "watch"),
    DeskKey("watch-faster", ("plus", "equals_sign"), "change_speed(1)", "faster",
            "Let the arm go faster, at most at the speed that its program asks for.", "watch"),
)  # fmt: skip
"""Besides the stop, all that a watcher may do to the arm."""


# The screens of the desk: function keys, palette and help are made from this table. Which class
# shows which of them is the desk's to say: a `DeskScreen` (desk.py says what that needs).


@dataclass(frozen=True, slots=True)
class KeyEntry:
    """One screen: its key, what it is called, and what it is for in a few words."""

    id: str
    key: str
    title: str
    summary: str


SCREENS = (
    KeyEntry("jog", "f2", "jog", "Move the arm by hand, joint by joint or the tip along a line."),
    KeyEntry("move", "f3", "move", "Type a goal, see what the motion would be, then move."),
    KeyEntry("points", "f4", "points", "Name places, go back to them, step through sequences."),
    KeyEntry("setup", "f5", "set-up", "Find an arm, describe it in a file, and check its motors."),
    KeyEntry(
        "theory", "f6", "theory", "Matrices, Jacobian, singularities of the arm as it stands."
    ),
    KeyEntry("log", "f7", "log", "What passes between the arm and this program, in words."),
    KeyEntry("program", "f8", "program", "Choose a program, rehearse it, run it, step through it."),
)
"""The first one is shown first."""


def summary_of(screen: str) -> str:
    """Say which screen this is and what it is for; nothing of one that stands in no table."""
    found = (f"{entry.title}: {entry.summary}" for entry in SCREENS if entry.id == screen)
    return next(found, "")


def titled(screen: str) -> str:
    """Return what a screen is called; its id where it stands in no table (dialogs)."""
    return next((entry.title for entry in SCREENS if entry.id == screen), screen)


JOG_KEYS = (
    DeskKey("arm", ("enter",), "arm_keys", "arm",
            "Arm the jog keys; they disarm after 60 s idle.", "jog"),
    DeskKey("mode", ("m",), "adjustments.switch_mode", "mode",
            "Switch between joint and Cartesian mode.", "jog"),
    DeskKey("finer", ("left_square_bracket",), "adjustments.change_step(-1)", "finer",
            "Make the step smaller: degrees in joint mode, mm in Cartesian mode.", "jog"),
    DeskKey("coarser", ("right_square_bracket",), "adjustments.change_step(1)", "coarser",
            "Make the step larger: degrees in joint mode, mm in Cartesian mode.", "jog"),
    DeskKey("slower", ("minus",), "adjustments.change_speed(-1)", "slower",
            "Jog more slowly.", "jog"),
    DeskKey("faster", ("plus", "equals_sign"), "adjustments.change_speed(1)", "faster",
            "Jog faster.", "jog"),
    DeskKey("grasp", ("G",), "fingers.grasp", "grasp",
            "While armed: close the fingers on what is between them, until the grip switch "
            "closes.", "jog", also="grip gripper hold"),
    *(
        DeskKey(f"grip-{word}", (key,), f"fingers.preset({share})", "",
                f"While armed: {does}.", "jog", also="grip gripper fingers")
        for key, word, share, does in (
            ("1", "open", 1.0, "open the fingers"),
            ("2", "half", 0.5, "bring the fingers half open"),
            ("3", "closed", 0.0, "close the fingers"),
        )
    ),
    DeskKey("park", ("K",), "park", "park",
            "Show the park posture, and go there after a question.", "jog", also="parking rest"),
    DeskKey("details", ("D",), "details", "details",
            "Show or hide the details: motors, inputs, and what goes over the wire.",
            "jog", also="wire bytes motors inputs"),
    DeskKey("frame", ("F",), "adjustments.next_frame", "frame",
            "In Cartesian mode, whose x, y and z are meant: the base's, the tool's, or those "
            "of a frame of the arm file.", "jog"),
)  # fmt: skip
"""What the jog screen does besides jogging: the keys that jog follow below."""

SCREEN_KEYS = tuple(
    DeskKey(
        f"screen-{entry.id}",
        (entry.key,),
        f"screens.show('{entry.id}')",
        entry.title,
        entry.summary,
    )
    for entry in SCREENS
)


@dataclass(frozen=True, slots=True)
class JogPair:
    """Two keys that move one axis, up and down: a joint in joint mode, else a task axis.

    The keys go by what they are in the table, wherever a file of keys has put them.
    """

    plus: str
    minus: str
    joint: str
    cartesian: str

    def axis(self, *, cartesian: bool) -> str:
        """Return the axis that the pair moves in this mode."""
        return self.cartesian if cartesian else self.joint


LETTERS = (("q", "a"), ("w", "s"), ("e", "d"), ("r", "f"), ("t", "g"), ("y", "h"), ("u", "j"))
"""The keys of the screen's rows, from the base to the gripper."""

ARROWS = (("left", "right", "base", "y"), ("up", "down", "shoulder", "z"))
"""The arrows repeat two rows: the first two joints, and the axes that they look like."""

TASK_AXES = ("x", "y", "z", "pitch", "roll")
GRIPPER = "gripper"
MM_AXES = ("x", "y", "z", GRIPPER)
"""Axes that are jogged by mm; all others turn, by degrees."""


def jog_pairs(joints: Sequence[str], *, has_yaw: bool = False) -> tuple[JogPair, ...]:
    """Return the pairs of an arm with these joints: a row for each, the gripper's last."""
    axes = (*TASK_AXES, *(("yaw",) if has_yaw else ()))
    rows = zip(LETTERS, (*joints, GRIPPER), (*axes, GRIPPER), strict=False)
    letters = (JogPair(*keys, joint, axis) for keys, joint, axis in rows)
    arrows = (
        JogPair(plus, minus, joint, axis)
        for (plus, minus, _, axis), joint in zip(ARROWS, joints, strict=False)
    )
    return (*letters, *arrows)


JOG_PAIRS = jog_pairs(JOINT_NAMES)
"""The pairs of an arm of the Mini-mover's build."""

ALL_JOG_KEYS = tuple(key for pair in (*LETTERS, *ARROWS) for key in pair[:2])
"""Every key that jogs on some arm."""

_WAYS = ("plus", "minus")

AXIS_KEYS = tuple(
    DeskKey(
        f"axis-{number}-{way}",
        (key,),
        f"jog('{key}')",
        "",
        f"Jog row {number} of the joints, {way}; in Cartesian mode that axis of the tip.",
        "jog",
    )
    for number, keys in enumerate(LETTERS, 1)
    for way, key in zip(_WAYS, keys, strict=True)
) + tuple(
    DeskKey(
        f"arrow-{key}",
        (key,),
        f"jog('{key}')",
        "",
        f"Jog the {joint}, {way}; in Cartesian mode {axis}.",
        "jog",
    )
    for *keys, joint, axis in ARROWS
    for way, key in zip(_WAYS, keys, strict=True)
)

TABLE = (
    *DESK_KEYS,
    *SCREEN_KEYS,
    *JOG_KEYS,
    *MOVE_KEYS,
    *POINT_KEYS,
    *PROGRAM_KEYS,
    *SETUP_KEYS,
    *THEORY_KEYS,
    *LOG_KEYS,
    *LOG_DIALOG_KEYS,
    *MODEL_KEYS,
    *VIEW_KEYS,
    *WATCH_KEYS,
    *DIALOG_KEYS,
    *AXIS_KEYS,
)
"""Every key of the desk. Ids are for good: files of keys go by them."""


def words(axis: str) -> str:
    """Return an axis as people write it."""
    return axis.replace("_", " ")


def spoken(text: str, axes: Sequence[str]) -> str:
    """Return a sentence with these axes as people write them; `wrist_pitch_deg` is left alone."""
    for axis in (each for each in axes if "_" in each):
        text = re.sub(rf"\b{re.escape(axis)}\b", words(axis), text)
    return text
