"""Laws side by side: the same motions, perturbations and gains budget for all."""
