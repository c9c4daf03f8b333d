"""Signs, turns and conventions of the kinematics."""

from __future__ import annotations

from .mutant import Mutant, tests_of

MUTANTS = (
    Mutant(
        name="the elbow bends the wrong way",
        promise="both postures hold the hand at its pose",
        path="kinematics/five_axis/closed_form.py",
        old="    return (direction + lift, -bend), (direction - lift, bend)",
        new="    return (direction + lift, bend), (direction - lift, -bend)",
        tests=tests_of(
            "tests/kinematics/five_axis/test_five_axis.py",
            "test_every_branch_holds_the_pose_even_beyond_the_limits",
        ),
    ),
    Mutant(
        name="the arctangent has its arguments the wrong way round",
        promise="a posture holds the hand at its pose",
        path="kinematics/five_axis/closed_form.py",
        old="        facing = math.atan2(y, x)\n    base",
        new="        facing = math.atan2(x, y)\n    base",
        tests=tests_of(
            "tests/kinematics/five_axis/test_five_axis.py",
            "test_every_branch_holds_the_pose_even_beyond_the_limits",
        ),
    ),
    Mutant(
        name="the back posture does not turn the roll over",
        promise="front and back postures hold the hand in the same pose",
        path="kinematics/five_axis/closed_form.py",
        old="-elbow, -wrist, roll + math.pi)",
        new="-elbow, -wrist, roll)",
        tests=tests_of(
            "tests/kinematics/five_axis/test_five_axis.py",
            "test_what_cannot_be_reached_names_something_that_can",
        ),
    ),
    Mutant(
        name="the pitch leaves the wrist out",
        promise="the hand's pitch is the sum of the angles",
        path="kinematics/five_axis/closed_form.py",
        old="    pitch = forearm + wrist\n    r = ",
        new="    pitch = forearm - wrist\n    r = ",
        tests=tests_of(
            "tests/kinematics/paths/test_paths.py",
            "test_a_line_keeps_the_elbow_that_it_starts_with",
        ),
    ),
    Mutant(
        name="the nearest posture is the farthest",
        promise="the nearest of several postures is chosen",
        path="kinematics/five_axis/closed_form.py",
        old="            if change < least:",
        new="            if best is None or change > least:",
        tests=tests_of(
            "tests/kinematics/five_axis/test_five_axis.py",
            "test_no_branch_within_limits_is_nearer_to_the_seed",
        ),
    ),
    Mutant(
        name="an A matrix twists the wrong way",
        promise="the A matrices are those of the textbook",
        path="kinematics/chains/links.py",
        old="            (0.0, sa, ca, d_mm),",
        new="            (0.0, -sa, ca, d_mm),",
        tests=tests_of(
            "tests/kinematics/chains/test_links.py",
            "test_the_a_matrix_is_the_product_of_its_four_moves",
        ),
    ),
    Mutant(
        name="Craig's convention has its offset with the wrong sign",
        promise="the A matrices are those of the textbook",
        path="kinematics/chains/links.py",
        old="(st * ca, ct * ca, -sa, -sa * d_mm)",
        new="(st * ca, ct * ca, -sa, sa * d_mm)",
        tests=tests_of(
            "tests/kinematics/chains/test_links.py",
            "test_the_a_matrix_is_the_product_of_its_four_moves",
        ),
    ),
    Mutant(
        name="a link table's posture is used without comparing it with the goal",
        promise="every closed-form solution reaches the goal",
        path="kinematics/chains/closed_form.py",
        old="        if _near(frame, target, NEAR_MM, NEAR_RAD):",
        new="        if frame:",
        tests=tests_of(
            "tests/kinematics/chains/test_closed_form.py",
            "test_every_posture_meets_its_goal_and_the_posture_that_made_it_is_among_them",
        ),
    ),
    Mutant(
        name="a link table's joint may stand beyond its limit",
        promise="the chosen closed-form solution keeps all limits",
        path="kinematics/chains/closed_form.py",
        old="                kept = all_fitted(angles, limits, near)",
        new="                kept = all_fitted(angles, limits, near) or angles",
        tests=tests_of(
            "tests/kinematics/chains/test_closed_form.py",
            "test_the_nearest_posture_is_within_the_limits_and_the_nearest",
        ),
    ),
    Mutant(
        name="the triangle of upper arm and forearm leaves out the upper arm",
        promise="an arm is solved by its own class",
        path="kinematics/chains/branches.py",
        old="(square,), (-code.dot(u, u),), ",
        new="(square,), ",
        tests=tests_of(
            "tests/kinematics/chains/test_closed_form.py",
            "test_the_class_of_an_arm_in_words",
        ),
    ),
    Mutant(
        name="a link table's second solution of an angle is left out",
        promise="a closed form finds every branch",
        path="kinematics/chains/subproblems.py",
        old="        return a, b, c, 1.0 / square, (root, -root)",
        new="        return a, b, c, 1.0 / square, (root, root)",
        tests=tests_of(
            "tests/kinematics/chains/test_closed_form.py",
            "test_every_posture_meets_its_goal_and_the_posture_that_made_it_is_among_them",
        ),
    ),
    Mutant(
        name="a rotation is made of an angle that is no number",
        promise="no matrix is made of what is no finite number",
        path="kinematics/frames/rotations.py",
        old='    angle = number("angle_rad", angle_rad)',
        new="    angle = angle_rad",
        tests=tests_of(
            "tests/kinematics/test_refused_arguments.py",
            "test_no_matrix_is_made_of_what_is_no_finite_number",
        ),
    ),
    Mutant(
        name="a small step is solved beyond a limit",
        promise="a small step is met within the limits or not at all",
        path="kinematics/chains/arm.py",
        old="    return bounded if excess <= LIMIT_TOLERANCE_RAD else None  # more than rounding",
        new="    return bounded",
        tests=tests_of(
            "tests/kinematics/chains/test_chain_arm.py",
            "test_beyond_the_reach_or_a_limit_there_is_nothing",
        ),
    ),
    Mutant(
        name="half a turn is minus half a turn",
        promise="angles are wrapped into (-pi, pi]",
        path="kinematics/limits.py",
        old="    return turned if turned > -math.pi else math.pi",
        new="    return turned",
        tests=tests_of(
            "tests/kinematics/test_refused_arguments.py",
            "test_an_angle_of_any_turns_is_wrapped_to_the_last_digit",
        ),
    ),
    Mutant(
        name="an angle is turned by half circles",
        promise="an angle is wrapped by whole turns",
        path="kinematics/limits.py",
        old=("    near = angle + round((seed - angle) / math.tau) * math.tau\n    floor"),
        new=("    near = angle + round((seed - angle) / math.pi) * math.pi\n    floor"),
        tests=tests_of(
            "tests/kinematics/test_limits.py",
            "test_a_turn_is_the_best_of_all_turns",
        ),
    ),
    Mutant(
        name="a limit's lower end is not kept",
        promise="an angle is wrapped into its range",
        path="kinematics/limits.py",
        old="    return turned if low <= turned <= high else math.inf",
        new="    return turned if turned <= high else math.inf",
        tests=tests_of(
            "tests/kinematics/test_limits.py",
            "test_an_angle_without_a_turn_in_the_range_fits_nowhere",
        ),
    ),
    Mutant(
        name="the gripper's cable runs the other way over the elbow",
        promise="the fingers stand still while the elbow moves",
        path="kinematics/transmission.py",
        old="        return sum(ratio * steps[earlier] for earlier, ratio in self.follows)",
        new="        return sum(-ratio * steps[earlier] for earlier, ratio in self.follows)",
        tests=tests_of(
            "tests/kinematics/test_transmission.py",
            "test_the_teachmovers_reference_posture_has_the_published_steps",
        ),
    ),
    Mutant(
        name="motors are read without what they follow",
        promise="steps and angles agree both ways",
        path="kinematics/transmission.py",
        old="            steps - motor.followed(motors) - motor.offset_steps\n",
        new="            steps - motor.offset_steps\n",
        tests=tests_of(
            "tests/armdrive/motion/test_gripper.py",
            "test_opening_and_closing_end_where_asked_while_the_elbow_turns",
        ),
    ),
    Mutant(
        name="guards measure from the wrong side",
        promise="a guard keeps the arm out",
        path="kinematics/guards/__init__.py",
        old='yield Reading("outer radius", "tip radius", tip_r, outer, outer - tip_r)',
        new='yield Reading("outer radius", "tip radius", tip_r, outer, tip_r - outer)',
        tests=tests_of(
            "tests/kinematics/guards/test_guards.py",
            "test_the_outer_radius_is_kept",
        ),
    ),
    Mutant(
        name="the table is no guard",
        promise="the arm stays above its table",
        path="kinematics/guards/__init__.py",
        old="        if self.guards.table:\n",
        new="        if False:\n",
        tests=tests_of(
            "tests/kinematics/guards/test_guards.py",
            "test_the_table_has_a_tolerance",
        ),
    ),
)
