"""Driving MKS SERVO42D/57D drives on a CAN bus.

Read in this order, after `dialects.bus`:

    controller   requests of an arm: which collaborator carries out each
    wire         what is said to the drives and what they answer; every answer feeds the observer
    contact      finding the drives, switching them on and off, clearing stalls
    motion       the stages of a motion, from the first order until all stand
    steering     the orders along a way, given again and again in flight
    bursts       motion by firmware that cannot be steered
    stops        stopping, and leaving no drive pushing against anything
    homing       the drives' own search for their switches
    inquiry      what a drive is asked about itself: firmware, shared ids, why it does not move

The rest is for people: `settings` and `compare` for the arm file, `survey` and `commissioning` for
a bus and its drives, `words` for what passes on it, `entry` for the registry.
"""
