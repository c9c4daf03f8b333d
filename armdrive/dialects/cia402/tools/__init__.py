"""Tools for CANopen buses that no motion needs: surveying nodes, and describing their traffic.

survey    ask the nodes of a bus what they are; findings for `armdrive doctor --can`
words     one frame in words, for `armdrive can monitor` and recordings
objects   the objects of a node and their values, in words
"""
