"""The keys: their table, the user's keyboard, and its layouts.

Which file decides what:

    table        every key and every screen: bindings, footer, help and docs are made from it
    keyboard     how the keys of this keyboard are printed
    presses      overtaken, stale, repeated and accidental presses, and what two presses confirm
    layouts      where the jog keys are on other keyboards
"""
