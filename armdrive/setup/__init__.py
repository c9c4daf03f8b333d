"""Sets an arm up: finds its port, asks about it, writes its file, tries its motors.

Finding it:

    ports          a port while it is closed: whose it is, who holds it
    prober         what answers on an open port: how long it listens before the probes and
                   between them (which probes, in which order: `dialects.recognition`)
    survey         the survey of a serial port, and every finding in words; the settings of a
                   known controller
    bus_survey     the survey of a CAN bus

Describing it:

    templates      what an interview begins with
    questions      every question once: words, check, default, place in the arm file
    interview      which question is next, and a step back; `draft` holds the answers
    filing         the new file, or the difference in a present one, before it is written

Trying it:

    commissioning  the drives on a bus, one after the other
    directions     how far each motor is turned, and what the answers say about it
    arm_checks     the same with a connected arm, and its limit switches
    keyboard       how keys repeat in this terminal, and whether that is enough to jog

`dialog_runner` carries questions and scripts out, `simulated_person` answers for a simulated arm.
"""
