"""Knowledge of another database, to start from: what it is, and how own captions join it."""
