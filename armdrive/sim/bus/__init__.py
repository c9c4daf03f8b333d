"""What simulated drives on a CAN bus have in common.

`node` is one drive's motor, switch, supply and quirks; `board` all drives with their time and
power; `line` the bus itself.
"""
