"""The log: what passes between the arm and this program, in words."""
