"""Files of knowledge: what a database learned, without motion and captions; and the shipped one."""
