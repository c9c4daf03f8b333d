"""The command line: one table of commands, each imported only when it is called.

Nothing heavy is imported on the way to `armdrive --help`.
"""

from __future__ import annotations

import sys
from types import MappingProxyType

TYPE_CHECKING = False  # as typing's, which is slow to import
if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

COMMANDS: Mapping[str, str] = MappingProxyType(
    {
        "demo": "watch the simulated arm pick and place blocks",
        "jog": "drive an arm from the keyboard",
        "move": "move an arm to joint angles or to a pose",
        "run": "run a program, or rehearse it: a program file or a Python script",
        "shell": "type the words of a program at a prompt, each carried out at once",
        "points": "name places of an arm, and go to them; step through sequences of them",
        "teach": "record sequences as the arm is moved, and edit them step by step",
        "pendant": "the program in an arm's own memory: into a file, and back",
        "home": "reference an arm in its reference posture",
        "verify": "measure at the reference mark how far an arm has drifted",
        "enable": "switch the motors on, where the controller can",
        "reset": "leave an error, after looking at the arm; moves nothing",
        "disable": "switch the motors off, which lets the arm sag: parks it first",
        "stop": "stop an arm that another program drives",
        "pause": "have an arm wait that another program drives",
        "resume": "let a paused arm go on",
        "slow": "have an arm go slower than the program that drives it asks for",
        "watch": "watch an arm that another program drives",
        "status": "show where an arm is, and whether that can be trusted",
        "record": "write down what has passed between an arm and the program that drives it",
        "log": "read a recording in words: bytes, requests, intents, states, errors",
        "replay": "replay a recording against a simulated twin, and show where they part",
        "fk": "joint angles to the pose of the finger tips",
        "ik": "a pose to joint angles, every solution",
        "explain": "an arm worked out: link table, A matrices, forward, every inverse",
        "plot": "draw what an arm can reach",
        "config": "arm files: write one by an interview, list, show, check them",
        "ports": "list the serial ports, who has them, and which arm files name them",
        "can": "set up drives on a CAN bus, and watch what passes there",
        "doctor": "find out what a port leads to, and what is wrong with it; moves nothing",
        "sim": "run a simulated arm that speaks the real bytes",
        "errors": "what an error means for the arm, and what to do, by its code",
    }
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
    if words and words[0] in COMMANDS:
        from armdrive.cli.running import run_command

        return run_command(words[0], words[1:])
    return _no_command(words)


def _no_command(words: list[str]) -> int:
    word = words[0] if words else "--help"
    if word in ("-h", "--help"):
        sys.stdout.write(_help())
        return 0
    if word == "--version":
        from importlib.metadata import version

        sys.stdout.write(f"armdrive {version('armdrive')}\n")
        return 0
    return _unknown(word)


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


def _unknown(word: str) -> int:
    import difflib

    from armdrive.cli.output import put_error
    from armdrive.errors.table import named
    from armdrive.text.printable import as_message

    code = named("BadRequest").code
    near = difflib.get_close_matches(word, COMMANDS, n=1)
    hint = f"did you mean `armdrive {near[0]}`?" if near else "`armdrive --help` lists them all"
    put_error(as_message(f"armdrive: [{code}] there is no command {word!r}; {hint}\n"))
    return 2
