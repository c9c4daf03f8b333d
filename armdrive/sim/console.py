"""The one-line commands that steer a simulated arm from its standard input.

Each line gets one line in answer; `--json` anywhere in it makes that answer JSON.
"""

from __future__ import annotations

import json

from armdrive.errors import ArmError, BadRequest
from armdrive.sim.console_command import Answer
from armdrive.sim.console_table import COMMANDS
from armdrive.sim.device import SimDevice
from armdrive.sim.faults import Faults
from armdrive.sim.pacing import PacedDevice
from armdrive.transports.serve import Server
from kinematics.errors import did_you_mean

JSON_FLAG = "--json"


class ServerCable:
    """The cable between a served device and whoever opens it."""

    def __init__(self, server: Server, line: PacedDevice) -> None:
        self._server = server
        self._line = line

    def unplug(self) -> None:
        """Withdraw the wire; what is under way is lost."""
        self._server.close()
        self._line.unplug()

    def replug(self, name: str | None = None) -> None:
        """Offer the wire again, under another name perhaps. Raises `PortUnavailable`."""
        self._server.open(name)
        self._line.plug()


class Console:
    """Steers one device, its line, and the server that offers it. `ended` is true after `quit`."""

    def __init__(self, device: SimDevice, server: Server, line: PacedDevice) -> None:
        self.device = device
        self.server = server
        self.cable = ServerCable(server, line)
        self.faults = Faults(device, line, self.cable)
        self.ended = False

    def answer(self, line: str) -> str:
        """Do what a line says and return the line that answers it; nothing for an empty one."""
        words = line.split()
        as_json = JSON_FLAG in words
        words = [word for word in words if word != JSON_FLAG]
        if not words:
            return ""
        try:
            answer = self._run(words[0], words[1:])
        except ArmError as error:
            return json.dumps({"ok": False, "error": str(error)}) if as_json else str(error)
        if not as_json:
            return answer.text
        return json.dumps({"ok": True, "text": answer.text} if answer.data is None else answer.data)

    def _run(self, name: str, words: list[str]) -> Answer:
        command = COMMANDS.get(name.lower())
        if command is None:
            hint = did_you_mean(name.lower(), COMMANDS, "try 'help'.", likeness=0.4)
            raise BadRequest(f"there is no command {name!r}; {hint}")
        least, most = command.counts
        if not least <= len(words) <= most:
            raise BadRequest(f"write it like this: {command.usage}")
        return command.run(self, words)


def help_text() -> str:
    """Return the table for people, one command a line."""
    width = max(len(command.usage) for command in COMMANDS.values())
    return "\n".join(
        f"{command.usage:<{width}}  {command.summary}" for command in COMMANDS.values()
    )
