"""`python -m host_tools.bench`: the measurements of docs/reference/benchmarks.md."""
