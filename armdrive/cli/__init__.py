"""The command line: one table of commands, whose modules are loaded only when they are called.

Nothing heavy is imported on the way to `armdrive --help`.
"""

from __future__ import annotations

import sys
from types import MappingProxyType

TYPE_CHECKING = False  # as typing's, which is slow to import
if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

_COMMANDS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "demo": ("program.demo:run", "watch the simulated arm pick and place blocks"),
        "jog": ("drive.jog:jog", "drive an arm from the keyboard"),
        "move": ("drive.move:move", "move an arm to joint angles or to a pose"),
        "run": (
            "program.run:run",
            "run a program, or rehearse it: a program file or a Python script",
        ),
        "shell": (
            "program.shell:run",
            "type the words of a program at a prompt, each carried out at once",
        ),
        "points": (
            "drive",
            "name places of an arm, and go to them; step through sequences of them",
        ),
        "teach": ("program", "record sequences as the arm is moved, and edit them step by step"),
        "pendant": ("drive", "the program in an arm's own memory: into a file, and back"),
        "home": ("drive.home:home", "reference an arm in its reference posture"),
        "verify": ("drive.home:verify", "measure at the reference mark how far an arm has drifted"),
        "enable": ("drive.motors:enable", "switch the motors on, where the controller can"),
        "reset": ("drive.motors:reset", "leave an error, after looking at the arm; moves nothing"),
        "disable": (
            "drive.motors:disable",
            "switch the motors off, which lets the arm sag: parks it first",
        ),
        "stop": ("drive.control_requests:stop", "stop an arm that another program is driving"),
        "pause": ("drive.control_requests:pause", "pause an arm that another program is driving"),
        "resume": ("drive.control_requests:resume", "resume a paused arm"),
        "slow": (
            "drive.control_requests:slow",
            "slow down an arm that another program is driving",
        ),
        "watch": ("look.status:watch", "watch an arm that another program is driving"),
        "status": ("look.status:status", "show where an arm is, and whether that can be trusted"),
        "record": (
            "drive.control_requests:record",
            "save a recording of an arm that another program is driving",
        ),
        "log": (
            "look.recordings:log",
            "read a recording in words: bytes, requests, intents, states, errors",
        ),
        "replay": (
            "look.recordings:replay_recording",
            "replay a recording against a simulated arm, and show where they differ",
        ),
        "fk": ("learn.poses:fk", "joint angles to the pose of the finger tips"),
        "ik": ("learn.poses:ik", "a pose to joint angles, every solution"),
        "explain": (
            "learn.explain:explain",
            "an arm worked out: link table, A matrices, forward, every inverse",
        ),
        "plot": ("learn.plot:plot", "draw what an arm can reach"),
        "config": ("set_up", "arm files: write one by an interview, list, show, check them"),
        "ports": (
            "set_up.ports:ports",
            "list the serial ports, who has them, and which arm files name them",
        ),
        "can": ("set_up", "set up drives on a CAN bus, and watch what passes there"),
        "doctor": (
            "set_up.doctor:doctor",
            "find out what a port leads to, and what is wrong with it; moves nothing",
        ),
        "sim": ("set_up.sim:sim", "run a simulated arm that speaks the real bytes"),
        "errors": (
            "learn.errors:errors",
            "what an error means for the arm, and what to do, by its code",
        ),
    }
)
"""Every command: its function, written `drive.move:move`, and its line of help.

A command with actions, as `points`, has a function for each of them, in the table of its group.
The arguments of a group are light to load: `--help` of a command needs no more. The module of a
function may load all that drives an arm.
"""

COMMANDS: Mapping[str, str] = MappingProxyType(
    {name: text for name, (_, text) in _COMMANDS.items()}
)
"""Every command with its line of help."""

EXIT_CODES: Mapping[int, str] = MappingProxyType(
    {
        0: "done",
        1: "something went wrong, or a check at the end failed",
        2: "the command itself is wrong: an option, a number, an arm file",
        3: "refused: out of reach, beyond a limit, not referenced; nothing moved",
        4: "the port or its holder: cannot be opened, lost, in use",
        5: "stopped before the end",
        6: "the controller answered something else than it should have",
        70: "a fault of armdrive itself; the sentence names the file with the details",
        129: "ended by SIGHUP, a closed terminal; the arm was stopped",
        130: "interrupted by Ctrl-C; the arm was stopped",
        143: "ended by SIGTERM; the arm was stopped",
    }
)
"""What the command line ends with."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    words = list(sys.argv[1:] if argv is None else argv)
    word = words[0] if words else "--help"
    if word in ("-h", "--help"):
        sys.stdout.write(_help())
        return 0
    if word == "--version":
        from importlib.metadata import version

        sys.stdout.write(f"armdrive {version('armdrive')}\n")
        return 0
    from armdrive.cli.runner import refuse, run_command

    if word not in COMMANDS:
        return refuse(word, COMMANDS)
    function, summary = _COMMANDS[word]
    return run_command(word, summary, function, words[1:])


def _help() -> str:
    """Return the help of the whole, made from the tables above.

    Written out here because argparse alone would take longer than everything else on this path.
    """
    width = max(map(len, (*COMMANDS, "--version"))) + 2
    commands = "".join(f"  {name:<{width}}{text}\n" for name, text in COMMANDS.items())
    codes = "".join(f"  {code:<{width}}{text}\n" for code, text in EXIT_CODES.items())
    return (
        "usage: armdrive COMMAND [options]      (armdrive COMMAND --help tells more)\n\n"
        "Drive Mini-mover-style robot arms, real or simulated.\n\n"
        f"commands:\n{commands}\n"
        f"options:\n  {'--help':<{width}}print this\n  {'--version':<{width}}print the version\n\n"
        f"exit codes:\n{codes}\n"
        "With no arm named, the simulated TeachMover is used, and every output says so.\n"
    )
