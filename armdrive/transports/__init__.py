"""The links to controllers: serial ports, network addresses, CAN buses, and in-process devices."""
