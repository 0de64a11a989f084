"""A question in words, understood as a tree: tokens, amounts, parse, tree, say."""
