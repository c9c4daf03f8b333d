"""What the keys do: their table, the keyboard at hand, and files that change it.

What is decided where:

    table        every key and every screen: bindings, footer, help and docs are made from it
    keyboard     how the keys of this keyboard are printed
    presses      overtaken, stale, repeated and accidental presses, and what two presses confirm
    remap        other keys from a file
"""
