"""Commands that set an arm up: arm files, ports, simulated devices.

What is decided where:

    config, config_new   arm files: listed, checked, made, completed
    ports, doctor        what is known of a port; what opening it leads to, and who agrees
    can                  the traffic of a bus in words; setting its drives up
    sim                  a simulated arm as a program of its own
    completion           the shell's completion
    arguments            the options of all of them, and the text of their help
"""
