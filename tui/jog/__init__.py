"""Jogging by keys and mouse: the hand on the keys, and the screen.

What is decided where:

    jogging   when keys are armed, when a mouse's hold ends; `motion.dead_man` judges the keys
    panels    what is near a limit, a guard or the table
    screen    the screen
"""
