"""Serial chains of links: frame assignment, forward and inverse kinematics, Jacobians, URDF."""
