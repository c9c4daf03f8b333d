"""Text and files that are made to do harm, and checks of what is printed."""

import os
import socket

HOSTILE_TEXT = {
    "escape": "\x1b[31mred",
    "window title": "\x1b]0;owned\x07",
    "clear screen": "\x1b[2J\x1b[H",
    "C1 sequence": "\x9b31m",
    "backspaces": "abc\x08\x08\x08",
    "carriage return": "fine\rarmdrive: done",
    "line break": "x\narmdrive: done",
    "delete": "\x7f",
    "bidi override": "\u202e0001\u202c",
    "bidi isolate": "\u2066x\u2069",
    "zero width": "a\u200bb\ufeff",
    "line separator": "a\u2028b\x85c",
    "lone surrogate": "\udcff",
    "markup": "[red]x[/red][@click=app.quit]y[/]",
    "private use": "\ue000\U0010ffff",
}
"""Text for a name, a title, a banner or a file. The markup is printable, and must stay."""


def unprintable(output: str) -> set[str]:
    """Return the characters of an output that a terminal would act on, or not show."""
    return {each for each in output if not each.isprintable() and each != "\n"}


def toml_text(text: str) -> str:
    """Return text as a string of TOML, which has an escape for every character but surrogates."""
    return '"' + "".join(f"\\U{ord(each):08x}" for each in text) + '"'


def special_files(folder):
    """Make special files and paths that are no regular file; return them by what they are."""
    (folder / "folder").mkdir()
    os.mkfifo(folder / "fifo")
    with socket.socket(socket.AF_UNIX) as made:
        here = os.open(".", os.O_RDONLY)  # a socket's path has at most 107 bytes
        try:
            os.chdir(folder)
            made.bind("socket")
        finally:
            os.fchdir(here)
            os.close(here)
    (folder / "loop").symlink_to("loop")
    with (folder / "sparse").open("wb") as file:
        file.truncate(200_000_000)
    return {
        "an endless device": "/dev/zero",
        "a terminal": "/dev/tty",
        "a pipe": folder / "fifo",
        "a folder": folder / "folder",
        "a socket": folder / "socket",
        "a link to itself": folder / "loop",
        "a file of 200 MB": folder / "sparse",
        "no file": folder / "none",
        "below a file": folder / "sparse" / "x",
        "a name that is too long": folder / ("x" * 3000),
    }


DEEP = 20_000
CONTENTS = {
    "nothing": b"",
    "zeros": bytes(100),
    "no UTF-8": b"\xff\xfe\x00",
    "UTF-16": 'model = "teachmover"'.encode("utf-16"),
    "lists": b"x = " + b"[" * DEEP,
    "closed lists": b"x = " + b"[" * DEEP + b"]" * DEEP,
    "tables": b"x = " + b"{a=" * DEEP,
    "JSON lists": b"[" * DEEP,
    "JSON objects": b'{"a":' * DEEP,
    "brackets": b"x = " + b"(" * DEEP + b"1" + b")" * DEEP,
    "signs": b"x = " + b"-" * DEEP + b"1",
    "a long sum": b"x = " + b"1+" * DEEP + b"1",
    "many parts": ".".join(["a"] * 20_000).encode() + b" = 1",
    "a deep header": b"[" + ".".join(["a"] * 20_000).encode() + b"]",
    "spread nesting": b"\n".join(b"[" + b".".join([b"a"] * n) + b"]" for n in range(1, 60)),
    "digits": b"x = " + b"9" * 6000,
    "fraction digits": b"x = 0." + b"9" * 6000,
    "a number beyond 64 bits": b"x = 9223372036854775808",
    "a hexadecimal number": b"x = 0x" + b"f" * 300,
    "blocks": b"repeat 2\n" * 2000 + b"end\n" * 2000,
    "an endless name": b"a" * 250_000,
    "lines": b"\n" * 250_000,
    "keys": b"".join(b"k%d = 1\n" % n for n in range(2_000)),
    "links": b"[[links]]\na_mm=1\n" * 1_000,
    "an odd model": b'model = "\\u0000"',
    "quotes": b"'" * 100_000,
}
"""Contents of files that no command can use."""
