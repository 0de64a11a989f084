-- What runs changed in captures, so that it can be undone; the files that could not be read.
CREATE TABLE edit (
    run_id BIGINT NOT NULL REFERENCES run (run_id),
    capture_id BIGINT NOT NULL,
    kind VARCHAR NOT NULL CHECK (kind IN ('added', 'changed', 'removed')),
    name VARCHAR NOT NULL,
    tags VARCHAR,
    captions VARCHAR,
    events VARCHAR,
    PRIMARY KEY (run_id, capture_id)
);

CREATE TABLE faulty_file (
    path VARCHAR PRIMARY KEY,
    problem VARCHAR NOT NULL,
    noted VARCHAR NOT NULL
);
