"""Commands that set an arm up: arm files, ports, simulated devices.

Which file decides what:

    config, config_new   arm files: list, check, create, complete
    ports, doctor        what is known about a port, the consent to open it, and what is behind it
    can                  the traffic of a bus in words; commissioning drives
    sim                  a simulated arm in a separate process
    completion           the shell's completion
    arguments            the options of all of them, and the text of their help
"""
