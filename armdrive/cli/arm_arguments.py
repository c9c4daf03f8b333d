"""What may be typed after the commands that drive an arm, by hand or by a program."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from armdrive.cli.drive.arguments import ARGUMENTS as DRIVING
from armdrive.cli.options import Arguments
from armdrive.cli.program.arguments import ARGUMENTS as PROGRAMS

ARGUMENTS: Mapping[str, Arguments] = MappingProxyType({**DRIVING, **PROGRAMS})
