"""Jogging by keys, mouse and gamepad: the hand on the keys, and the screen."""
