"""Sans-IO codecs for the arm controllers' dialects: messages to bytes and back, for both ends.

Each subpackage has its messages, checked when built, and a host's and a device's end. They share

    errors   which side made a mistake
    events   what was unreadable, and a bounded queue
    fields   the rules of a message's fields
    lines    bytes split into lines, and how much of a bad one is kept
    frames   CAN frames as bytes
"""
