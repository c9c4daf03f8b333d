"""Moving an arm: goals, plans, their execution, jogging, the gripper, and tasks while it stands."""
