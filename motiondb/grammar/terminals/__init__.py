"""From takes to strings of terminals: pose and segment distances, cuts, groups, labelling."""
