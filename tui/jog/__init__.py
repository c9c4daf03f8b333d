"""Jogging by keys and mouse, and the jog screen.

Which file decides what:

    jogging   when keys are armed, when a mouse's hold ends; `motion.dead_man` judges the keys
    panels    what is near a limit, a guard or the table
    screen    the screen
"""
