"""The calls of an `Arm`, one file a family; arm.py puts them together."""
