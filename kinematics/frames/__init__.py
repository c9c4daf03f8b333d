"""Vectors, rotations, orientations and transforms.

Which file decides what:

    vectors, numbers             arithmetic on plain tuples, floats and other kinds of number
    rotations, orientations      rotation matrices, and every other way to state a rotation
    transforms                   frames in frames
    user_frame                   a frame measured by three points on the bench
"""
