"""Pictures of scenes and of tactics diagrams."""
