"""The objects of a simulated CiA 402 drive: its EDS, and places of those beside STANDARD."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib.resources import files

from firmware_protocol.canopen import Dictionary, Place, read_eds

EDS = "cia402.eds"
COMMUNICATION = range(0x1000, 0x2000)
"""Indices of what a reset of the communication brings back."""
PDO_PARAMETERS = range(0x1400, 0x1C00)

DEVICE_NAME = Place(0x1008)
ERROR_COUNT, LAST_ERROR = Place(0x1003, 0), Place(0x1003, 1)
SERIAL_NUMBER = Place(0x1018, 4)
POSITION_DEMAND = Place(0x6062)
POSITION_WINDOW = Place(0x6067)
VELOCITY = Place(0x606C)
HOME_OFFSET = Place(0x607C)
LEAST_POSITION, MOST_POSITION = Place(0x607D, 1), Place(0x607D, 2)
MOST_MOTOR_SPEED = Place(0x6080)
ENCODER_INCREMENTS = Place(0x608F, 1)
HOMING_METHOD = Place(0x6098)
HOMING_SPEED, HOMING_CREEP = Place(0x6099, 1), Place(0x6099, 2)
HOMING_ACCELERATION = Place(0x609A)
PERIOD, PERIOD_POWER = Place(0x60C2, 1), Place(0x60C2, 2)
DIGITAL_INPUTS = Place(0x60FD)


@cache
def eds_text() -> str:
    """Return the EDS file of the drives, for whoever wants to know them."""
    return (files("armdrive.sim") / EDS).read_text(encoding="ascii")


@cache
def dictionary() -> Dictionary:
    """Return all that a drive has."""
    return read_eds(eds_text())


def without(missing: frozenset[int], changed: Mapping[Place, int]) -> Dictionary:
    """Return the objects of a drive that lacks some, others not being as the EDS says."""
    whole = dictionary()
    entries = [
        replace(entry, default=changed.get(entry.place, entry.default))
        for entry in whole
        if entry.place.index not in missing
    ]
    return Dictionary(entries, whole.records)
