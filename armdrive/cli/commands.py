"""The table of commands and the table of exit codes: plain text, which `armdrive --help` shows."""

from __future__ import annotations

from types import MappingProxyType

TYPE_CHECKING = False  # as typing's, which is slow to import
if TYPE_CHECKING:
    from collections.abc import Mapping

GROUPS: Mapping[str, Mapping[str, tuple[str, str, str]]] = MappingProxyType({
    "Drive": {
        "home": ("drive.home:home", "set the reference",
            "set the reference: bring the arm to its reference posture, and confirm it"),
        "stop": ("drive.control_requests:stop", "stop a moving arm",
            "stop an arm that another program is driving"),
        "jog": ("drive.jog:jog", "drive from the keyboard",
            "drive an arm from the keyboard"),
        "pause": ("drive.control_requests:pause", "pause a moving arm",
            "pause an arm that another program is driving"),
        "move": ("drive.move:move", "go to a pose or to angles",
            "move an arm to a pose or to joint angles"),
        "resume": ("drive.control_requests:resume", "let a paused arm go on",
            "let a paused arm go on"),
        "points": ("drive", "save places, go to them",
            "save places by name, go to them, and run sequences of them"),
        "slow": ("drive.control_requests:slow", "slow a moving arm down",
            "slow down an arm that another program is driving"),
        "enable": ("drive.motors:enable", "switch the motors on",
            "switch the motors on, if the controller can"),
        "reset": ("drive.motors:reset", "clear an error",
            "clear an error once you have looked at the arm; moves nothing"),
        "disable": ("drive.motors:disable", "switch the motors off",
            "switch the motors off; the arm can sag, so it is parked first"),
        "verify": ("drive.home:verify", "measure the drift",
            "measure at the reference mark how far an arm has drifted"),
    },
    "Program": {
        "run": ("program.run:run", "run or check a program",
            "run a program file or a Python script, or only check it"),
        "teach": ("program", "record places by moving",
            "make a sequence of places by moving the arm, and edit it step by step"),
        "shell": ("program.shell:run", "type program words",
            "type the words of a program at a prompt; each runs at once"),
        "pendant": ("drive", "copy the arm's program",
            "copy the program in the arm's own memory to a file and back"),
        "demo": ("program.demo:run", "watch blocks being stacked",
            "watch the simulated arm pick up and stack blocks"),
    },
    "Set up": {
        "config": ("set_up", "write and check arm files",
            "write arm files by answering questions; list, show and check them"),
        "sim": ("set_up.sim:sim", "run a simulated arm",
            "run a simulated arm that any program can connect to"),
        "ports": ("set_up.ports:ports", "list the serial ports",
            "list the serial ports, which program has each open, and which arm file names it"),
        "can": ("set_up", "set up CAN drives",
            "set up drives on a CAN bus, and show its traffic"),
        "doctor": ("set_up.doctor:doctor", "find what is connected",
            "find out what is connected to a port and what is wrong with it; moves nothing"),
        "completion": ("set_up.completion:completion", "complete words on Tab",
            "print a script that makes your shell complete armdrive's words on Tab"),
    },
    "Look": {
        "status": ("look.status:status", "show where the arm is",
            "show where an arm is, whether that can be trusted, and what to do next"),
        "record": ("drive.control_requests:record", "save what just happened",
            "save a recording of an arm that another program is driving"),
        "watch": ("look.status:watch", "follow a moving arm",
            "follow an arm that another program is driving"),
        "log": ("look.log:log", "read a recording",
            "read a recording in words: bytes, requests, intents, states, errors"),
        "replay": ("look.replay:replay_recording", "compare it with simulation",
            "replay a recording on a simulated arm, and show where the two differ"),
    },
    "Learn": {
        "errors": ("learn.errors:errors", "look up an error code",
            "look up an error by its code: its cause, its effect on the arm and what to do"),
        "fk": ("learn.poses:fk", "pose of joint angles",
            "compute the pose of the finger tips from joint angles"),
        "explain": ("learn.explain:explain", "work an arm out in steps",
            "work an arm out step by step: link table, A matrices, forward and inverse"),
        "ik": ("learn.poses:ik", "joint angles of a pose",
            "compute the joint angles that bring the finger tips to a pose"),
        "plot": ("learn.plot:plot", "draw what an arm can reach",
            "draw what an arm can reach"),
    },
})  # fmt: skip
"""Every command by group: its function, written `drive.move:move`, its few words in
`armdrive --help`, and the sentence that begins its own help.

A command with actions, as `points`, has a function for each of them, in the table of its group.
The arguments of a group are light to load: `--help` of a command needs no more. The module of a
function may load all that drives an arm.
"""

ROWS = MappingProxyType({name: row for rows in GROUPS.values() for name, row in rows.items()})
"""The same by the name of the command alone."""

COMMANDS: Mapping[str, str] = MappingProxyType(
    {name: summary for name, (_, _, summary) in ROWS.items()}
)
"""Every command with the sentence that begins its help."""

INSTEAD: Mapping[str, str] = MappingProxyType(
    {
        "close": "armdrive move --gripper 0",
        "desk": "armdrive jog",
        "estop": "armdrive stop",
        "go": "armdrive points go NAME",
        "goto": "armdrive points go NAME",
        "gripper": "armdrive move --gripper MM",
        "halt": "armdrive stop",
        "open": "armdrive move --gripper MM",
        "origin": "armdrive home",
        "park": "armdrive move --park",
        "play": "armdrive run PROGRAM",
        "ready": "armdrive move --park",
        "reference": "armdrive home",
        "setup": "armdrive config new",
        "simulate": "armdrive sim DIALECT",
        "teach record": "armdrive teach follow SEQUENCE",
        "zero": "armdrive home",
    }
)
"""Words that people try, and what to type instead: each thing has one name here."""

EXIT_CODES_TOPIC = "exit-codes"
"""`armdrive help exit-codes` prints the table below."""

USAGE, REFUSED, FAULT, INTERRUPTED = 2, 3, 70, 130
"""Exit codes of what is no `ArmError`, which has its own; 70 is EX_SOFTWARE of sysexits.h."""

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
"""What the command line ends with."""
