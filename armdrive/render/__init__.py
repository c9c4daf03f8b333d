"""Pictures of arms in terminal characters and as PNG or SVG files.

Which file decides what:

    figure       an arm or a chain as lines; `frame_steps` its frames as they are assigned
    scene        the layers of one picture: what stays, and what moves over it
    camera       the point of view
    canvas       lines as characters
    sketch       plane curves to scale, in characters or a file
"""
