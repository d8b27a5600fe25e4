"""Many runs of the loop on Dask: specification, workers, table, summary, report."""
