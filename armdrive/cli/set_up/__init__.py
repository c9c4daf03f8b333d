"""Commands that set an arm up: arm files, ports, simulated devices.

Which file decides what:

    config          arm files: list, show, check; the default arm
    config_new      a new arm file, from an interview
    arm_trials      the directions of an arm's motors, and its limit switches
    ports, doctor   what is known about a port, the consent to open it, and what is behind it
    can_monitor     the traffic of a bus in words
    can_setup       commissioning drives
    sim             a simulated arm in a separate process
    completion      the shell's completion
    arguments       the options of all of them, and the text of their help
"""
