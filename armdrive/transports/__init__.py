"""The links to controllers: serial ports, network addresses and CAN buses.

Which file decides what:

    link         the interface, the bell that wakes one, and an absent one
    opening      which link an address opens; `address` reads it
    ports        the ports and adapters of this computer, who holds one, and why one is refused
    serial_port  handshake lines, exclusive use, and boards that reset when opened
    udp          one datagram for each write
    can_link     a CAN bus, and when it is lost; `can_health` puts its errors into words,
                 `can_slcan` is an adapter on a serial port
"""
