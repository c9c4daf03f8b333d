"""Recorded runs for tests: a simulated arm with a recorder, and its recordings."""

from pathlib import Path

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.trace.entries import EntryKind, EntryRing, TraceEntry
from armdrive.trace.files import Recording, read_recording
from armdrive.trace.recorder import FlightRecorder


def recorded_arm(
    dialect="teachmover", folder: Path | None = None, ring: EntryRing | None = None, **how
):
    """Connect to a simulated arm with a recorder."""
    tracer = FlightRecorder(folder, ring=ring)
    arm = Arm(connect_simulated(simulated_config(dialect), tracer=tracer, **how))
    arm.__enter__()
    return arm


def saved(arm, tmp_path) -> Recording:
    return read_recording(arm.recorder.save(tmp_path / "saved.jsonl"))


def written(folder: Path) -> list[Path]:
    return sorted(folder.glob("*"))


def of_kind(entries: tuple[TraceEntry, ...], kind: EntryKind) -> list[bytes | str]:
    return [entry.what for entry in entries if entry.kind is kind]
