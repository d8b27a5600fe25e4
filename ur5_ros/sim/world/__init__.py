"""What stands around the arm: shapes, contact points, and the step that solves contact."""
