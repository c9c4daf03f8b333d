"""What the lecture notes say of a posture, of an arm or of a model alone."""
