-- The grammar learner: what `grammar learn` makes, and how generated sequences were derived.
CREATE TABLE grammar (
    grammar_id BIGINT PRIMARY KEY,
    name VARCHAR NOT NULL UNIQUE,
    start_symbol VARCHAR NOT NULL,
    objective DOUBLE,
    run_id BIGINT NOT NULL REFERENCES run (run_id)
);

CREATE TABLE grammar_source (
    grammar_id BIGINT NOT NULL,
    take BIGINT NOT NULL,
    source_name VARCHAR NOT NULL,
    source_sha256 VARCHAR NOT NULL,
    n_frames BIGINT NOT NULL CHECK (n_frames > 0),
    run_id BIGINT NOT NULL,
    PRIMARY KEY (grammar_id, take)
);

CREATE TABLE terminal (
    grammar_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    name VARCHAR NOT NULL,
    symbol_id BIGINT NOT NULL,
    run_id BIGINT NOT NULL,
    PRIMARY KEY (grammar_id, ordinal),
    UNIQUE (grammar_id, name)
);

CREATE TABLE terminal_segment (
    grammar_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    take BIGINT NOT NULL,
    start_frame BIGINT NOT NULL,
    end_frame BIGINT NOT NULL,
    terminal BIGINT NOT NULL,
    is_medoid BOOLEAN NOT NULL,
    run_id BIGINT NOT NULL
);

CREATE TABLE grammar_rule (
    grammar_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    left_symbol VARCHAR NOT NULL,
    right_symbols VARCHAR[] NOT NULL,
    probability DOUBLE NOT NULL CHECK (probability >= 0 AND probability <= 1),
    run_id BIGINT NOT NULL,
    PRIMARY KEY (grammar_id, ordinal)
);

CREATE TABLE sentence (
    grammar_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    first_segment BIGINT NOT NULL,
    end_segment BIGINT NOT NULL,
    rules BIGINT[] NOT NULL,
    run_id BIGINT NOT NULL,
    PRIMARY KEY (grammar_id, ordinal)
);

CREATE TABLE grammar_bits (
    grammar_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    part VARCHAR NOT NULL,
    bits DOUBLE NOT NULL,
    run_id BIGINT NOT NULL,
    PRIMARY KEY (grammar_id, ordinal)
);

CREATE TABLE derivation (
    capture_id BIGINT PRIMARY KEY,
    grammar_id BIGINT NOT NULL,
    rules BIGINT[] NOT NULL,
    clips BIGINT[] NOT NULL,
    run_id BIGINT NOT NULL
);
