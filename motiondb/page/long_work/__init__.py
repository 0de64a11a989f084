"""Long work in separate processes: the jobs, the worker process, and its commands."""
