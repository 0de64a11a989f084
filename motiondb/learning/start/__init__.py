"""Knowledge of another database as a start: its content, and its combination with own captions."""
