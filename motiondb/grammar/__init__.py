"""From one long take to the rules of its movements, and back to new motion."""
