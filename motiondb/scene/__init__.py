"""From a grammar of actions and a diagram of tactics to scenes of several characters."""
