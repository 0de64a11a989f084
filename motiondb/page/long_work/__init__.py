"""Long work in processes of its own: the jobs, the process, what it does."""
