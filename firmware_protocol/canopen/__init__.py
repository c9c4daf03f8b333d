"""CANopen (CiA 301) and its profile for drives (CiA 402): the master's end and a drive's end."""
