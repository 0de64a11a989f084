-- Files that `add` has read, so that those that are the same need not be read again.
CREATE TABLE known_file (
    path VARCHAR PRIMARY KEY,
    state VARCHAR NOT NULL,
    options VARCHAR NOT NULL,
    readings VARCHAR NOT NULL
);
