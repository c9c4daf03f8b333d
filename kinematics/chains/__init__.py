"""Serial chains of links: frame assignment, forward and inverse kinematics, Jacobians, URDF.

Which file decides what:

    links, chain   link parameters in both conventions; the chain, its limits, forward kinematics
    assignment     from joint axes to link parameters
    urdf           from and to a URDF text
    arm            a chain as an arm that can be driven: which posture is chosen, how near
    structure      which closed form a chain has; `branches` writes it from `subproblems`, and
                   `closed_form` checks what it finds
    inverse        the numerical solution: how often it starts, and the remaining error
    descent        one descent: its damping, and when it gives up
    goals          which parts of a hand's frame matter
    jacobians      rates and singularities
    many           a million postures at once
    generated, code_lines   straight-line Python for one chain
"""
