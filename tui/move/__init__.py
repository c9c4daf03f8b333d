"""Planned motion: a person types a goal, sees the motion, and confirms it twice."""
