"""Compile the processor simulator, and run it as a process."""

import contextlib
import os
import shlex
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

SOURCE = Path(__file__).with_name("avrdev.c")
AVR_MACHINE = (83).to_bytes(2, "little")
"""What the header of an ELF file has for AVR."""
COMPILES_S = 120.0
ENDS_S = 10.0


class NoSimulator(Exception):
    """Something that the processor simulator needs is missing; the message says what to do."""


def check_image(image: Path) -> None:
    """Raise `NoSimulator` unless a file looks like an image for an AVR processor."""
    try:
        with image.open("rb") as file:
            head = file.read(20)
    except OSError as error:
        raise NoSimulator(f"{image} cannot be read: {error.strerror}") from None
    if head[:4] != b"\x7fELF" or head[18:] != AVR_MACHINE:
        raise NoSimulator(f"{image} is no ELF file for AVR: name that one, not a .hex file")


def compile_avrdev(target: Path, simavr: Path | None = None) -> Path:
    """Compile the simulator against the simavr that pkg-config finds, or the one in a folder."""
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        raise NoSimulator("there is no C compiler: install one, or name it in CC")
    flags = _flags_of_folder(simavr) if simavr is not None else _flags_of_package()
    command = [compiler, "-O2", "-o", str(target), str(SOURCE), *flags, "-lelf", "-lutil", "-lm"]
    made = subprocess.run(command, capture_output=True, text=True, timeout=COMPILES_S, check=False)
    if made.returncode:
        raise NoSimulator(f"{shlex.join(command)} failed:\n{made.stderr}")
    return target


def _flags_of_package() -> list[str]:
    found = (
        subprocess.run(
            ["pkg-config", "--cflags", "--libs", "simavr"],
            capture_output=True,
            text=True,
            check=False,
        )
        if shutil.which("pkg-config")
        else None
    )
    if found is None or found.returncode:
        raise NoSimulator(
            "pkg-config finds no simavr: install libsimavr-dev and libelf-dev, point "
            "PKG_CONFIG_PATH at another one, or name its folder with --simavr"
        )
    return shlex.split(found.stdout)


def _flags_of_folder(folder: Path) -> list[str]:
    """Return the flags for a simavr checkout that is built but not installed."""
    header = next(iter(sorted(folder.rglob("sim_avr.h"))), None)
    library = next(
        (each for name in ("libsimavr.a", "libsimavr.so") for each in sorted(folder.rglob(name))),
        None,
    )
    if header is None or library is None:
        raise NoSimulator(f"there is no sim_avr.h with a libsimavr.a or libsimavr.so in {folder}")
    return [
        f"-I{header.parent}",
        str(library),
        f"-Wl,-rpath,{library.parent.resolve()}",
        "-lpthread",
    ]


class AvrProcess:
    """A running image. `port` is its serial port, `control_port` its UDP port."""

    def __init__(self, program: Path, image: Path, tty: Path, options: Sequence[str]) -> None:
        log = tty.with_suffix(".log")
        with log.open("w", encoding="utf-8") as told:
            self._process = subprocess.Popen(
                [str(program), str(image), "--tty", str(tty), "--until-eof", *options],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=told,
                text=True,
            )
        assert self._process.stdout is not None
        # some versions of simavr print to standard output
        told = (line for line in self._process.stdout if line.startswith("ready "))
        ready = next(told, "").split()
        if not ready:
            self.end()
            raise NoSimulator(f"{image} does not run: {log.read_text(encoding='utf-8').strip()}")
        _, self.port, port = ready
        self.control_port = int(port)

    def end(self) -> None:
        """End the process by closing its input."""
        with contextlib.suppress(BrokenPipeError):
            try:
                self._process.communicate(timeout=ENDS_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.communicate()
