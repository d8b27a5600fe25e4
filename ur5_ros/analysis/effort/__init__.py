"""What a recorded effort means, and the known arms that fit it."""
