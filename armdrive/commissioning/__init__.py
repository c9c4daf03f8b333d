"""Commissioning drives on a CAN bus: a talk with a person and with them, without I/O."""
