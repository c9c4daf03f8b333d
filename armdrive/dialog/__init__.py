"""What people are asked: an operator who looks at the arm, and whoever sets one up."""
