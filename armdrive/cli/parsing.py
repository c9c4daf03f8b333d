"""The parser of a command's options: its complaints quote what was typed, so they are escaped."""

from __future__ import annotations

import argparse
from typing import NoReturn

from armdrive.text.printable import as_message


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors print nothing that a terminal would act on."""

    def exit(self, status: int = 0, message: str | None = None) -> NoReturn:
        """End the program as `ArgumentParser` does, with a printable message."""
        super().exit(status, None if message is None else as_message(message))
