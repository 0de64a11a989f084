"""The routes: each calls the public class."""
