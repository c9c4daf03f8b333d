"""The mathematics of the arm: poses, joint angles, motor steps, and the way between them."""
