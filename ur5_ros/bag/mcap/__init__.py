"""The MCAP container: records, chunks, index, summary."""
