"""Serial chains of links: frame assignment, forward and inverse kinematics, Jacobians, URDF.

Which file decides what:

    links, chain   link parameters in both conventions; the chain, its limits, forward kinematics
    assignment     from joint axes to link parameters
    urdf           from and to a URDF text
    evaluation     forward kinematics and Jacobian on floats
    arm            a chain as an arm that can be driven: which posture is chosen, how near
    branches       which closed form a chain has, and its postures; `closed_form` checks them
    inverse        the numerical solution: how often it starts, and the remaining error
    descent        one descent: its damping, and when it gives up
    goals          which parts of a hand's frame matter
    jacobians      rates and singularities
    many           many postures at once, for maps of the reach

How an inverse is found, from `ChainArm.ik(pose, seed)` on:

    goals        the pose becomes a goal: a frame for the hand, and the parts of it that count
    closed_form  the class of this link table gives all postures; each joint is put on the turn,
                 within its limits, that is nearest to the seed; the nearest posture that forward
                 kinematics confirms is the answer
    inverse      without an answer so far, descents begin at the seed and at other postures; the
                 first end that meets the goal within the limits is the answer
    arm          else the account of the best end becomes `Unreachable`, with the nearest pose
"""
