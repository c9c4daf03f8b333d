"""Sans-IO codecs for the arm controllers' dialects: messages to bytes and back, for both ends.

Each subpackage has messages, which are checked when they are built, and two ends: the host's and
the device's. They share

    errors   which side made a mistake
    events   unreadable input, and a bounded queue
    fields   the rules of a message's fields
    lines    splitting bytes into lines, and how much of a bad line is kept
    frames   CAN frames as bytes
"""
