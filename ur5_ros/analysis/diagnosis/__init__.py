"""Which cause explains a residual."""
