"""The checks of the verdict, one subject a file."""
