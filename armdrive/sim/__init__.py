"""Simulated devices.

    device          what all of them share: board, options, report
    wire            the line to it: pace, faults, and the link of a driver in this process
    simulated_arm   one arm in a process: world, device, wire, and an operator who answers
    world/          the physical arm and its table: blocks, gripping, incidents
    mechanics/      motors in motion: profiles, queues, shafts, switches
    faults          what can be made to fail, and when: one table
    serving/        a simulated arm as a program of its own
    bus/            several drives on one CAN bus

Every other module or subpackage is one dialect, and has its name. A quirk of a device cites where
it was seen, or says that it is a guess.
"""
