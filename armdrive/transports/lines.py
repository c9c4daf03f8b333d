"""The handshake line DTR when a port is closed: whether it falls, and so resets a board.

Boards with an Arduino's reset circuit restart when DTR rises. Linux and macOS raise DTR whenever a
port is opened, and let it fall at its last close where HUPCL is set. Without HUPCL it stays up
between programs, so that the next open brings no edge. The first open after plugging in has reset
the board already: no setting prevents that one.
"""

from __future__ import annotations

import sys


def clear_hupcl(fileno: int) -> bool:
    """Clear HUPCL of an open port, so that DTR stays up when it is closed.

    Returns whether it is cleared: False on Windows and for what is no terminal. The setting stays
    with the device until it is unplugged or another program sets it.
    """
    if sys.platform == "win32":
        return False
    import termios

    try:
        settings = termios.tcgetattr(fileno)
        settings[2] &= ~termios.HUPCL
        termios.tcsetattr(fileno, termios.TCSANOW, settings)
        return not termios.tcgetattr(fileno)[2] & termios.HUPCL
    except termios.error:
        return False
