"""Sans-IO codecs for the arm controllers' dialects: messages to bytes and back, for both ends.

A driver gives a message to `Host.send`, which returns its bytes, and what the device says to
`receive_data`; `next_event` then returns one message after the other, until it returns None. No
input raises. Messages are checked when they are built.

Each subpackage has the messages, with functions that encode and decode them, and the host's end.
There is also a device's end if the firmware's reader is a machine of its own, as those of
the Armdroid and of GRBL are; else a simulated device decodes messages itself. They share

    errors   which side made a mistake
    events   input that is unreadable or answers nothing
    fields   the rules of a message's fields
    lines    splitting bytes into lines, and which line may answer a command
    frames   CAN frames as bytes
"""
