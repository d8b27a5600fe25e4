"""The laws beside the compiled ones, each a short file with its equation and source."""
