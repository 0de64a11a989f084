-- The first version: everything. What each table holds is told in ../schema.sql.

CREATE TABLE meta (
    key VARCHAR PRIMARY KEY,
    value VARCHAR NOT NULL
);

CREATE TABLE run (
    run_id BIGINT PRIMARY KEY,
    kind VARCHAR NOT NULL,
    parameters VARCHAR NOT NULL,
    seed BIGINT,
    version VARCHAR NOT NULL,
    started VARCHAR NOT NULL,
    finished VARCHAR
);

CREATE TABLE source (
    sha256 VARCHAR PRIMARY KEY,
    format VARCHAR NOT NULL,
    file_name VARCHAR NOT NULL,
    skeleton_name VARCHAR,
    data BLOB USING COMPRESSION uncompressed NOT NULL,
    skeleton_data BLOB USING COMPRESSION uncompressed
);

CREATE TABLE capture (
    capture_id BIGINT PRIMARY KEY,
    name VARCHAR NOT NULL UNIQUE,
    sha256 VARCHAR NOT NULL UNIQUE,
    format VARCHAR NOT NULL,
    kind VARCHAR NOT NULL CHECK (kind IN ('captured', 'generated')),
    fps DOUBLE NOT NULL CHECK (fps > 0),
    n_frames BIGINT NOT NULL CHECK (n_frames >= 0),
    duration DOUBLE NOT NULL CHECK (duration >= 0),
    motion_frames BIGINT NOT NULL CHECK (motion_frames >= 0),
    leg_length DOUBLE NOT NULL,
    path VARCHAR NOT NULL,
    run_id BIGINT NOT NULL REFERENCES run (run_id),
    notes VARCHAR[] NOT NULL,
    motion_notes VARCHAR[] NOT NULL
);

CREATE TABLE capture_tag (
    capture_id BIGINT NOT NULL,
    key VARCHAR NOT NULL,
    value VARCHAR NOT NULL,
    PRIMARY KEY (capture_id, key)
);

CREATE TABLE caption (
    capture_id BIGINT NOT NULL,
    ordinal INTEGER NOT NULL,
    start_s DOUBLE,
    end_s DOUBLE,
    words VARCHAR NOT NULL,
    PRIMARY KEY (capture_id, ordinal)
);

CREATE TABLE synonym (
    word VARCHAR PRIMARY KEY,
    canonical VARCHAR NOT NULL
);

CREATE TABLE motion_frame (
    capture_id BIGINT NOT NULL,
    frame INTEGER NOT NULL,
    pose FLOAT[87] NOT NULL
);

CREATE TABLE relation (
    capture_id BIGINT NOT NULL,
    other_id BIGINT NOT NULL,
    kind VARCHAR NOT NULL CHECK (kind IN ('same', 'mirror', 'cut')),
    start_s DOUBLE NOT NULL,
    end_s DOUBLE NOT NULL,
    distance DOUBLE NOT NULL,
    PRIMARY KEY (capture_id, other_id, kind)
);

CREATE TABLE generated_source (
    capture_id BIGINT NOT NULL,
    ordinal INTEGER NOT NULL,
    source_name VARCHAR NOT NULL,
    source_sha256 VARCHAR NOT NULL,
    licence VARCHAR NOT NULL,
    PRIMARY KEY (capture_id, ordinal)
);

CREATE TABLE frame_source (
    capture_id BIGINT NOT NULL,
    frame INTEGER NOT NULL,
    source_ordinal INTEGER NOT NULL,
    source_frame DOUBLE NOT NULL,
    warp DOUBLE NOT NULL,
    edit VARCHAR NOT NULL
);

CREATE TABLE learning (
    run_id BIGINT NOT NULL REFERENCES run (run_id),
    content_revision VARCHAR NOT NULL,
    n_symbols BIGINT NOT NULL,
    max_states BIGINT NOT NULL,
    n_features BIGINT NOT NULL,
    n_coordinates BIGINT NOT NULL,
    n_clusters BIGINT NOT NULL,
    n_words BIGINT NOT NULL
);

CREATE TABLE segment (
    capture_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    start_frame BIGINT NOT NULL,
    end_frame BIGINT NOT NULL,
    symbol_id BIGINT NOT NULL,
    log_likelihood DOUBLE,
    background DOUBLE,
    run_id BIGINT NOT NULL
);

CREATE TABLE segment_score (
    ordinal BIGINT NOT NULL,
    scores FLOAT[] NOT NULL,
    run_id BIGINT NOT NULL
);

CREATE TABLE symbol (
    symbol_id BIGINT PRIMARY KEY,
    n_states BIGINT NOT NULL,
    cluster_id BIGINT NOT NULL,
    coordinates DOUBLE[] NOT NULL,
    run_id BIGINT NOT NULL
);

CREATE TABLE symbol_state (
    symbol_id BIGINT NOT NULL,
    state BIGINT NOT NULL,
    self_loop DOUBLE,
    means DOUBLE[] NOT NULL,
    covars DOUBLE[] NOT NULL,
    run_id BIGINT NOT NULL,
    PRIMARY KEY (symbol_id, state)
);

CREATE TABLE symbol_distance (
    symbol_id BIGINT NOT NULL,
    other_id BIGINT NOT NULL,
    distance DOUBLE,
    variance DOUBLE,
    run_id BIGINT NOT NULL
);

CREATE TABLE space_stress (
    dimensions BIGINT PRIMARY KEY,
    stress DOUBLE,
    run_id BIGINT NOT NULL
);

CREATE TABLE cluster (
    cluster_id BIGINT PRIMARY KEY,
    weight DOUBLE,
    mean DOUBLE[] NOT NULL,
    covar DOUBLE[] NOT NULL,
    run_id BIGINT NOT NULL
);

CREATE TABLE word (
    word_id BIGINT PRIMARY KEY,
    word VARCHAR NOT NULL UNIQUE,
    count BIGINT NOT NULL,
    run_id BIGINT NOT NULL
);

CREATE TABLE translation (
    symbol_id BIGINT NOT NULL,
    word_id BIGINT NOT NULL,
    probability DOUBLE,
    run_id BIGINT NOT NULL
);

CREATE TABLE alignment (
    l BIGINT NOT NULL,
    m BIGINT NOT NULL,
    j BIGINT NOT NULL,
    probabilities DOUBLE[] NOT NULL,
    run_id BIGINT NOT NULL,
    PRIMARY KEY (l, m, j)
);

CREATE TABLE association_step (
    step BIGINT PRIMARY KEY,
    log_likelihood DOUBLE,
    run_id BIGINT NOT NULL
);

CREATE TABLE transition_count (
    symbol_id BIGINT NOT NULL,
    next_id BIGINT NOT NULL,
    count DOUBLE,
    run_id BIGINT NOT NULL
);

CREATE TABLE parameter (
    name VARCHAR NOT NULL,
    piece BIGINT NOT NULL,
    shape BIGINT[],
    numbers DOUBLE[],
    text VARCHAR,
    run_id BIGINT NOT NULL,
    PRIMARY KEY (name, piece),
    CHECK ((numbers IS NULL) = (shape IS NULL)),
    CHECK ((numbers IS NULL) = (text IS NOT NULL))
);
