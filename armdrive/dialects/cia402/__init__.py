"""Driving CiA 402 drives on a CANopen bus.

Read in this order, after `dialects.bus`:

    controller   requests of an arm: which collaborator carries out each
    wire         frames out, events in, and what is known of each drive
    exchange     turns by SYNC, looks, ways between states, objects by SDO
    contact      finding the drives, setting them up, switching them on and off, clearing faults
    leading      what all motions share: beginning, returning, arriving, stopping
    motion       cyclic targets, bursts by profile, homing

The rest is for people: `settings` for the arm file, `survey` for a bus, `words` and `objects` for
what passes on it, `entry` for the registry.
"""
