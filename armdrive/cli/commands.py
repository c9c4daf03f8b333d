"""The table of commands and the table of exit codes: plain text, which `armdrive --help` shows."""

from __future__ import annotations

from types import MappingProxyType

TYPE_CHECKING = False  # as typing's, which is slow to import
if TYPE_CHECKING:
    from collections.abc import Mapping

# Every command by group: its function, written `drive.move:move`, and its few words in
# `armdrive --help`.
#
# A command with actions, as `points`, has a function for each of them, in the table of its group.
# The arguments of a group are light to load: `--help` of a command needs no more. The module of a
# function may load all that drives an arm.
GROUPS: Mapping[str, Mapping[str, tuple[str, str]]] = MappingProxyType({
    "Drive": {
        "home": ("drive.home:home", "set the reference"),
        "stop": ("drive.control_requests:stop", "stop a moving arm"),
        "jog": ("drive.jog:jog", "drive from the keyboard"),
        "pause": ("drive.control_requests:pause", "pause a moving arm"),
        "move": ("drive.move:move", "go to a pose or to angles"),
        "resume": ("drive.control_requests:resume", "continue a paused arm"),
        "points": ("drive", "save places, go to them"),
        "slow": ("drive.control_requests:slow", "slow a moving arm down"),
        "enable": ("drive.motors:enable", "switch the motors on"),
        "reset": ("drive.motors:reset", "clear an error"),
        "disable": ("drive.motors:disable", "switch the motors off"),
        "verify": ("drive.home:verify", "measure the drift"),
    },
    "Program": {
        "run": ("program.run:run", "run or check a program"),
        "teach": ("program.teach:record", "record a taught program"),
        "shell": ("program.shell:run", "type program words"),
        "pendant": ("program", "copy the arm's program"),
        "demo": ("program.demo:run", "watch blocks being stacked"),
    },
    "Set up": {
        "config": ("set_up", "write and check arm files"),
        "sim": ("set_up.sim:sim", "run a simulated arm"),
        "ports": ("set_up.ports:ports", "list the serial ports"),
        "can": ("set_up", "set up CAN drives"),
        "doctor": ("set_up.doctor:doctor", "find what is connected"),
        "completion": ("set_up.completion:completion", "complete words on Tab"),
    },
    "Look": {
        "status": ("look.status:status", "show where the arm is"),
        "record": ("drive.control_requests:record", "save what just happened"),
        "watch": ("look.status:watch", "follow a moving arm"),
        "log": ("look.log:log", "read a recording"),
        "replay": ("look.replay:replay_recording", "compare it with simulation"),
    },
    "Learn": {
        "errors": ("learn.errors:errors", "look up an error code"),
        "fk": ("learn.poses:fk", "pose of joint angles"),
        "explain": ("learn.explain:explain", "compute an arm in steps"),
        "ik": ("learn.poses:ik", "joint angles of a pose"),
        "plot": ("learn.plot:plot", "draw what an arm can reach"),
    },
})  # fmt: skip

# The same by the name of the command alone.
ROWS = MappingProxyType({name: row for rows in GROUPS.values() for name, row in rows.items()})

COMMANDS = tuple(ROWS)

# `armdrive help exit-codes` prints the table below.
EXIT_CODES_TOPIC = "exit-codes"

# Exit codes of what is no `ArmError`, which has its own; 70 is EX_SOFTWARE of sysexits.h.
USAGE, REFUSED, FAULT, INTERRUPTED = 2, 3, 70, 130

# What the command line ends with.
EXIT_CODES: Mapping[int, str] = MappingProxyType(
    {
        0: "done",
        1: "something went wrong, or a check at the end failed",
        USAGE: "the command itself is wrong: an option, a number, an arm file, a program",
        REFUSED: "refused: out of reach, beyond a limit, not referenced; nothing moved",
        4: "the port cannot be opened, was lost, or another program has the arm",
        5: "stopped before the end",
        6: "the controller did not answer as it should",
        FAULT: "a fault of armdrive itself; the message names the file with the details",
        129: "ended by SIGHUP (the terminal was closed); the arm was stopped",
        INTERRUPTED: "interrupted by Ctrl-C; the arm was stopped",
        143: "ended by SIGTERM; the arm was stopped",
    }
)
