-- What captures lack, as `quality` found it.
CREATE TABLE capture_quality (
    capture_id BIGINT PRIMARY KEY,
    seconds DOUBLE[] NOT NULL,
    untold VARCHAR[] NOT NULL,
    floor DOUBLE NOT NULL,
    flights DOUBLE[] NOT NULL,
    run_id BIGINT NOT NULL REFERENCES run (run_id)
);
CREATE TABLE finding (
    capture_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    kind VARCHAR NOT NULL,
    family VARCHAR NOT NULL CHECK (family IN ('needs', 'fault', 'file')),
    start_s DOUBLE NOT NULL,
    end_s DOUBLE NOT NULL,
    measure DOUBLE NOT NULL,
    unit VARCHAR NOT NULL,
    threshold DOUBLE NOT NULL,
    part VARCHAR NOT NULL,
    sentence VARCHAR NOT NULL,
    place DOUBLE[],
    boxes DOUBLE[] NOT NULL,
    run_id BIGINT NOT NULL REFERENCES run (run_id),
    PRIMARY KEY (capture_id, ordinal)
);
