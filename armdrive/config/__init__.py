"""The arm file: one schema that reads, checks, suggests, writes and documents it.

Which file decides what:

    sections     every key: type, bounds, default, help; also the order of homing, and parking
    preset       a built-in arm with the file's corrections
    link_model   a serial arm by its links, joint axes or URDF
    arm          the whole file, and problems that involve several sections
    write        a whole file with every default
"""
