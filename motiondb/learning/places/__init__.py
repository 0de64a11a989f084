"""Where in their takes captions' actions happen, by segments and by frames."""
