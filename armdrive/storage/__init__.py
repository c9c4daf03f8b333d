"""Files that armdrive keeps: saved positions, points, locks, and verification logs.

Which file decides what:

    files        how a file is replaced atomically, who may overwrite one, and the folders of all
                 files (`ARMDRIVE_HOME`)
    record       the saved position: its text, when it would be restored, the thread that writes
    points       points as values, and their bounds
    point_file   the file of points, read again for each query and changed in place
    arm_lock     one program at a time holds an arm; the socket that it answers on
    lock_client  the lock, which the system releases if its program dies; asking that program
"""
